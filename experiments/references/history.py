"""Input history of a run, and the steps into which the time between its instants is divided."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_mj.errors import InvalidValueError
from tendon_mj.typing import FloatArray

MOST_STEPS = 1e12  # days of computing; beyond 2^63 they could not even be counted


class History(NamedTuple):
    """Input over time, linear between instants; Numba compiles it.

    Attributes:
        time: instants, rising [s]. Shape (samples,).
        value: input there, a displacement [m] or a tension [N]. Shape (samples,).
        steps: number of steps between two instants [–]. Shape (samples − 1,).
    """

    time: FloatArray
    value: FloatArray
    steps: npt.NDArray[np.int64]


def step_counts(instants: FloatArray, longest: float) -> npt.NDArray[np.int64]:
    """Steps between two ``instants`` [s] each, none longer than ``longest`` [s].

    Raises:
        InvalidValueError: instants that are too few or do not rise, or too many steps.
    """
    intervals = np.diff(instants)
    if instants.size < 2 or intervals.min() <= 0.0:
        raise InvalidValueError(
            f"time has {instants.size} instants"
            + (f" and a smallest interval of {intervals.min():g} s" if intervals.size else "")
            + "; it must have at least 2 and rise strictly"
        )
    with np.errstate(over="ignore"):
        counts = np.maximum(np.ceil(intervals / longest * (1.0 - 1e-9)), 1.0)
        total = counts.sum()
    if total > MOST_STEPS:
        raise InvalidValueError(
            f"time_step is {longest:g} s, which makes {total:.3g} steps; there may be at most "
            f"{MOST_STEPS:g}"
        )
    return counts.astype(np.int64)
