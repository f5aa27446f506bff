"""Argument checks: each message names the argument, its value and the valid range."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError
from tendon_mj.typing import FloatArray


def _rule(
    valid: Callable[[FloatArray], ArrayLike], wanted: str
) -> Callable[[str, ArrayLike], FloatArray]:
    """Function of an argument's name and value, which returns valid values as floats."""

    def check(name: str, value: ArrayLike) -> FloatArray:
        array = np.asarray(value, dtype=np.float64)
        return require(name, array, valid(array), wanted)

    return check


def history(name: str, value: FloatArray) -> FloatArray:
    """Return ``value``, which must have a time axis."""
    if value.ndim == 0:
        raise InvalidValueError(
            f"{name} must be a history with time on axis 0, got the scalar {float(value)!r}"
        )
    return value


def require(name: str, value: FloatArray, valid: ArrayLike, wanted: str) -> FloatArray:
    """Return ``value`` if ``valid`` throughout; the two broadcast."""
    array, good = np.broadcast_arrays(value, np.asarray(valid, dtype=np.bool_))
    if not good.all():
        raise InvalidValueError(f"{name} must be {wanted}, got {float(array[~good][0])!r}")
    return value


finite = _rule(np.isfinite, "finite")
non_negative = _rule(lambda x: np.isfinite(x) & (x >= 0), "finite and >= 0")
positive = _rule(lambda x: np.isfinite(x) & (x > 0), "finite and > 0")
stiffness = _rule(lambda x: x > 0, "> 0 (inf: rigid)")
