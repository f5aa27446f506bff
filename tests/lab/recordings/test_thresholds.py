"""Each threshold holds at its edge: what lies just beyond it is found, what lies within is not."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable

import numpy as np
import pytest

from tendon_mj.errors import TendonWarning
from tendon_mj.lab.recordings import (
    held_values,
    least_motion,
    noise_levels,
    noise_of_repeats,
    range_ends,
    resolution,
)
from tendon_mj.lab.recordings.assembly import at_common_times, spread
from tendon_mj.lab.recordings.description import Session, Source
from tendon_mj.lab.recordings.noise import is_noisy, white_noise
from tendon_mj.lab.recordings.units import NumberRange
from tests.lab.recorded import recorded
from tests.refusals import refused

ROWS = np.arange(1000)
WAVE = np.sin(0.01 * ROWS)
LEVELS = np.arange(34.0)
NOISE = np.random.default_rng(1).normal(0.0, 0.02, ROWS.size)


def warned(call: Callable[[], object]) -> str:
    """What a call warns of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TendonWarning)
        call()
    return " ".join(str(w.message) for w in caught)


def level_near_the_top(noises: float) -> bool:
    """A range whose end has ten samples, with a level of four so many noises below it."""
    series = np.sort(NOISE)[::-1][np.argsort(np.argsort(-NOISE))].copy()
    white = white_noise(series)
    top = float(np.sort(series)[-10])
    series = np.minimum(series, top)
    series[np.argsort(np.abs(series - top + noises * white))[:4]] = top - noises * white
    return range_ends(series)[1] < math.inf


def repeating(samples: int, repeats: int, step: float = 0.0) -> bool:
    """Noise of so many samples, of which some repeat the one before."""
    taken = np.arange(samples)
    first = np.linspace(2, samples - 3, repeats).astype(int)
    taken[first + 1] = first
    return bool(held_values(NOISE[taken]).any())


def held_for(samples: int) -> bool:
    return bool(held_values(NOISE[ROWS // samples]).any())


def changing_by(steps: float) -> bool:
    """A triangle of so many steps of a column, held for three samples."""
    triangle = steps * np.abs(np.mod(ROWS[:200], 20) - 10.0)
    return bool(held_values(np.append([0.0, 1.0], np.repeat(triangle, 3))).any())


def irregular(share: float) -> bool:
    """Values without noise, held for two samples, and a share of them for seven."""
    lengths = np.where(np.arange(300) % round(1.0 / share) == 0, 7, 2)
    return bool(held_values(np.repeat(np.sin(0.02 * np.arange(300)), lengths)).any())


def stated(ratio: float) -> bool:
    """Return whether rounding of so many times the stated noise is added to it."""
    noise = 1.0 / math.sqrt(12.0) / ratio
    made = recorded(ROWS, {}, {"in_N": ("input_tension", noise, np.rint(50.0 * WAVE))})
    return noise_levels(made)["in_N"] > 1.001 * noise


def flickering(levels: int) -> bool:
    read = np.rint(levels * 0.5 * WAVE + 5.0 * NOISE)
    return least_motion(read) is not read


def rests_apart(share: float) -> bool:
    """Return whether rests under drives that differ by a share of their range repeat each other."""
    drive = np.resize([0.0, 1.0], 40) + np.where(ROWS[:40] % 4 > 1, share, 0.0)
    made = recorded(ROWS[:40], {"reel_m": ("reel", drive)}, {"in_N": ("input_tension", None)})
    return noise_of_repeats(made, "in_N")[1] < 37


def gap(times: float) -> bool:
    """A column that lacks values for so many of its intervals."""
    there = np.delete(ROWS, slice(500, 499 + round(times)))
    series = {"a_N": (ROWS, WAVE), "b_N": (there, WAVE[there])}
    return "as linear" in warned(lambda: at_common_times(series, "time_s", 1.0, "made", ()))


def begins_late(share: float) -> bool:
    series = {"a_N": (ROWS, WAVE), "b_N": (ROWS[round(1000 * share) :], WAVE[1000 * share <= ROWS])}
    return "left out" in warned(lambda: at_common_times(series, "time_s", 1.0, "made", ()))


def equal_times(share: float) -> bool:
    """A clock of which a share of the times are those of the row before."""
    coarse = ROWS - (ROWS % round(1.0 / share) == 1)
    return "read as even" in warned(lambda: spread(coarse.astype(float), ROWS, "made"))


# what → whether it is found in data of a size, and sizes within and beyond its threshold
EDGES: dict[str, tuple[Callable[[float], object], float, float]] = {
    "levels that differ": (
        lambda share: resolution(np.resize([0.0, 1.0, 2.0, 3.0, 3.0 - 3.0 * share], 99)) < 0.5,
        0.7e-9,
        1.4e-9,
    ),
    "levels off a grid": (
        lambda rms: resolution(np.resize(LEVELS + math.sqrt(2.0) * rms * WAVE[::30], 99)) < 0.9,
        0.07,
        0.13,
    ),
    "levels of which no two are neighbours": (
        lambda steps: resolution(np.cumsum(np.resize(steps + LEVELS[:4], 60))[7 * ROWS % 60]) < 0.9,
        4.0,
        5.0,
    ),
    "noise and not motion": (
        lambda ratio: is_noisy(np.sin(2.0 * math.asin(ratio * math.sqrt(70 / 80)) * ROWS)),
        0.4,
        0.6,
    ),
    "samples at an end": (
        lambda count: range_ends(np.minimum(NOISE, np.sort(NOISE)[-count]))[1] < math.inf,
        4,
        6,
    ),
    "a full level below an end": (level_near_the_top, 2.0, 4.0),
    "a rest, not a held value": (lambda samples: not held_for(samples), 18, 24),
    "repeats": (lambda repeats: repeating(60, repeats), 8, 12),
    "repeats of many": (lambda repeats: repeating(1000, repeats), 80, 120),
    "held changes by steps": (changing_by, 2.0, 4.0),
    "held for different times": (lambda share: not irregular(share), 0.05, 0.15),
    "rounding beyond a noise": (stated, 0.9, 1.2),
    "levels of a flickering encoder": (flickering, 80, 125),
    "drives that differ": (rests_apart, 0.004, 0.006),
    "a gap": (gap, 8.0, 12.0),
    "a column that begins late": (begins_late, 0.2, 0.3),
    "equal times of a coarse clock": (equal_times, 1 / 30, 1 / 15),
    "a counter beyond its period": (
        lambda share: Source(period=1.0).period_fault(np.array([0.0, share])),
        1.005,
        1.02,
    ),
    "a spread above rounding": (
        lambda share: not refused(lambda: Session(1.0, share)),
        0.7e-12,
        1.4e-12,
    ),
    "a number that is too large": (
        lambda size: refused(lambda: NumberRange().check("a", size)),
        0.9e30,
        1.1e30,
    ),
}


@pytest.mark.parametrize("what", EDGES)
def test_it_is_found_from_a_threshold_on(what: str) -> None:
    found, within, beyond = EDGES[what]
    assert not found(within)
    assert found(beyond)
