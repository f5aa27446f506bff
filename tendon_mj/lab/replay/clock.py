"""The uniform time grid on which a recording is simulated, and how samples are read off it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.typing import FloatArray

_ON_GRID = 1e-6  # share of a step within which a sample counts as lying on the grid
_ROUNDING = 1e-9  # of a ratio of two times that both came from decimal text


@dataclass(frozen=True)
class Clock:
    """Grid t_0 + k h, k = 0 … steps, and the place of every sample on it.

    Attributes:
        start: t_0, time of the first sample [s].
        timestep: h [s].
        steps: from the first sample to the last.
        places: (n,) of the samples, (t − t_0)/h [-].
    """

    start: float
    timestep: float
    steps: int
    places: FloatArray

    @property
    def time(self) -> FloatArray:
        """(steps+1,) times of the grid [s]."""
        return self.start + self.timestep * np.arange(self.steps + 1, dtype=np.float64)

    def sample(self, series: FloatArray, delay: float = 0.0) -> FloatArray:
        """(steps+1, …) on the grid to (n, …) at the samples: taken there, or linear between.

        ``delay`` ≥ 0 [s] earlier; what would be before the grid is its first value.
        """
        places = self.places
        if delay > 0.0:
            places = np.maximum(0.0, places - delay / self.timestep)
        below = np.clip(np.floor(places).astype(int), 0, self.steps - 1)
        share = (places - below).reshape(-1, *[1] * (series.ndim - 1))
        between: FloatArray = (1.0 - share) * series[below] + share * series[below + 1]
        return between


def make_clock(time: ArrayLike, longest: float) -> Clock:
    """The grid for samples at ``time``.

    The step is the typical (median) interval between samples, divided by the smallest whole number
    that makes it no longer than ``longest``. Regular samples, also with rows left out, therefore
    lie on the grid; others are interpolated.

    Args:
        time: (n,) of the samples, strictly increasing [s].
        longest: step allowed [s].
    """
    stamps = np.asarray(time, float)
    span = stamps[-1] - stamps[0]
    intervals = max(1, round(span / float(np.median(np.diff(stamps)))))
    steps = intervals * max(1, math.ceil(span / intervals / longest * (1.0 - _ROUNDING)))
    places = (stamps - stamps[0]) / (span / steps)
    nearest = np.rint(places)
    places = np.where(np.abs(places - nearest) < _ON_GRID, nearest, places)
    return Clock(float(stamps[0]), float(span / steps), steps, places)
