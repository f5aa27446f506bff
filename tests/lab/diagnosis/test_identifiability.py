"""Identifiability: limits that follow from the noise, twins, and further columns that decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.errors import RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis import CATALOGUE, SMALLEST_EXCESS, Identifiability, identify
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import Simulator, replay_error, replay_recording
from tests.lab.replay.rigs import TENSION, bench
from tests.refusals import refusing

NOISE, INPUT = 0.5, "input_tension_N"


def planned(signals: Sequence[str] = (TENSION, INPUT), **more: object) -> Recording:
    """The bench with two load cells, before anything was recorded."""
    plan = bench("plan")
    sensors = {TENSION: "output_tension", INPUT: "input_tension"}
    return replace(
        plan,
        columns={**plan.columns, **{column: np.zeros(plan.time.size) for column in signals}},
        measured={column: Measured(sensors[column], NOISE) for column in signals},
        **more,
    )


def judged(signals: Sequence[str], *effects: str, **more: object) -> Identifiability:
    return identify([planned(**more)], signals, catalogue={e: CATALOGUE[e] for e in effects})


def test_an_offset_is_noticed_where_its_mean_square_is_the_detection_limit():
    (bias,) = judged([TENSION], "sensor_bias").effects
    assert bias.parameter == "output_tension.offset"
    assert bias.noticed == pytest.approx(NOISE * np.sqrt(SMALLEST_EXCESS), rel=1e-3)
    assert bias.named == pytest.approx(2.0 * bias.noticed)


def test_the_uncertain_numbers_take_their_part_before_an_effect_is_noticed():
    """What a pretension leaves of an offset is less than the offset."""
    free = {"sheath.pretension": Uncertain(20.0, 10.0, 40.0)}
    (alone,) = judged([TENSION], "sensor_bias").effects
    (beside,) = judged([TENSION], "sensor_bias", uncertain=free).effects
    assert beside.noticed > 1.5 * alone.noticed


def test_twins_are_not_told_apart_and_change_the_readings_alike():
    found = judged([TENSION], "friction", "bend_angle")
    (pair,) = found.untold
    assert set(pair.effects) == {"friction (sheath)", "bend_angle (sheath)"}
    assert pair.below is None
    assert "posture" in pair.decided_by
    assert all(effect.named is None for effect in found.effects)
    friction, bend = found.effects
    own = Simulator([planned()]).parameters
    readings = [
        replay_recording(planned(), parameters={e.parameter: own[e.parameter].value + e.noticed})
        for e in (friction, bend)
        if e.noticed is not None
    ]
    assert replay_error(*readings)[TENSION].rmse < NOISE


def test_a_column_that_decides_is_proposed_and_decides():
    late = ("command_delay", "sensor_delay")
    (pair,) = judged([TENSION], *late).untold
    assert pair.decided_by == f"measure {INPUT} too"
    both = judged([], *late)
    assert both.signals == (TENSION, INPUT)
    assert all(effect.named is not None for effect in both.effects)
    assert not both.untold


def test_what_changes_no_reading_is_not_noticed():
    found = judged([TENSION], "gravity_load", "sensor_gain")
    noticed = {effect.label for effect in found.effects if effect.noticed is not None}
    assert noticed == {"sensor_gain (output_tension)", "gravity_load (gravity.x)"}
    assert len(found.effects) == 4  # two axes across the slide, and no sensor that is not recorded


def test_a_number_is_determined_or_not_and_by_how_much():
    """An interval is in proportion to the noise; that of what changes nothing is its range."""
    free = {
        "sheath.pretension": Uncertain(20.0, 10.0, 40.0),
        "sheath.axial_damping": Uncertain(1e-6, 0.0, 2e-6),
    }
    found = judged([TENSION], "sensor_bias", uncertain=free)
    pretension, damping = found.numbers
    assert pretension.determined
    assert pretension.half_then > pretension.half
    assert not damping.determined
    assert damping.half == 1e-6
    assert "an effect that is not fitted may move them" in found.sentence


def test_what_is_not_measured_is_refused_with_the_names():
    with refusing(UnknownNameError, "'lever_deg'", TENSION, INPUT):
        identify([planned()], ["lever_deg"])
    with refusing(RecordingError, "plan", "[measured]"):
        identify([replace(bench("plan"), measured={})])
