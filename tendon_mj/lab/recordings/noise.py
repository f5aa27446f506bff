"""Noise of a measured series."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.lab.recordings.converter import range_ends, resolution, white_noise
from tendon_mj.lab.recordings.recording import Recording

_AS_STATED = 1.05  # rounding over the stated noise, up to which that is taken to include it
_SAME = 0.01  # of its range: a driven column this near to another row's repeats it


def estimate_noise(series: ArrayLike) -> float:
    """Standard deviation of white noise on a smooth series.

    The third difference of white noise has a variance of 20 σ², that of a smooth series nearly
    none; the median is robust to the few samples at kinks. Samples at the end of a range, where
    there is no noise, do not count. At least the quantisation noise q/√12 of the series' own
    resolution q.

    Args:
        series: (n,) samples at even times.

    Returns:
        σ [the unit of the series], > 0 unless the series is constant.
    """
    values = np.asarray(series, float)
    inner = ~np.isin(values, range_ends(values))
    return max(white_noise(values, inner), resolution(values) / math.sqrt(12.0))


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

    To a stated noise that is finer than the column's steps q, their q/√12 is added. A column that
    never changes has no noise to compare with; it gets 1e-3 of its magnitude.
    """
    levels = {}
    for column, measured in recording.measured.items():
        values = recording.columns[column]
        if measured.noise is not None:
            rounding = resolution(values) / math.sqrt(12.0)
            fine = rounding <= _AS_STATED * measured.noise
            level = measured.noise if fine else math.hypot(measured.noise, rounding)
        elif recording.quasi_static:
            level = noise_of_repeats(recording, column)[0]
        else:
            level = estimate_noise(values)
        levels[column] = level or 1e-3 * float(np.abs(values).max()) or 1e-9
    return levels
