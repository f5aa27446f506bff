"""Diagnosis of settled points: few rows, each of which is a reading of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis import Problem, candidates, check_recordings, describe_system, diagnose
from tendon_mj.lab.diagnosis.data import training_samples
from tendon_mj.lab.diagnosis.limits import chance_excess
from tendon_mj.lab.diagnosis.regimes import regimes
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Parameter, Simulates, Simulator
from tests.lab.diagnosis.settled_rigs import FINGER, LEVER, settled, stairs, write_rig
from tests.lab.diagnosis.toy import problem_of
from tests.lab.recorded import recorded
from tests.refusals import refusing

NOISE = 0.1
READS = {"lever_rad": ("lever", 0.005), "pull_N": ("input_tension", NOISE)}
KNOWN = {"sheath.axial_stiffness": 3e3, "sheath.pretension": 1.0}


class Still(Simulates):
    """Simulator of readings that are 0."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        self.recordings = recordings
        self.parameters = {"rig.nothing": Parameter(0.0, "-", "live")}

    def __call__(self, sets):
        answer = [{c: np.zeros(r.time.size) for c in r.measured} for r in self.recordings]
        return [answer for _ in sets]


def points(rows: int, *, seed: int = 1, noise: float | None = NOISE, **more: object) -> Recording:
    """Readings of noise alone, at points up and down a stair."""
    return recorded(
        np.arange(rows, dtype=float),
        {"reel_m": ("reel", stairs(low=0.0, high=1.0, steps=5, rows=rows))},
        {"pull_N": ("input_tension", noise, np.random.default_rng(seed).normal(0.0, NOISE, rows))},
        name=f"points_{seed}",
        **{"settling_time": 2.0, **more},
    )


def test_twenty_rests_are_enough_in_all_recordings_and_ten_to_prove() -> None:
    check_recordings([points(20)], [points(10, seed=2)])
    check_recordings([points(12), points(8, seed=3)], [])
    for train, held_out, rows in (([points(19)], [], 19), ([points(20)], [points(9, seed=2)], 9)):
        with refusing(RecordingError, "'points_", f"only {rows} settled points"):
            check_recordings(train, held_out)


def test_rests_without_a_noise_need_repeats() -> None:
    check_recordings([points(24, noise=None)], [])
    made = points(24, noise=None)
    growing = np.arange(24.0) * np.resize([1.0, -1.0], 24)
    with refusing(RecordingError, "'points_1'", "'pull_N'", " 0 rests repeat"):
        check_recordings([replace(made, columns={**made.columns, "reel_m": growing})], [])


def test_rests_are_divided_by_their_rows_whatever_their_times() -> None:
    made = points(24)
    paused = replace(made, time=np.append(made.time[:-1], 1e4))
    for recording in (made, paused):
        (mask,) = training_samples([recording], [])
        assert mask.tolist() == [True] * 18 + [False] * 6
        blocks = Problem((recording,), Still([recording]), (mask,)).blocks
        assert np.bincount(blocks).tolist() == [2] * 12


def test_the_direction_at_a_rest_is_that_of_the_move_before_and_no_speed_is_told() -> None:
    direction, *others = regimes([points(20)])[0]
    expected = np.sign(np.diff(points(20).columns["reel_m"], prepend=0.0)).astype(int) + 1
    assert direction.bins.tolist() == expected.tolist()
    assert {"speed", "time at rest"}.isdisjoint(regime.name for regime in others)


@pytest.mark.parametrize("noise", [NOISE, None])
def test_chance_leaves_more_than_its_limit_in_one_of_a_hundred_right_models(
    noise: float | None,
) -> None:
    more = 0
    for seed in range(1000):
        made = points(24, seed=seed, noise=noise)
        problem = problem_of(Still, [made])
        excess = float(np.mean(problem.residuals([{}]) ** 2)) - 1.0
        more += excess > chance_excess(problem, 24)
    assert 1 <= more <= 25


def test_of_samples_of_a_motion_chance_is_no_limit() -> None:
    made = points(60, settling_time=None)
    assert chance_excess(problem_of(Still, [made]), 60) == 0.0


@pytest.fixture(scope="module")
def lever(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lever")
    return write_rig(LEVER, folder, friction=0.0, axial_stiffness=3e3, pretension=1.0)


def measure(lever: Path, seed: int, rows: int, **hidden: float) -> Recording:
    """Points on the way up, and let off at once."""
    reel = np.resize(np.linspace(0.0, 0.015, 6), rows)
    return settled(lever, reel, READS, hidden, seed, known=KNOWN)


def test_friction_of_a_cable_is_named_from_24_rows_with_its_value_in_the_interval(
    lever: Path,
) -> None:
    hidden = {"sheath.friction": 0.2}
    train, held_out = measure(lever, 1, 24, **hidden), measure(lever, 2, 12, **hidden)
    result = diagnose([train], [held_out])
    assert (result.verdict, result.effects) == ("named", ["sheath_friction"])
    value = result.parameters["sheath.friction"]
    assert value.low <= 0.2 <= value.high
    assert value.high - value.low < 0.05


def test_of_a_right_model_nothing_is_missing(lever: Path) -> None:
    result = diagnose([measure(lever, 3, 24)], [measure(lever, 4, 12)])
    assert result.verdict == "nothing missing"


def test_what_acts_in_motion_alone_is_no_candidate_at_rest(lever: Path) -> None:
    made = measure(lever, 5, 20)

    problem = problem_of(Simulator, [made])
    bound = candidates(describe_system(problem))
    moving = {c.identifier for c in bound if c.effect.in_motion}
    assert moving >= {"joint_damping", "viscous_friction", "sensor_delay", "command_delay"}
    assert moving.isdisjoint({"sheath_friction", "backlash", "joint_friction", "springref"})


@pytest.mark.long
def test_a_compliant_mount_is_named_from_60_rests_of_a_finger_of_two_joints(tmp_path: Path) -> None:
    rig = write_rig(FINGER, tmp_path, friction=0.12, axial_stiffness=3e3, pretension=1.0)
    reads = {"pull_N": ("input_tension", 0.03)}
    reads |= {f"{joint}_rad": (joint, 0.003) for joint in ("knuckle", "middle")}
    made = settled(
        rig,
        stairs(low=0.0, high=0.012, steps=8, rows=60),
        reads,
        {"sheath.friction": 0.15, "sheath.sheath_compliance": 1e-4},
        1,
        uncertain={"sheath.friction": Uncertain(0.12, 0.03, 0.4)},
    )
    result = diagnose([made])
    assert (result.verdict, result.effects) == ("named", ["sheath_compliance"])
    value = result.parameters["sheath.sheath_compliance"]
    assert value.low <= 1e-4 <= value.high
