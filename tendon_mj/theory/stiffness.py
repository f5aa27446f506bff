"""Stiffness and play of a tendon seen from its ends: apparent stiffness and equivalent backlash.

Equations: docs/theory.md, section 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.theory import _check
from tendon_mj.theory._exponential import inverse_relative, relative_excess
from tendon_mj.typing import FloatArray


def tendon_stiffness(axial_stiffness: ArrayLike, length: ArrayLike) -> FloatArray:
    """Stiffness of the tendon without friction, K_w = EA/L.

    Source: Kaneko et al. 1991, eq. (19).
    """
    stiffness = _check.positive("axial_stiffness", axial_stiffness)
    return stiffness / _check.positive("length", length)


def apparent_stiffness(lam: ArrayLike, axial_stiffness: ArrayLike, length: ArrayLike) -> FloatArray:
    """Stiffness that the tendon shows while all of it slides: soft pulling, stiff loosening.

    K_ap = K_w λ/(e^λ − 1), which tends to K_w for λ → 0.

    Source: Kaneko et al. 1991, eq. (18).
    """
    return tendon_stiffness(axial_stiffness, length) * inverse_relative(_check.finite("lam", lam))


def equivalent_backlash(
    lam: ArrayLike, pretension: ArrayLike, axial_stiffness: ArrayLike, length: ArrayLike
) -> FloatArray:
    """Displacement of the input end before the output tension leaves the pretension.

    ξ_B = (T_0 L/EA)(e^λ − λ − 1)/λ, which tends to 0 for λ → 0 and has the sign of λ.
    The paper's transcript of (11) lacks the −λ; its own series (13) has it.

    Source: Kaneko et al. 1991, eq. (11), corrected by eq. (13).
    """
    free = _check.non_negative("pretension", pretension) / tendon_stiffness(axial_stiffness, length)
    return free * relative_excess(_check.finite("lam", lam))


def reversal_backlash(
    lam: ArrayLike, tension: ArrayLike, axial_stiffness: ArrayLike, length: ArrayLike
) -> FloatArray:
    """Travel of the input end from one branch to the other, the output tension held.

    Δξ = (T* L/EA)(e^λ + e^{−λ} − 2)/λ = (T* L/EA) 4 sinh²(λ/2)/λ, which tends to 0 for λ → 0.
    A motion of exponent λ ends at T*; Δξ is paid out before T* changes (λ < 0: −Δξ is taken in).

    Source: Kaneko et al. 1991, eqs. (5) and (6) for a reversal.
    """
    exponent = _check.finite("lam", lam)
    free = _check.non_negative("tension", tension) / tendon_stiffness(axial_stiffness, length)
    half = 0.5 * exponent
    with np.errstate(over="ignore"):
        ratio = np.sinh(half) / np.where(half == 0, 1.0, half)
        return free * 2.0 * np.sinh(half) * np.where(half == 0, 1.0, ratio)


def transmission_stiffness(
    lam: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    environment_stiffness: ArrayLike = np.inf,
    sensor_stiffness: ArrayLike = np.inf,
) -> FloatArray:
    """Slope of output tension over input displacement, outside the backlash.

    1/K_t = 1/k_e + 1/k_s + 1/K_ap.

    Source: Kaneko et al. 1991, eq. (17).
    """
    tendon = apparent_stiffness(lam, axial_stiffness, length)
    environment = _check.stiffness("environment_stiffness", environment_stiffness)
    sensor = _check.stiffness("sensor_stiffness", sensor_stiffness)
    # K_ap in the numerator: it underflows to 0, and K_t with it, for an extreme λ
    return tendon / (1.0 + tendon / environment + tendon / sensor)
