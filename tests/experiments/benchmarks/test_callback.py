"""The NumPy callback is the plugin's sheath, and leaves nothing behind in the process."""

import dataclasses

import mujoco
import numpy as np
import pytest

from experiments.benchmarks.callback import (
    NumpySheath,
    as_passive_callback,
    bare_bench,
    callback_cost,
    disagreement,
)
from tendon_mj.errors import EngineError
from tendon_mj.models import Bench

WAVE = 1e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 800))


@pytest.mark.parametrize("guides", [1, 2, 16, 40])
@pytest.mark.parametrize("friction", [0.02, 0.15, 0.6])
def test_its_tensions_are_the_plugin_s(guides, friction):
    assert disagreement(Bench(guides=guides, friction=friction), WAVE) < 1e-9


def test_they_are_alike_in_motion_that_has_no_period():
    time = np.linspace(0.0, 1.0, 1500)
    wave = sum(np.sin(2.0 * np.pi * rate * time) for rate in (1.0, np.sqrt(2.0), np.e))
    assert disagreement(Bench(), 4e-4 * wave) < 1e-9


def test_every_guide_keeps_the_capstan_law():
    bench = Bench(guides=12)
    model = bare_bench(bench).compile()
    data, sheath = mujoco.MjData(model), NumpySheath(model, bench)
    most = bench.exponent / bench.guides
    with as_passive_callback(sheath):
        for control in WAVE:
            data.ctrl[0] = control
            mujoco.mj_step(model, data)
            fall = np.log(sheath.tension[:-1] / sheath.tension[1:])
            assert np.abs(fall).max() <= most * (1.0 + 1e-9)
    assert sheath.unsolved == 0


def test_after_a_reset_it_does_the_same_again():
    bench = Bench(guides=5)
    model = bare_bench(bench).compile()
    sheath, ends = NumpySheath(model, bench), []
    with as_passive_callback(sheath):
        for _ in range(2):
            sheath.reset()
            data = mujoco.MjData(model)
            for control in WAVE[:200]:
                data.ctrl[0] = control
                mujoco.mj_step(model, data)
            ends.append(sheath.tension.copy())
    np.testing.assert_array_equal(*ends)


def test_the_process_has_no_callback_afterwards():
    with as_passive_callback(lambda model, data: None):
        assert mujoco.get_mjcb_passive() is not None
    assert mujoco.get_mjcb_passive() is None
    with pytest.raises(RuntimeError, match="inside"), as_passive_callback(lambda m, d: None):
        raise RuntimeError("inside")
    assert mujoco.get_mjcb_passive() is None


def test_somebody_else_s_callback_is_not_taken_away():
    def theirs(model, data):
        """Of another."""

    mujoco.set_mjcb_passive(theirs)
    try:
        with (
            pytest.raises(EngineError, match="already has an mjcb_passive"),
            as_passive_callback(lambda model, data: None),
        ):
            pass
        assert mujoco.get_mjcb_passive() is theirs
    finally:
        mujoco.set_mjcb_passive(None)


def test_the_cost_comes_with_the_agreement():
    cost = callback_cost(dataclasses.replace(Bench(), guides=4), rounds=1, steps=800)
    assert cost.disagreement < 1e-9
    assert cost.callback.median > cost.plugin.median
    assert set(cost.result()) >= {"ratio", "callback_added_s", "plugin_added_s"}
    assert mujoco.get_mjcb_passive() is None
