"""Noise of a measured series, where it is known; marks of converters; rows that are rests."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.noise import (
    estimate_noise,
    held_values,
    least_motion,
    noise_levels,
    noise_of_repeats,
    range_ends,
    resolution,
)
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.recordings.description import parse_toml
from tests.lab.recorded import recorded
from tests.refusals import refusing

TIME = np.arange(0.0, 10.0, 0.01)
NOISE = 0.05


def tension(seed: int = 5) -> np.ndarray:
    """Ten seconds of a tension with noise [N]."""
    random = np.random.default_rng(seed)
    return 20.0 + 8.0 * np.sin(2.0 * TIME) + random.normal(0.0, NOISE, TIME.size)


@pytest.mark.parametrize("step", [0.01, 0.0732421875, 0.5, 3.0])
def test_the_step_of_a_series_is_found_though_the_file_rounds_once_more(step: float) -> None:
    rounded = np.round(np.round(tension() / step) * step, 3)
    assert resolution(rounded) == pytest.approx(step, rel=1e-3)


def test_a_series_of_no_step_has_none() -> None:
    assert resolution(tension()) == 0.0
    assert resolution(np.full(100, 3.0)) == 0.0


def read_by_encoder(place: np.ndarray, step: float, seed: int = 3) -> np.ndarray:
    """Place as an encoder reads it whose noise flips the last bit."""
    random = np.random.default_rng(seed)
    return step * np.round((place + random.normal(0.0, 0.05 * step, place.size)) / step)


def reversals(series: np.ndarray) -> int:
    moves = np.diff(series)
    return int(np.sum(np.diff(np.sign(moves[np.abs(moves) > 1e-12])) != 0.0))


@pytest.mark.parametrize("step", [0.001, 0.009])
def test_the_flicker_of_an_encoder_is_no_motion(step: float) -> None:
    turns = np.array([0.3, 0.3, 1.2, 1.2, 0.2, 0.9, 0.9])
    turns = (np.floor(turns / step) + 0.5) * step  # rests between two levels
    place = np.interp(TIME, [0.0, 1.0, 3.0, 4.0, 7.0, 8.0, 10.0], turns)
    read = read_by_encoder(place, step)
    assert reversals(read) > 10
    freed = least_motion(read)
    assert reversals(freed) == reversals(place) == 2
    assert np.abs(freed - read).max() < 0.61 * step
    steady = (TIME > 4.2) & (TIME < 6.8)
    assert abs(np.mean((freed - place)[steady])) < 0.05 * step


def test_an_exact_drive_is_left_as_it_is() -> None:
    ramps = np.interp(TIME, [0.0, 4.0, 8.0, 10.0], [0.0, 1.0, -1.0, 0.0])
    assert least_motion(ramps) is ramps
    finely = np.round(np.sin(TIME), 6)
    assert least_motion(finely) is finely


@pytest.mark.parametrize("size", [1.0, 5.0])
@pytest.mark.parametrize("step", [0.001, 0.003, 0.009])
def test_between_the_marks_of_an_encoder_a_motion_goes_on(step: float, size: float) -> None:
    """Rests and turns are where they were read, and nothing is off by more than half a step."""
    rise, fall = (
        np.clip((TIME - begin) / last, 0.0, 1.0) for begin, last in ((2.0, 4.0), (6.0, 2.0))
    )
    place = size * (0.25 - 0.5 * np.cos(np.pi * rise) + 0.25 * np.cos(np.pi * fall)) + 0.2 * step
    read = step * np.round(place / step)
    freed = least_motion(read)
    assert np.abs(freed - read).max() < 0.61 * step
    assert reversals(freed) == reversals(place) == 1
    assert (freed == read)[TIME < 1.5].all()
    moves = (TIME > 2.1) & (TIME < 7.9)
    rms = [float(np.sqrt(np.mean((each - place)[moves] ** 2))) for each in (freed, read)]
    assert rms[0] < 0.75 * rms[1]


@pytest.mark.parametrize("seed", range(10))
def test_ends_of_a_range_are_found_and_no_others(seed: int) -> None:
    series = np.round(tension(seed), 3)
    assert range_ends(series) == (-np.inf, np.inf)
    assert range_ends(np.minimum(series, 26.0)) == (-np.inf, 26.0)
    assert range_ends(np.clip(series, 13.5, 27.0)) == (13.5, 27.0)


def test_a_rest_at_the_top_without_noise_is_no_end_of_a_range() -> None:
    turns = np.clip(20.0 * np.sin(2.0 * TIME), -15.0, 15.0)
    assert range_ends(turns) == (-np.inf, np.inf)
    assert range_ends(np.round(turns / 0.5) * 0.5) == (-np.inf, np.inf)


@pytest.mark.parametrize("times", [2.0, 2.5, 3.0, 6.0])
def test_values_that_are_held_are_found(times: float) -> None:
    rows = np.arange(TIME.size)
    taken = np.minimum(np.floor(np.floor(rows / times) * times), rows).astype(int)
    repeats = held_values(np.round(tension(), 3)[taken])
    expected = np.append(False, np.diff(taken) == 0)
    assert np.mean(repeats == expected) > 0.98


@pytest.mark.parametrize("step", [0.001, 0.05, 0.5])
def test_equal_neighbours_of_a_rounded_series_are_not_held(step: float) -> None:
    """Noise, an encoder's steps, and rests make equal neighbours too."""
    assert not held_values(np.round(tension() / step) * step).any()
    stuck = np.where(np.mod(TIME, 1.0) < 0.6, np.floor(TIME), TIME)
    assert not held_values(np.round(stuck / step) * step).any()


def test_noise_is_at_least_that_of_the_steps() -> None:
    step = 0.5
    for stated, expected in (
        (None, step / np.sqrt(12.0)),
        (0.01, step / np.sqrt(12.0)),
        (0.2, 0.2),
    ):
        recording = recorded(
            TIME,
            {"reel_m": ("reel", np.sin(TIME))},
            {"cable_N": ("input_tension", stated, np.round(tension() / step) * step)},
        )
        assert noise_levels(recording)["cable_N"] == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("level", [0.003, 0.05, 1.0])
def test_noise_is_found_under_motion(level: float) -> None:
    random = np.random.default_rng(7)
    time = np.linspace(0.0, 8.0, 2000)
    series = 20.0 * np.sin(2.0 * time) + random.normal(0.0, level, time.size)
    assert estimate_noise(series) == pytest.approx(level, rel=0.1)


def test_noise_of_a_quantised_series_is_at_least_its_rounding() -> None:
    turns = np.sin(np.linspace(0.0, 6.0, 2000))
    assert estimate_noise(np.round(turns, 3)) >= 0.9 * 1e-3 / np.sqrt(12.0)
    coarse = np.round(20.0 * np.sin(np.linspace(0.0, 60.0, 2000)) / 5.0) * 5.0
    assert estimate_noise(coarse) == pytest.approx(5.0 / np.sqrt(12.0))


def test_even_steps_are_no_rounding() -> None:
    triangle = np.concatenate([np.arange(0.0, 1.0, 0.01), np.arange(1.0, 0.0, -0.01)])
    assert estimate_noise(triangle) < 1e-9


HEAD = 'model = "bench"\nsource = "made up"\n'


def test_rows_are_samples_of_a_motion_unless_they_are_said_to_be_rests() -> None:
    for timing in ("", "[timing]\n", "[timing]\nquasi_static = false\n"):
        described = parse_toml(HEAD + timing, "a.toml")[0]
        assert (described.quasi_static, described.settling_time) == (False, None)
    described = parse_toml(HEAD + "[timing]\nquasi_static = true\n", "a.toml")[0]
    assert described.quasi_static
    assert described.settling_time == 10.0


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
        parse_toml(f"{HEAD}{timing}\n", "a.toml")


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
