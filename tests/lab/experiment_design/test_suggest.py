"""Suggestions on a rig whose every answer is known beforehand."""

from __future__ import annotations

from functools import partial

import numpy as np

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.experiment import DriveBounds, ExperimentBounds, check_bounds
from tendon_mj.lab.experiment_design import Suggestion, suggest_experiment
from tendon_mj.lab.recordings import Measured, Uncertain
from tests.lab.diagnosis import test_alternatives as angle_alone
from tests.lab.experiment_design.rig import (
    DRIVE,
    INPUT,
    NOISE,
    PRETENSION,
    TENSION,
    ShapedRig,
    Shapes,
    bounds,
    diagnosed,
    record,
)
from tests.refusals import refusing

A, B, C = "sheath.a", "sheath.b", "sheath.c"
KINK = 1.0  # mm, beyond the amplitude that was recorded
# a and b are the same below the kink
ALIKE_WHEN_SMALL: Shapes = {A: lambda _, x: x, B: lambda _, x: np.clip(x, -KINK, KINK)}
# the same everywhere but for a factor
ALIKE: Shapes = {A: lambda _, x: x, B: lambda _, x: 3.0 * x}


def suggested(shapes: Shapes, truth: dict[str, float], within: ExperimentBounds) -> Suggestion:
    """Suggestion after recordings of half a millimetre."""
    train, held_out = [record("a", shapes, truth)], [record("bb", shapes, truth, amplitude=4e-4)]
    found = diagnosed(train, held_out, shapes, "a", "b")
    assert found.indistinguishable
    return suggest_experiment(found, within, partial(ShapedRig, shapes=shapes))


def test_where_two_effects_differ_beyond_what_was_recorded_the_suggestion_goes_there() -> None:
    found = suggested(ALIKE_WHEN_SMALL, {B: 3.0}, bounds())
    assert found.recording is not None
    (difference,) = found.differences
    assert difference.recorded < 0.1
    assert difference.expected > 5.0
    assert np.abs(found.recording.columns[DRIVE]).max() > 1.5 * KINK * 1e-3
    assert "a (sheath) and b (sheath) differ by" in found.sentence


def test_the_truth_under_the_suggested_drive_decides() -> None:
    truth = {B: 3.0}
    found = suggested(ALIKE_WHEN_SMALL, truth, bounds())
    assert found.recording is not None
    new = record("next", ALIKE_WHEN_SMALL, truth, like=found.recording)
    train = [record("a", ALIKE_WHEN_SMALL, truth), new]
    held_out = [record("bb", ALIKE_WHEN_SMALL, truth, amplitude=4e-4)]
    again = diagnosed(train, held_out, ALIKE_WHEN_SMALL, "a", "b")
    assert again.effects == ["b"]
    assert again.indistinguishable == []


def test_what_a_fit_of_the_rival_absorbs_is_no_difference() -> None:
    """Of a factor of 3 between shapes nothing remains; at the fitted strengths they coincide."""
    found = suggested(ALIKE, {B: 1.0}, bounds())
    assert found.recording is None
    (difference,) = found.differences
    assert difference.expected < 0.45
    assert "No experiment within the bounds tells apart" in found.sentence
    below_the_kink = bounds(0.9 * KINK * 1e-3)
    assert suggested(ALIKE_WHEN_SMALL, {B: 3.0}, below_the_kink).recording is None


def test_a_sensor_that_could_be_read_is_asked_for_where_only_it_decides() -> None:
    """Effects that are alike at the output; at the input one is felt alone."""
    truth, further = {B: 1.0}, {INPUT: Measured("input_tension", NOISE)}
    found = suggested(ALIKE, truth, bounds(measure=further))
    assert found.recording is not None
    assert found.recording.measured.keys() == {TENSION, INPUT}
    assert "measure input_tension too" in found.sentence
    new = record("next", ALIKE, truth, like=found.recording)
    made = [record("a", ALIKE, truth), record("bb", ALIKE, truth, amplitude=4e-4)]
    again = diagnosed([made[0], new], made[1:], ALIKE, "a", "b")
    assert again.effects == ["b"]
    assert again.indistinguishable == []


def test_the_alternative_of_an_undetermined_verdict_is_told_from_the_model() -> None:
    """By an angle play turns the joint as friction does; the tension shows friction alone."""
    undetermined, name = angle_alone.diagnosed(), angle_alone.TENSION
    within = ExperimentBounds(
        drive={"input_displacement_m": DriveBounds(-1e-3, 1e-3, rate=0.01, dwell=1.0)},
        measure={name: Measured("input_tension", angle_alone.NOISE[name])},
    )
    found = suggest_experiment(undetermined, within, angle_alone.Rig)
    (difference,) = found.differences
    assert (difference.one, difference.other) == ("nothing missing", "backlash (sheath)")
    assert difference.decided
    assert "measure input_tension too" in found.sentence


def test_a_sensor_is_not_asked_for_where_the_others_decide() -> None:
    further = {INPUT: Measured("input_tension", NOISE)}
    found = suggested(ALIKE_WHEN_SMALL, {B: 3.0}, bounds(measure=further))
    assert found.recording is not None
    assert found.recording.measured.keys() == {TENSION}


def test_a_limit_on_a_reading_is_kept_by_every_explanation() -> None:
    free = suggested(ALIKE_WHEN_SMALL, {B: 3.0}, bounds())
    held = suggested(ALIKE_WHEN_SMALL, {B: 3.0}, bounds(limits={TENSION: (10.0, 24.5)}))
    assert held.recording is not None
    assert free.recording is not None
    highest = [r.columns[DRIVE].max() for r in (held.recording, free.recording)]
    assert 20.0 + 3.0 * highest[0] / 1e-3 <= 24.5 + 0.5
    assert highest[1] > highest[0]


def test_a_state_that_the_user_can_set_is_used_where_only_it_decides() -> None:
    """The pretension stretches the way to the kink."""
    narrow = 0.6e-3
    found = suggested(ALIKE_WHEN_SMALL, {B: 3.0}, bounds(narrow, states={PRETENSION: (10.0, 60.0)}))
    assert found.recording is not None
    assert found.recording.known[PRETENSION] > 20.0 * KINK * 1e-3 / narrow
    assert f"{PRETENSION} = {found.recording.known[PRETENSION]:g}" in found.sentence


def test_values_that_trade_places_get_an_experiment_that_separates_them() -> None:
    """Two uncertain numbers of which only the sum shows below the kink."""
    wide = {name: Uncertain(1.0, 0.0, 4.0) for name in (A, B)}
    truth = {A: 2.0, B: 1.5}
    made = [
        record(name, ALIKE_WHEN_SMALL, truth, uncertain=wide, amplitude=amplitude)
        for name, amplitude in (("a", 0.5e-3), ("bb", 0.4e-3))
    ]
    shapes: Shapes = {**ALIKE_WHEN_SMALL, C: lambda t, _: np.sin(40.0 * t)}
    found = diagnosed(made[:1], made[1:], shapes, "c")
    assert not found.calibrated[A].determined
    next_one = suggest_experiment(found, bounds(), partial(ShapedRig, shapes=shapes))
    (difference,) = next_one.differences
    assert difference.one.startswith(f"{A} = ")
    assert difference.decided
    assert next_one.recording is not None
    new = record("next", shapes, truth, uncertain=wide, like=next_one.recording)
    again = diagnosed([made[0], new], made[1:], shapes, "c")
    for name, value in truth.items():
        got = again.calibrated[name]
        assert got.determined
        assert got.low <= value <= got.high
        assert got.high - got.low < 0.2


def test_where_nothing_ties_nothing_is_suggested() -> None:
    shapes: Shapes = {A: lambda _, x: x, B: lambda _, x: x**2}
    made = [record(name, shapes, {B: 3.0}) for name in ("a", "bb")]
    found = diagnosed(made[:1], made[1:], shapes, "a", "b")
    assert found.effects == ["b"]
    nothing = suggest_experiment(found, bounds(), partial(ShapedRig, shapes=shapes))
    assert nothing.recording is None
    assert nothing.differences == ()
    assert "Nothing ties" in nothing.sentence


def test_the_suggestion_is_the_same_each_time() -> None:
    one, other = (suggested(ALIKE_WHEN_SMALL, {B: 3.0}, bounds()) for _ in range(2))
    assert one.recording == other.recording
    assert one.result() == other.result()


def test_bounds_of_another_rig_and_of_what_is_fitted_are_refused() -> None:
    """A parameter that is uncertain in the recordings has one value for all."""
    make = partial(ShapedRig, shapes=ALIKE_WHEN_SMALL)
    uncertain = {PRETENSION: Uncertain(20.0, 10.0, 30.0)}
    made = [record("a", ALIKE_WHEN_SMALL, {B: 3.0}, uncertain=uncertain)]
    misspelt = ExperimentBounds(drive={"input_displacment_m": DriveBounds(0.0, 1.0, 1.0)})
    for within, name in (
        (misspelt, DRIVE),
        (bounds(states={"sheath.pretensoin": (1.0, 2.0)}), PRETENSION),
        (bounds(limits={"output_tensoin_N": (1.0, 2.0)}), TENSION),
    ):
        with refusing(UnknownNameError, f"did you mean {name!r}"):
            check_bounds(made, within, make)
    with refusing(InvalidValueError, repr(PRETENSION), "uncertain"):
        check_bounds(made, bounds(states={PRETENSION: (10.0, 60.0)}), make)
