"""The benchmarked models are what they stand for; the study's figures and files."""

import functools
import json
import math

import mujoco
import numpy as np
import pytest

from experiments.benchmarks import __main__ as command
from experiments.benchmarks.callback import (
    NumpySheath,
    as_passive_callback,
    bare_bench,
    disagreement,
)
from experiments.benchmarks.frictionloss import (
    compare_frictionloss,
)
from experiments.benchmarks.scaling import (
    FAST,
    SLOW,
    guide_runs,
)
from experiments.benchmarks.study import run_benchmark
from experiments.benchmarks.threads import thread_speedups
from experiments.command import run_experiment
from tendon_mj import view_sheath
from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.models import Bench
from tests.refusals import refusing

WAVE = 1e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 800))
BENCH = Bench()


@pytest.mark.parametrize(("guides", "frequency"), [(16, SLOW), (16, FAST), (128, FAST)])
def test_every_guide_slides_both_ways(guides, frequency):
    run, reference = guide_runs(Bench(), guides, frequency)
    assert reference.model.nplugin == 0
    view, seen = view_sheath(run.model, run.data, "tendon"), []
    for control in run.controls:
        run.data.ctrl[:] = control
        mujoco.mj_step(run.model, run.data)
        seen.append(view.slip)
    assert (np.max(seen, axis=0) == 1.0).all()
    assert (np.min(seen, axis=0) == -1.0).all()
    assert view.unsolved == 0


def test_the_study_writes_its_figures_and_numbers(tmp_path, monkeypatch, capsys):
    quick = functools.partial(run_benchmark, guides=(4, 16, 32), sheaths=(1, 2))
    monkeypatch.setattr(command, "run_benchmark", quick)
    arguments = ["--out", str(tmp_path), "--rounds", "1"]
    assert run_experiment(command.benchmarks, "benchmarks", arguments) == 0
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    exponents = {"guide_scaling_exponent", "sheath_scaling_exponent"}
    assert result.keys() >= exponents | {"thread_speedup", "callback_ratio", "threads", "cores"}
    assert result["cost_parts"]["empty_plugin_s"] is not None
    assert result["callback"]["largest_tension_difference"] < 1e-9
    assert result["callback"].keys() >= {"ratio", "callback_added_s", "plugin_added_s"}
    assert result["callback_ratio"] > 1.0
    assert result["frictionloss"]["output_tension"]["max_relative_error"] > 0.1
    for picture in ("scaling", "parts"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000
    assert "floor: an empty plugin" in capsys.readouterr().out
    with refusing(InvalidValueError, "rounds = 0"):  # before anything is timed
        run_benchmark(rounds=0)


TIME = np.linspace(0.0, 1.0, 1500)
NO_PERIOD = 4e-4 * sum(np.sin(2.0 * np.pi * rate * TIME) for rate in (1.0, np.sqrt(2.0), np.e))


@pytest.mark.parametrize("guides", [1, 2, 16, 40])
@pytest.mark.parametrize(("friction", "wave"), [(0.02, WAVE), (0.15, NO_PERIOD), (0.6, WAVE)])
def test_its_tensions_are_the_plugin_s(guides, friction, wave):
    assert disagreement(Bench(guides=guides, friction=friction), wave) < 1e-9


def test_every_guide_keeps_the_capstan_law_and_does_so_again_after_a_reset():
    bench = Bench(guides=12)
    model = bare_bench(bench).compile()
    sheath, ends = NumpySheath(model, bench), []
    most = bench.exponent / bench.guides
    with as_passive_callback(sheath):
        for _ in range(2):
            sheath.reset()
            data = mujoco.MjData(model)
            for control in WAVE:
                data.ctrl[0] = control
                mujoco.mj_step(model, data)
                fall = np.log(sheath.tension[:-1] / sheath.tension[1:])
                assert np.abs(fall).max() <= most * (1.0 + 1e-9)
            ends.append(sheath.tension.copy())
    assert sheath.unsolved == 0
    np.testing.assert_array_equal(*ends)


def test_the_process_has_no_callback_afterwards_and_keeps_another_s():
    def fail():
        with as_passive_callback(lambda m, d: None):
            assert mujoco.get_mjcb_passive() is not None
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert mujoco.get_mjcb_passive() is None

    def theirs(model, data):
        """Of another."""

    mujoco.set_mjcb_passive(theirs)
    try:
        with refusing(EngineError, "already has an mjcb_passive"), as_passive_callback(theirs):
            pass
        assert mujoco.get_mjcb_passive() is theirs
    finally:
        mujoco.set_mjcb_passive(None)


def test_the_sheath_follows_the_capstan_law_and_frictionloss_does_not():
    result = compare_frictionloss(BENCH, rounds=1)
    assert result.force == pytest.approx(BENCH.pretension * (1.0 - math.exp(-BENCH.exponent)))
    assert result.sheath_error.largest < 0.002
    # T_in − F where F is right at half of T_in: (1 + e^{−λ})/2 over e^{−λ}
    ratio = 0.5 * (1.0 + math.exp(BENCH.exponent))
    assert result.error.at_most == pytest.approx(ratio - 1.0, abs=0.01)
    assert result.error.largest >= result.error.rms > 0.1
    assert result.default_error.largest > result.error.largest


def test_rollouts_are_compared_for_each_number_of_threads():
    speedups = thread_speedups(Bench(guides=4), (2, 3), rounds=1, runs=4, steps=200)
    assert set(speedups) == {2, 3}  # the same as on one thread to the bit, or it had refused
    assert min(speedup.median for speedup in speedups.values()) > 0.0
