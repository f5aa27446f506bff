"""Each threshold holds at its edge: what lies just beyond it is found, what lies within is not."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from tendon_mj.errors import TendonWarning
from tendon_mj.lab.noise import (
    held_values,
    is_noisy,
    least_motion,
    noise_levels,
    noise_of_repeats,
    white_noise,
)
from tendon_mj.lab.noise import range_ends as ends
from tendon_mj.lab.noise import resolution as step
from tendon_mj.lab.recordings.clock import at_common_times, spread
from tendon_mj.lab.recordings.description import Session, Source
from tendon_mj.lab.units import NumberRange
from tests.lab.recorded import recorded
from tests.refusals import refused

ROWS = np.arange(1000)
WAVE = np.sin(0.01 * ROWS)
LEVELS, HUM = np.arange(34.0), 1.4 * WAVE[::30]
NOISE = np.random.default_rng(1).normal(0.0, 0.02, ROWS.size)
SORTED = np.sort(NOISE)


def warned(words: str, call: Callable[..., object], *given: object) -> bool:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TendonWarning)
        call(*given)
    return any(words in str(w.message) for w in caught)


def level_near_the_end(noises: float) -> bool:
    """A range whose end has ten samples, with a level of four so many noises below it."""
    level = SORTED[-10] - noises * white_noise(NOISE)
    series = np.minimum(NOISE, SORTED[-10])
    series[np.argsort(np.abs(series - level))[:4]] = level
    return ends(series)[1] < math.inf


def repeating(samples: int, repeats: int) -> bool:
    """Noise of so many samples, of which some repeat the one before."""
    taken = np.arange(samples)
    first = np.linspace(2, samples - 3, repeats).astype(int)
    taken[first + 1] = first
    return bool(held_values(NOISE[taken]).any())


def changing_by(steps: float) -> bool:
    """A triangle of so many steps of a column, held for three samples."""
    triangle = steps * np.abs(np.mod(ROWS[:200], 20) - 10.0)
    return bool(held_values(np.append([0.0, 1.0], np.repeat(triangle, 3))).any())


def regular(share: float) -> bool:
    """Values without noise, held for two samples, and a share of them for seven."""
    lengths = np.where(ROWS[:300] % round(1.0 / share) == 0, 7, 2)
    return bool(held_values(np.repeat(np.sin(0.02 * ROWS[:300]), lengths)).any())


def rounded(times: float) -> bool:
    """Return whether rounding of so many times the stated noise is added to it."""
    noise = 1.0 / math.sqrt(12.0) / times
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


def joined(words: str, rows: slice) -> bool:
    """Return whether a column that lacks rows is warned of with these words."""
    there = np.delete(ROWS, rows)
    series: Mapping[str, Any] = {"a_N": (ROWS, WAVE), "b_N": (there, WAVE[there])}
    return warned(words, at_common_times, series, "time_s", 1.0, "made", ())


def coarse(share: float) -> bool:
    """Return whether a share of equal times makes a clock coarse."""
    clock = ROWS - (ROWS % round(1.0 / share) == 1.0)
    return warned("read as even", spread, clock.astype(float), ROWS, "made")


GRID = np.cumsum(np.resize(LEVELS[:4], 60))
# what → whether it is found in data of a size, and sizes within and beyond its threshold
EDGES: dict[str, tuple[Callable[[float], object], float, float]] = {
    "a level": (lambda s: step(np.resize([0, 1, 2, 3, 3 - 3 * s], 99)) < 0.5, 7e-10, 1.4e-9),
    "off a grid": (lambda rms: step(np.resize(LEVELS + rms * HUM, 99)) < 0.9, 0.07, 0.13),
    "no neighbours": (lambda s: step((GRID + s * np.arange(60))[7 * ROWS % 60]) < 0.9, 4.0, 5.0),
    "noise": (lambda s: is_noisy(np.sin(2.0 * math.asin(0.9354 * s) * ROWS)), 0.4, 0.6),
    "an end": (lambda count: ends(np.minimum(NOISE, SORTED[-count]))[1] < math.inf, 4, 6),
    "a level near an end": (level_near_the_end, 2.0, 4.0),
    "a rest": (lambda samples: not held_values(NOISE[ROWS // samples]).any(), 18, 24),
    "repeats": (lambda repeats: repeating(60, repeats), 8, 12),
    "repeats of many": (lambda repeats: repeating(1000, repeats), 80, 120),
    "steps of what is held": (changing_by, 2.0, 4.0),
    "irregular runs": (lambda share: not regular(share), 0.05, 0.15),
    "rounding": (rounded, 0.9, 1.2),
    "levels of an encoder": (flickering, 80, 125),
    "another drive": (rests_apart, 0.004, 0.006),
    "a gap": (lambda n: joined("as linear", slice(500, 499 + n)), 8, 12),
    "another beginning": (lambda rows: joined("left out", slice(rows)), 200, 300),
    "a coarse clock": (coarse, 1 / 30, 1 / 15),
    "a period": (lambda s: Source(period=1.0).period_fault(np.array([0.0, s])), 1.005, 1.02),
    "a spread": (lambda share: not refused(lambda: Session(1.0, share)), 7e-13, 1.4e-12),
    "a number": (lambda size: refused(lambda: NumberRange().check("a", size)), 9e29, 1.1e30),
}


@pytest.mark.parametrize("what", EDGES)
def test_it_is_found_from_a_threshold_on(what: str) -> None:
    found, within, beyond = EDGES[what]
    assert not found(within)
    assert found(beyond)
