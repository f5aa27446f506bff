"""Argument checks and input histories; a message names the argument, its value and the range."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_mj.errors import InvalidValueError
from tendon_mj.typing import FloatArray

MOST_STEPS = 1e12  # days of computing; beyond 2^63 they could not even be counted


def _range(above: float, least: float, infinite: bool = False) -> str:
    """Words for the valid range of a number."""
    end = " (inf allowed)" if infinite else " and finite"
    if above > -math.inf:
        return f"> {above:g}{end}"
    if least > -math.inf:
        return f">= {least:g}{end}"
    return "a number or inf" if infinite else "finite"


def number(
    name: str,
    value: float,
    *,
    above: float = -math.inf,
    least: float = -math.inf,
    infinite: bool = False,
) -> float:
    """Return ``value`` as a float if ``value > above`` and ``value >= least``."""
    try:
        given = float(value)
    except (TypeError, ValueError) as error:
        raise InvalidValueError(f"{name} is {value!r}; it must be one number") from error
    finite = math.isfinite(given) or (infinite and given == math.inf)
    if not finite or given <= above or given < least:
        wanted = _range(above, least, infinite)
        raise InvalidValueError(f"{name} is {given:g}; it must be {wanted}")
    return given


def vector(
    name: str,
    value: npt.ArrayLike,
    size: int | None = None,
    *,
    above: float = -math.inf,
    least: float = -math.inf,
) -> FloatArray:
    """Return ``value`` as a read-only float array of ``size``; a scalar fills it."""
    try:
        given = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidValueError(f"{name} is {value!r}; it must be numbers in a row") from error
    if size is not None and given.ndim == 0:
        given = np.full(size, float(given))
    if given.ndim != 1 or (size is not None and given.size != size):
        wanted = "one-dimensional" if size is None else f"a number or of shape ({size},)"
        raise InvalidValueError(f"{name} has shape {given.shape}; it must be {wanted}")
    bad = ~np.isfinite(given) | (given <= above) | (given < least)
    if bad.any():
        at = int(np.argmax(bad))
        wanted = _range(above, least)
        raise InvalidValueError(f"{name}[{at}] is {given[at]:g}; every value must be {wanted}")
    given.flags.writeable = False
    return given


def whole(name: str, value: int, *, least: int = 1) -> int:
    """Return ``value`` as an int if it is whole and at least ``least``."""
    given = number(name, value)
    if not given.is_integer() or given < least:
        raise InvalidValueError(f"{name} is {value}; it must be a whole number >= {least}")
    return int(value)


def drive(
    tension: npt.ArrayLike | None, displacement: npt.ArrayLike | None, size: int | None = None
) -> tuple[FloatArray, bool]:
    """Return the one given input history and whether it is a tension."""
    if (tension is None) == (displacement is None):
        number_given = "neither" if tension is None else "both"
        raise InvalidValueError(
            f"input_tension and input_displacement: {number_given} given; give exactly one"
        )
    if tension is not None:
        return vector("input_tension", tension, size, least=0.0), True
    assert displacement is not None
    return vector("input_displacement", displacement, size), False


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
