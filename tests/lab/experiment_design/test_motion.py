"""Motions stay within the bounds of the rig, whatever they are."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.lab.experiment_design import DriveBounds
from tendon_mj.lab.experiment_design.experiment import SHAPES, motion_at

INTERVAL = 0.004
RANDOM = np.random.default_rng(0)
POINTS = [*RANDOM.random((40, 5)), np.zeros(5), np.ones(5)]
BOUNDS = [
    (DriveBounds(-1e-3, 1.3e-3, 12e-3, 1.0), 0.0, 8.0),
    (DriveBounds(100.0, 101.0, 50.0), 100.3, 3.0),
    (DriveBounds(-60.0, 60.0, 4.0, 20.0), -60.0, 10.0),  # too slow to cross its range in time
    (DriveBounds(-1.0, 1.0, 1e-3), 0.0, 2.0),  # by far
    (DriveBounds(-8e-4, 8e-4, 1e-6, 1.0), 0.0, 4.0),
]


@pytest.mark.parametrize("shape", range(len(SHAPES)))
@pytest.mark.parametrize(("bounds", "start", "duration"), BOUNDS)
def test_a_motion_keeps_to_its_range_and_its_rate_and_reverses(
    shape: int, bounds: DriveBounds, start: float, duration: float
) -> None:
    time = np.arange(round(duration / INTERVAL) + 1) * INTERVAL
    for point in POINTS:
        first = (shape + 0.5) / len(SHAPES)
        motion = motion_at(np.array([first, *point[1:]]), bounds, start, duration, INTERVAL)
        assert motion.shape == SHAPES[shape]
        series = motion.series(time)
        slack = 1e-9 * (bounds.high - bounds.low)
        assert series[0] == pytest.approx(start)
        assert bounds.low - slack <= series.min()
        assert series.max() <= bounds.high + slack
        assert np.abs(np.diff(series)).max() <= 1.01 * bounds.rate * INTERVAL
        ways = np.sign(np.diff(series))
        assert {-1.0, 1.0} <= set(ways), "it goes both ways"
        assert motion.dwell <= bounds.dwell
        assert "between" in motion.words("m", duration)


def test_a_rest_lasts_as_long_as_it_says() -> None:
    bounds = DriveBounds(-1.0, 1.0, 10.0, 0.5)
    motion = motion_at(np.array([0.1, 1.0, 0.0, 1.0, 1.0]), bounds, 0.0, 10.0, INTERVAL)
    time = np.arange(0.0, 10.0, INTERVAL)
    still = np.diff(motion.series(time)) == 0.0
    turns = np.flatnonzero(np.diff(still.astype(int)) != 0)
    rests = np.diff(turns)[::2] * INTERVAL
    assert motion.dwell == 0.5
    np.testing.assert_allclose(rests[rests > 0.1], 0.5, atol=3 * INTERVAL)
