"""Rows that are rests: how a description says so, and their noise."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording, noise_levels, noise_of_repeats
from tendon_mj.lab.recordings.description import parse_description
from tests.lab.recorded import recorded
from tests.refusals import refusing

HEAD = 'model = "bench"\nsource = "made up"\n'


def test_rows_are_samples_of_a_motion_unless_they_are_said_to_be_rests() -> None:
    for timing in ("", "[timing]\n", "[timing]\nquasi_static = false\n"):
        described = parse_description(HEAD + timing, "a.toml")
        assert (described.quasi_static, described.settling_time) == (False, None)
    described = parse_description(HEAD + "[timing]\nquasi_static = true\n", "a.toml")
    assert described.quasi_static
    assert described.settling_time > 0.0


@pytest.mark.parametrize(
    ("timing", "value"),
    [
        ("timing = 3", "3"),
        ("[timing]\nquasi_statik = true", "'quasi_static'"),
        ("[timing]\nquasi_static = 1", "1"),
        ("[timing]\nsettling_time = 2.0", "settling_time"),
        ('[timing]\nquasi_static = true\nsettling_time = "8 s"', "'8 s'"),
    ],
)
def test_a_timing_that_is_none_is_refused_with_its_place(timing: str, value: str) -> None:
    with refusing(RecordingError, "a.toml, [timing]", f"{value}"):
        parse_description(f"{HEAD}{timing}\n", "a.toml")


@pytest.mark.parametrize("settling", [0.0, -1.0, np.inf, np.nan])
def test_a_settling_time_that_is_none_is_refused(settling: float) -> None:
    with refusing(RecordingError, f"settling_time = {settling!r}"):
        points(np.arange(4.0), np.zeros(4), settling_time=settling)


def points(drive: np.ndarray, reading: np.ndarray, settling_time: float = 2.0) -> Recording:
    return recorded(
        np.arange(drive.size, dtype=float),
        {"reel_m": ("reel", drive)},
        {"pull_N": ("input_tension", None, reading)},
        settling_time=settling_time,
    )


def test_the_noise_of_rests_is_that_of_their_repeats_whatever_lies_between_them() -> None:
    random = np.random.default_rng(1)
    drive = np.resize([0.0, 1.0, 2.0, 3.0, 2.0, 1.0], 600)
    up = np.diff(drive, prepend=1.0) > 0.0
    loop = 100.0 * drive**2 + 30.0 * up  # the same drive has one reading on each branch
    made = points(drive, loop + random.normal(0.0, 0.25, drive.size))
    deviation, repeats = noise_of_repeats(made, "pull_N")
    assert repeats == 599 - 6
    assert deviation == pytest.approx(0.25, rel=0.1)
    assert noise_levels(made)["pull_N"] == deviation


def test_rests_that_repeat_none_have_no_noise_of_repeats() -> None:
    assert noise_of_repeats(points(np.arange(9.0), np.arange(9.0)), "pull_N") == (0.0, 0)
