"""Laws of the bend of a drawn path: it and ``extra_bend`` add up, whoever is set first."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from tendon_mj.attach import add_friction, view_sheath
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.recordings import Uncertain
from tendon_mj.lab.replay import (
    Adjustable,
    Simulator,
    patch_model,
    read_intervals,
    replay_recording,
)
from tendon_mj.models import load_model
from tests.lab.replay.rigs import TENSION, bench
from tests.refusals import refusing
from tests.rigs import rope

DRAWN, EXTRA = "sheath.drawn_bend", "sheath.extra_bend"
PATH_BEND = Adjustable(load_model("bench")).parameters()[DRAWN].value


def tension(values: Mapping[str, float], **more: object) -> NDArray[np.float64]:
    return Simulator([bench("bend", **more)], threads=1)([values])[0][0][TENSION]


def bends(adjustable: Adjustable) -> tuple[float, float]:
    parameters = adjustable.parameters()
    return parameters[DRAWN].value, parameters[EXTRA].value


def test_it_is_the_sum_of_the_bends_at_the_guides_in_the_initial_pose() -> None:
    model = load_model("joint")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    parameters = Adjustable(model).parameters()
    for name in ("sheath_1", "sheath_2"):
        parameter = parameters[f"{name}.drawn_bend"]
        assert parameter.value == pytest.approx(view_sheath(model, data, name).bend_angle.sum())
        assert (parameter.unit, parameter.kind, parameter.low) == ("rad", "live", 0.0)
    assert pytest.approx(np.pi, rel=1e-9) == PATH_BEND


@pytest.mark.parametrize("extra", [0.0, 0.7])
def test_its_own_value_changes_nothing_to_the_bit(extra: float) -> None:
    np.testing.assert_array_equal(
        tension({EXTRA: extra, DRAWN: PATH_BEND}), tension({EXTRA: extra})
    )


@pytest.mark.parametrize("more", [-1.5, 0.25, 2.0])
def test_what_the_path_bends_more_is_what_is_added(more: float) -> None:
    drawn = tension({DRAWN: PATH_BEND + more, EXTRA: 0.7})
    added = tension({EXTRA: 0.7 + more})
    np.testing.assert_allclose(drawn, added, rtol=1e-12)
    assert np.abs(added - tension({EXTRA: 0.7})).max() > 0.1


def test_the_order_of_setting_does_not_matter() -> None:
    live = set()
    for order in itertools.permutations([{DRAWN: 2.0}, {EXTRA: 0.5}, {"sheath.friction": 0.2}]):
        adjustable = Adjustable(load_model("bench"))
        for values in order:
            adjustable.set(values)
        assert bends(adjustable) == (pytest.approx(2.0, rel=1e-15), 0.5)
        live.add(tuple(adjustable.data.plugin_state))
    for both in ({DRAWN: 2.0, EXTRA: 0.5}, {EXTRA: 0.5, DRAWN: 2.0}):
        adjustable = Adjustable(load_model("bench"))
        adjustable.set({DRAWN: 3.0, EXTRA: 1.5})  # what was set before leaves no trace
        adjustable.set(both | {"sheath.friction": 0.2})
        live.add(tuple(adjustable.data.plugin_state))
    assert len(live) == 1


def test_a_recording_may_know_it_or_hold_it_for_uncertain() -> None:
    expected = tension({EXTRA: 2.0 - PATH_BEND})
    known = {"sheath*.drawn_bend": 2.0}
    np.testing.assert_allclose(tension({}, known=known), expected, rtol=1e-12)
    uncertain = {DRAWN: Uncertain(2.0, 1.0, 3.0)}
    np.testing.assert_allclose(tension({}, uncertain=uncertain), expected, rtol=1e-12)


@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
def test_a_bend_below_zero_is_refused(value: float) -> None:
    with refusing(InvalidValueError, f"{DRAWN} = {value:g}"):
        Adjustable(load_model("bench")).set({DRAWN: value})


OVER_A_DRUM = rope(
    "a -1 0 .1; side 0 0 1",
    "b",
    "a drum@side b",
    tendon='stiffness="1000" springlength="1"',
    body='pos="1 0 -1"',
    joint='name="slide" type="slide"',
    geom='size=".1"',
    world='<geom name="drum" type="cylinder" size=".3 .1" euler="90 0 0"/>',
    actuator="",
)


def test_a_sheath_that_could_not_take_it_up_does_not_have_it() -> None:
    spec = mujoco.MjSpec.from_string(OVER_A_DRUM)
    add_friction(spec, "t", name="sheath", friction=0.1)
    adjustable = Adjustable(spec.compile())
    adjustable.set({"sheath.friction": 0.2})
    assert DRAWN not in adjustable.names()
    with refusing(UnknownNameError, DRAWN):
        adjustable.set({DRAWN: 1.0})


def test_a_wrap_in_the_initial_pose_is_a_bend_of_the_path() -> None:
    spec = mujoco.MjSpec.from_string(OVER_A_DRUM)
    add_friction(spec, "t", name="sheath", friction=0.1, inner_guides=2)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start, end = data.wrap_xpos.reshape(-1, 3)[1:3]  # where the tendon meets the drum and leaves it
    turn = np.arccos(start @ end / np.linalg.norm(start) / np.linalg.norm(end))
    adjustable = Adjustable(model)
    assert adjustable.parameters()[DRAWN].value == pytest.approx(turn, rel=1e-6)
    adjustable.set({DRAWN: 1.5})
    assert view_sheath(model, adjustable.data, "sheath").extra_bend == pytest.approx(1.5 - turn)


def test_a_patched_model_moves_as_was_simulated_and_has_both_bends(tmp_path: Path) -> None:
    given = {DRAWN: 2.0, EXTRA: 0.5}
    within = {DRAWN: (1.9, 2.2), EXTRA: (0.4, 0.6)}
    path = patch_model("bench", given, tmp_path / "m.xml", intervals=within)
    written = load_model(str(path))
    told = replay_recording(bench("bend"), written).columns[TENSION]
    np.testing.assert_allclose(told, tension(given), rtol=1e-12)
    assert bends(Adjustable(written)) == pytest.approx((2.0, 0.5), rel=1e-12)
    assert read_intervals(written) == within
    assert "sheath.drawn_bend = 2 [rad], 1.9 … 2.2" in path.read_text("utf-8")


def test_what_a_recording_adds_comes_on_top_of_a_patched_path(tmp_path: Path) -> None:
    path = patch_model("bench", {DRAWN: 2.0}, tmp_path / "m.xml")
    state = bench("bend", known={EXTRA: 1.0})
    told = replay_recording(state, load_model(str(path))).columns[TENSION]
    np.testing.assert_allclose(told, tension({DRAWN: 2.0, EXTRA: 1.0}), rtol=1e-12)
    again = patch_model(path, {DRAWN: 2.5}, tmp_path / "again.xml")
    simulated = Simulator([dataclasses.replace(state, known={})], load_model(str(again)))([{}])
    np.testing.assert_allclose(simulated[0][0][TENSION], tension({DRAWN: 2.5}), rtol=1e-12)
