"""Tension and elongation along the tendon, for a first motion from uniform pretension.

Equations: docs/theory.md, section 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.theory import _check
from tendon_mj.theory._exponential import log_ratio, mean_excess
from tendon_mj.typing import FloatArray


def sliding_length(
    input_tension: ArrayLike, lam: ArrayLike, pretension: ArrayLike, length: ArrayLike
) -> FloatArray:
    """Length from the input end over which the tendon has slid.

    L_1 = min{x : T(x) = T_0} = L |ln(T_in/T_0)|/|λ|, at most L.

    Args:
        input_tension: T_in [N]; above T_0 it pulls, below it loosens.
        lam: λ [–]; its sign is ignored, T_in gives the direction.
        pretension: T_0 [N].
        length: L [m].

    Returns:
        L_1 [m], in the shape the arguments broadcast to; 0 where T_in = T_0.

    Raises:
        InvalidValueError: a tension negative, lam not finite, length not positive.

    Source: Kaneko et al. 1991, eq. (8).
    """
    start = _check.non_negative("input_tension", input_tension)
    initial = _check.non_negative("pretension", pretension)
    size = np.abs(_check.finite("lam", lam))
    whole = _check.positive("length", length)
    start, initial, size, whole = np.broadcast_arrays(start, initial, size, whole)
    exponent = np.abs(log_ratio(start, np.where(initial > 0, initial, 1.0)))
    partial = (initial > 0) & (exponent < size)
    # the exponent first: whole · (exponent/size) cannot overflow
    slid = whole * (np.where(partial, exponent, 1.0) / np.where(partial, size, 1.0))
    return np.where(start == initial, 0.0, slid)[()]


def tension_profile(
    position: ArrayLike,
    input_tension: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    length: ArrayLike,
) -> FloatArray:
    """Tension along the tendon after a first motion.

    T(x) = T_in e^{−λx/L} for x < L_1, T_0 beyond, with λ signed by T_in − T_0.

    Args:
        position: x from the input end [m], 0 to L.
        input_tension: T_in [N].
        lam: λ [–]; its sign is ignored.
        pretension: T_0 [N].
        length: L [m].

    Returns:
        T(x) [N], in the shape the arguments broadcast to.

    Raises:
        InvalidValueError: position outside 0 … L, or as in ``sliding_length``.

    Source: Kaneko et al. 1991, eq. (5).
    """
    slid = sliding_length(input_tension, lam, pretension, length)
    start, initial, whole = (np.asarray(v, np.float64) for v in (input_tension, pretension, length))
    x = _position(position, whole)
    signed = np.abs(_check.finite("lam", lam)) * np.sign(start - initial)
    sliding = (x < slid) | (slid == whole)  # at x = L: eq. (9) holds with equality at most
    return np.where(sliding, start * np.exp(-signed * np.minimum(x, slid) / whole), initial)[()]


def elongation_profile(
    position: ArrayLike,
    input_tension: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
) -> FloatArray:
    """Elongation of the tendon between the input end and x, after a first motion.

    δ(x) = (1/EA)[(L/λ) T_in (1 − e^{−λx/L}) − T_0 x], constant for x ≥ L_1: the integral of
    dδ/dx = (T − T_0)/EA. The paper's transcript of (7) has L_1 where x must stand.

    Args:
        position: x from the input end [m], 0 to L.
        input_tension: T_in [N].
        lam: λ [–]; its sign is ignored.
        pretension: T_0 [N].
        axial_stiffness: EA [N].
        length: L [m].

    Returns:
        δ(x) [m], in the shape the arguments broadcast to.

    Raises:
        InvalidValueError: EA not positive, or as in ``tension_profile``.

    Source: Kaneko et al. 1991, eqs. (6) and (7), corrected.
    """
    slid = sliding_length(input_tension, lam, pretension, length)
    start, initial, whole = (np.asarray(v, np.float64) for v in (input_tension, pretension, length))
    x = np.minimum(_position(position, whole), slid)
    signed = np.abs(_check.finite("lam", lam)) * np.sign(start - initial)
    stiffness = _check.positive("axial_stiffness", axial_stiffness)
    return x / stiffness * mean_excess(start, initial, -signed * x / whole)


def _position(position: ArrayLike, length: FloatArray) -> FloatArray:
    x = _check.non_negative("position", position)
    return _check.require("position", x, x <= length, "within the sheath, 0 to its length")
