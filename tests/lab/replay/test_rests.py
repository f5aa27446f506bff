"""Laws of a replay of rests: what is read is the state at rest, however it is come to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, replay_recording, simulation
from tests.lab.diagnosis.settled_rigs import FINGER, LEVER, SETTLING, settled, stairs, write_rig

POINTS = stairs(low=0.0, high=0.012, steps=4, rows=9)
SPANS = {"lever_rad": 0.4, "pull_N": 15.0, "knuckle_rad": 0.7, "middle_rad": 0.7}
LEVER_READS = {"lever_rad": ("lever", None), "pull_N": ("input_tension", None)}
FINGER_READS = {"knuckle_rad": ("knuckle", None), "middle_rad": ("middle", None)}


@pytest.fixture(scope="module")
def lever(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lever")
    return write_rig(LEVER, folder, friction=0.2, axial_stiffness=3e3, pretension=1.0)


@pytest.fixture(scope="module")
def finger(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("finger")
    return write_rig(FINGER, folder, friction=0.15, axial_stiffness=2e3, pretension=0.5)


def off(one: Recording, other: Recording) -> float:
    """Largest difference of the readings, over what each spans."""
    return max(
        float(np.abs(one.columns[c] - other.columns[c]).max()) / SPANS[c] for c in one.measured
    )


def test_rests_are_those_of_plain_steps_at_a_slow_speed_of_the_drive(lever, finger) -> None:
    for rig, reads in ((lever, LEVER_READS), (finger, FINGER_READS)):
        truth = settled(rig, POINTS, reads, {}, 1)
        assert off(replay_recording(truth), truth) < 2e-3


def test_friction_remembers_from_where_a_point_was_come_to(lever: Path) -> None:
    truth = settled(lever, POINTS, LEVER_READS, {}, 1)
    pull = replay_recording(truth).columns["pull_N"]
    up, down = pull[2], pull[4]
    assert POINTS[2] == POINTS[4]
    assert down < 0.7 * up


def test_the_times_of_rows_count_for_what_drifts_alone(lever: Path) -> None:
    made = settled(lever, POINTS, LEVER_READS, {}, 1)
    numbered = replace(made, time=np.arange(POINTS.size, dtype=float))
    slow = replace(made, time=1e4 * numbered.time)
    first, second = replay_recording(numbered), replay_recording(slow)
    assert off(first, second) == 0.0
    drift = {"sheath.friction_drift": 1e-5}  # by 0.8 in all of the slow one
    rubbed = replay_recording(slow, parameters=drift).columns["pull_N"]
    assert np.abs(rubbed - second.columns["pull_N"])[-1] > 0.1
    assert off(replay_recording(numbered, parameters=drift), first) < 1e-3
    drift = {"lever.drift": 1e-3}
    read = replay_recording(slow, parameters=drift).columns["lever_rad"]
    np.testing.assert_allclose(read - second.columns["lever_rad"], 1e-3 * slow.time, atol=1e-12)


def test_a_rest_ends_when_nothing_moves_any_more_and_reads_the_same(
    lever: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stepped = []

    def counted(model, data, control, readings):
        stepped.append(len(control))
        return step(model, data, control, readings)

    step = simulation._step
    monkeypatch.setattr(simulation, "_step", counted)
    made = replace(settled(lever, POINTS, LEVER_READS, {}, 1), settling_time=20.0)
    short = replay_recording(made)
    few = sum(stepped)
    stepped.clear()
    monkeypatch.setattr(simulation, "_RESTS", -1.0)
    whole = replay_recording(made)
    assert few < 0.5 * sum(stepped)
    assert off(short, whole) < 1e-4


def test_what_has_not_come_to_rest_in_the_settling_time_is_read_as_it_is_then(lever: Path) -> None:
    made = settled(lever, POINTS, LEVER_READS, {}, 1)
    slow = {"lever.damping": 2.0}  # a time constant of seconds
    soon, late = (
        replay_recording(replace(made, settling_time=s), parameters=slow) for s in (0.5, 60.0)
    )
    assert off(soon, late) > 0.05
    assert off(late, replay_recording(made)) < 0.02


def test_delays_and_lags_do_nothing_to_what_rests(lever: Path) -> None:
    made = settled(lever, POINTS, LEVER_READS, {}, 1)
    plain = replay_recording(made)
    late = {"lever.lag": 0.1, "lever.delay": 0.2, "reel.command_delay": 0.2}
    assert off(replay_recording(made, parameters=late), plain) < 1e-4


def test_a_simulation_of_rests_is_their_replay_to_the_bit(lever: Path) -> None:
    made = settled(lever, POINTS, LEVER_READS, {}, 1)
    shown = replay_recording(made, progress=lambda _: None)
    for strict in (False, True):
        ((series,),) = Simulator([made], strict=strict)([{}])
        for column in made.measured:
            np.testing.assert_array_equal(series[column], shown.columns[column])
    assert shown.settling_time == SETTLING
