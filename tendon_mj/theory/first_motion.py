"""First motion from uniform pretension: tension and elongation along the tendon, and its ends.

Equations: docs/theory.md, section 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.theory import _check
from tendon_mj.theory._exponential import log_ratio, mean_excess, relative_excess
from tendon_mj.theory.stiffness import equivalent_backlash, tendon_stiffness, transmission_stiffness
from tendon_mj.typing import FloatArray


def sliding_length(
    input_tension: ArrayLike, lam: ArrayLike, pretension: ArrayLike, length: ArrayLike
) -> FloatArray:
    """Length from the input end over which the tendon has slid.

    L_1 = min{x : T(x) = T_0} = L |ln(T_in/T_0)|/|λ|, at most L.

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


def first_output_tension(
    displacement: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike = np.inf,
) -> FloatArray:
    """Output tension after a first motion of the input end: still in the backlash, then a line.

    T_out = T_0 for |ξ_in| ≤ |ξ_B|, else T_out − T_0 = K_t (ξ_in − ξ_B), λ signed by ξ_in.

    Raises:
        InvalidValueError: an argument out of its range, or so much paid out that the tendon
            is slack, ξ_in < −T_0 (1/K_w + 1/k_se).

    Source: Kaneko et al. 1991, eq. (16).
    """
    xi = _check.finite("displacement", displacement)
    signed = np.copysign(np.abs(_check.finite("lam", lam)), xi)
    initial = _check.non_negative("pretension", pretension)
    backlash = equivalent_backlash(signed, initial, axial_stiffness, length)
    compliance = 1.0 / tendon_stiffness(axial_stiffness, length)
    compliance = compliance + 1.0 / _check.stiffness("output_stiffness", output_stiffness)
    # a rounding error below the limit is still the limit
    taut = xi >= -initial * compliance * (1 + 1e-12)
    _check.require("displacement", xi, taut, ">= -T_0 (1/K_w + 1/k_se), where the tendon is slack")
    slope = transmission_stiffness(signed, axial_stiffness, length, output_stiffness)
    moving = np.maximum(initial + slope * (xi - backlash), 0.0)
    return np.where(np.abs(xi) <= np.abs(backlash), initial, moving)[()]


def first_input_tension(
    displacement: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike = np.inf,
) -> FloatArray:
    """Input tension after a first motion of the input end.

    Outside the backlash T_in = T_out e^λ. Inside, T_in = T_0 e^w with e^w − 1 − w =
    |λ| EA |ξ_in|/(L T_0) and w of the sign of ξ_in: eq. (6) at x = L_1, |w| = |λ| L_1/L.

    Source: Kaneko et al. 1991, eqs. (5), (6) and (14).
    """
    far = first_output_tension(
        displacement, lam, pretension, axial_stiffness, length, output_stiffness
    )
    xi, initial = np.asarray(displacement, np.float64), np.asarray(pretension, np.float64)
    signed = np.copysign(np.abs(np.asarray(lam, np.float64)), xi)
    backlash = equivalent_backlash(signed, initial, axial_stiffness, length)
    inside = (np.abs(xi) <= np.abs(backlash)) & (initial > 0)
    load = np.abs(signed * xi) * tendon_stiffness(axial_stiffness, length)
    size = np.where(inside, load, 0.0) / np.where(inside, initial, 1.0)
    return np.where(inside, initial * np.exp(_slid_exponent(size, xi)), far * np.exp(signed))[()]


def first_displacement(
    input_tension: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike = np.inf,
) -> FloatArray:
    """Displacement of the input end when T_in is reached in a first motion.

    ξ_in = δ(L) + (T_out − T_0)/k_se.

    Source: Kaneko et al. 1991, eqs. (14) and (15).
    """
    spring = _check.stiffness("output_stiffness", output_stiffness)
    elongation = elongation_profile(length, input_tension, lam, pretension, axial_stiffness, length)
    far = tension_profile(length, input_tension, lam, pretension, length)
    return elongation + (far - np.asarray(pretension, np.float64)) / spring


def _slid_exponent(size: FloatArray, sign: FloatArray) -> FloatArray:
    """Solve e^w − 1 − w = size for the w of the given sign; Newton, monotone after a step."""
    root = np.sqrt(2.0 * size)
    w = np.where(sign < 0, -root, np.minimum(root, np.log1p(size + root)))
    for _ in range(60):  # 4 to 6 suffice; the residual is free of cancellation for every w
        slope = np.where(w == 0, 1.0, np.expm1(w))
        change = np.where(w == 0, 0.0, (w * relative_excess(w) - size) / slope)
        w = w - change
        if np.all(np.abs(change) <= 2e-16 * np.abs(w)):
            break
    return w
