"""Noise of a measured series."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.recordings.recording import Recording

FloatArray = NDArray[np.float64]

_ON_GRID = 1e-3  # of the smallest change: a series this near to its multiples is quantised
_SAME = 0.01  # of its range: a driven column this near to another row's repeats it
_GAUSS = 0.6744897501960817  # median |x| of a standard normal variable


def estimate_noise(series: ArrayLike) -> float:
    """Standard deviation of white noise on a smooth series.

    The third difference of white noise has a variance of 20 σ², that of a smooth series nearly
    none; the median is robust to the few samples at kinks. At least the quantisation noise q/√12
    of the series' own resolution q.

    Args:
        series: (n,) samples at even times.

    Returns:
        σ [the unit of the series], > 0 unless the series is constant.
    """
    values = np.asarray(series, float)
    steps = np.abs(np.diff(values))
    resolution = float(steps[steps > 0.0].min(initial=math.inf)) if steps.size else math.inf
    if not math.isfinite(resolution):
        return 0.0
    places = (values - values[0]) / resolution
    multiples = np.unique(np.rint(steps / resolution))
    rounded = multiples.size > 1 and np.abs(places - np.rint(places)).max() < _ON_GRID
    rounding = resolution / math.sqrt(12.0) if rounded else 0.0
    if values.size < 8:
        return rounding
    spread = float(np.median(np.abs(np.diff(values, 3)))) / _GAUSS / math.sqrt(20.0)
    return max(spread, rounding)


def noise_of_repeats(recording: Recording, column: str) -> tuple[float, int]:
    """Standard deviation of rests that repeat each other, and how many more there are than one.

    A rest repeats another where the drive is the same, and was so at the rest before. Of groups of
    n_g such rows, σ² = Σ_g Σ_k (y_gk - ȳ_g)²/Σ_g (n_g - 1).

    Returns:
        σ [the unit of the column], 0 where none repeats another; and Σ_g (n_g - 1).
    """
    driven = [recording.columns[name] for name in recording.drive]
    places = [np.rint(d / (_SAME * (float(np.ptp(d)) or 1.0))) for d in driven]
    moves = np.column_stack([part for place in places for part in (place[1:], place[:-1])])
    _, group = np.unique(moves, axis=0, return_inverse=True)
    values, group = recording.columns[column][1:], group.ravel()
    counts = np.bincount(group)
    means = np.bincount(group, values) / counts
    repeats = int(np.sum(counts - 1))
    return math.sqrt(float(np.sum((values - means[group]) ** 2)) / max(repeats, 1)), repeats


def noise_levels(recording: Recording) -> dict[str, float]:
    """Measured column → its noise [the column's unit]: as stated, else as estimated.

    A column that never changes has no noise to compare with; it gets 1e-3 of its magnitude.
    """
    levels = {}
    for column, measured in recording.measured.items():
        values = recording.columns[column]
        if measured.noise is not None:
            level = measured.noise
        elif recording.quasi_static:
            level = noise_of_repeats(recording, column)[0]
        else:
            level = estimate_noise(values)
        levels[column] = level or 1e-3 * float(np.abs(values).max()) or 1e-9
    return levels
