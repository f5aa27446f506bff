"""Quotients of exponentials with removable singularities, to about 1e-15 everywhere.

Equations: docs/theory.md, section 1.
"""

from __future__ import annotations

import math

import numpy as np

from tendon_mj.typing import FloatArray

# (e^z - z - 1)/z = sum z^n/(n+1)!, eq. (13). For |z| <= 1 the first term left out is 1/20! = 4e-19.
_COEFFICIENTS = [1.0 / math.factorial(n + 1) for n in range(1, 19)]


def relative(z: FloatArray) -> FloatArray:
    """(e^z − 1)/z, 1 at z = 0: the mean of e^s over 0 ≤ s ≤ z."""
    with np.errstate(over="ignore"):  # infinity is the right value
        return np.where(z == 0, 1.0, np.expm1(z) / np.where(z == 0, 1.0, z))[()]


def relative_excess(z: FloatArray) -> FloatArray:
    """(e^z − z − 1)/z, 0 at z = 0: the mean of e^s − 1 over 0 ≤ s ≤ z, eq. (13)."""
    small = np.abs(z) < 1.0
    near = np.where(small, z, 0.0)
    series = np.zeros_like(near)
    for coefficient in reversed(_COEFFICIENTS):
        series = (series + coefficient) * near
    far = np.where(small, 1.0, z)
    with np.errstate(over="ignore"):
        return np.where(small, series, (np.expm1(far) - far) / far)[()]


def inverse_relative(z: FloatArray) -> FloatArray:
    """z/(e^z − 1), 1 at z = 0, eq. (20): 0 for z → ∞, without overflow on the way."""
    size = np.where(z == 0, 1.0, np.abs(z))
    falling = size / -np.expm1(-size)  # the value at -size
    return np.where(z == 0, 1.0, np.where(z > 0, falling * np.exp(-size), falling))[()]


def mean_excess(start: FloatArray, offset: FloatArray, z: FloatArray) -> FloatArray:
    """Mean of start·e^s − offset over 0 ≤ s ≤ z; each form is used where it cancels least."""
    with np.errstate(over="ignore"):
        near = (start - offset) + start * relative_excess(z)
        return np.where(np.abs(z) < 1.0, near, start * relative(z) - offset)[()]


def log_ratio(a: FloatArray, b: FloatArray) -> FloatArray:
    """ln(a/b), accurate where a is near b too; −∞ for a = 0."""
    change = (a - b) / b
    close = np.abs(change) < 0.5
    with np.errstate(divide="ignore"):
        far = np.log(np.where(close, 1.0, a / b))
    return np.where(close, np.log1p(np.where(close, change, 0.0)), far)[()]
