"""Arguments of the references as arrays and histories."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_mj.errors import InvalidValueError
from tendon_mj.typing import FloatArray


def vector(value: npt.ArrayLike, size: int | None = None) -> FloatArray:
    """Return ``value`` as a float array of ``size``; a scalar fills it."""
    given = np.array(value, np.float64)
    return given if size is None else np.broadcast_to(given, (size,)).copy()


def drive(
    tension: npt.ArrayLike | None, displacement: npt.ArrayLike | None, size: int | None = None
) -> tuple[FloatArray, bool]:
    """Return the one given input history and whether it is a tension."""
    if (tension is None) == (displacement is None):
        raise InvalidValueError("give exactly one of input_tension and input_displacement")
    given = displacement if tension is None else tension
    assert given is not None
    return vector(given, size), tension is not None


def series(*stiffness: float) -> float:
    """Stiffness of springs in series [N/m]; eq. (15): 1/k_se = 1/k_e + 1/k_s."""
    compliance = sum(1.0 / k for k in stiffness)
    return math.inf if compliance == 0.0 else 1.0 / compliance


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
    """Steps between two ``instants`` [s] each, none longer than ``longest`` [s]."""
    counts = np.ceil(np.diff(instants) / longest * (1.0 - 1e-9))
    return np.maximum(counts, 1.0).astype(np.int64)
