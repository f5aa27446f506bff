"""Argument checks: each message names the argument, its value and the valid range."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError
from tendon_mj.typing import FloatArray


def finite(name: str, value: ArrayLike) -> FloatArray:
    """Return ``value`` as floats, all finite."""
    array = np.asarray(value, dtype=np.float64)
    return require(name, array, np.isfinite(array), "finite")


def non_negative(name: str, value: ArrayLike) -> FloatArray:
    """Return ``value`` as floats, all finite and at least 0."""
    array = np.asarray(value, dtype=np.float64)
    return require(name, array, np.isfinite(array) & (array >= 0), "finite and >= 0")


def positive(name: str, value: ArrayLike) -> FloatArray:
    """Return ``value`` as floats, all finite and above 0."""
    array = np.asarray(value, dtype=np.float64)
    return require(name, array, np.isfinite(array) & (array > 0), "finite and > 0")


def stiffness(name: str, value: ArrayLike) -> FloatArray:
    """Return ``value`` as floats, all above 0; infinity stands for a rigid part."""
    array = np.asarray(value, dtype=np.float64)
    return require(name, array, array > 0, "> 0 (inf: rigid)")


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
