"""Strokes of the input: direction of motion and travel since the last reversal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tendon_mj.compilation import checked
from tendon_mj.typing import FloatArray

MID_STROKE = 0.26  # within this of the middle of the range the output slides both ways [rad]
ENCODER_NOISE = 1e-3  # a reversal is seen when the input has come back by twice this [rad]


@dataclass(frozen=True)
class Strokes:
    """Strokes of one recording; everything is of the input side and independent of rate.

    Attributes:
        direction: −1 closing (input angle falls), +1 opening; 0 before anything has moved.
        travel: of the input since its last reversal [rad].
        excursion: input angle from the middle of its range [rad].
    """

    direction: FloatArray
    travel: FloatArray
    excursion: FloatArray

    @cached_property
    def middle(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Samples in mid-stroke, closing and opening."""
        near = np.abs(self.excursion) < MID_STROKE
        closing, opening = (np.flatnonzero(near & (self.direction == s)) for s in (-1.0, 1.0))
        return closing, opening


def find_strokes(angle: FloatArray) -> Strokes:
    """Strokes of a series of input angles [rad].

    The motion before the recording is taken to be that of the recording itself, which covers
    whole periods, so that the first stroke has a reversal before it. The middle of the range is
    that of the percentiles 0.5 and 99.5, as one recording holds a disturbance that leaves it.
    """
    direction, travel = _follow(np.concatenate([angle, angle]), ENCODER_NOISE)
    low, high = np.percentile(angle, [0.5, 99.5])
    n = len(angle)
    return Strokes(direction[n:], travel[n:], angle - 0.5 * (low + high))


@checked
def _follow(angle: FloatArray, noise: float) -> tuple[FloatArray, FloatArray]:
    """Direction and travel of the play operator of half-width ``noise`` on ``angle``."""
    direction, travel = np.zeros(angle.size), np.zeros(angle.size)
    now, start, sense = angle[0], angle[0], 0.0
    for i in range(angle.size):
        moved = min(max(now, angle[i] - noise), angle[i] + noise)
        if (moved - now) * sense < 0.0 or (sense == 0.0 and moved != now):
            sense, start = np.sign(moved - now), now
        now = moved
        direction[i], travel[i] = sense, abs(now - start)
    return direction, travel
