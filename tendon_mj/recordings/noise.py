"""Noise of a measured series."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.recordings.converter import range_ends, resolution, white_noise
from tendon_mj.recordings.recording import Recording

_AS_STATED = 1.05  # rounding over the stated noise, up to which that is taken to include it


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


def noise_levels(recording: Recording) -> dict[str, float]:
    """Measured column → its noise [the column's unit]: as stated, else as estimated.

    To a stated noise that is finer than the column's steps q, their q/√12 is added. A column that
    never changes has no noise to compare with; it gets 1e-3 of its magnitude.
    """
    levels = {}
    for column, measured in recording.measured.items():
        values = recording.columns[column]
        if measured.noise is None:
            level = estimate_noise(values)
        else:
            rounding = resolution(values) / math.sqrt(12.0)
            fine = rounding <= _AS_STATED * measured.noise
            level = measured.noise if fine else math.hypot(measured.noise, rounding)
        levels[column] = level or 1e-3 * float(np.abs(values).max()) or 1e-9
    return levels
