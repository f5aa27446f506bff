"""Fronts of slip of a cable in a sheath, without MuJoCo and without this package.

A cable bears a tension at each place of its sheath. If one end takes up cable, the tension there
rises to P, and along the sheath it becomes max(T, P e^(-μφ)), with the bend φ counted from that
end; if the end gives cable back, it becomes min(T, P e^(μφ)). With P the stretch ∫ T/EA grows by
what was taken up. These are the capstan's fronts of slip, exact in each step; strains are small.
"""

from __future__ import annotations

import numba

from tendon_mj.typing import FloatArray

PLACES = 101  # along a sheath, its ends included


@numba.njit
def stretch_of_place(length: float, axial_stiffness: float, pretension: float) -> float:
    """Stretch of one place of a cable [m/N], which fills its path under the pretension."""
    return length / (PLACES - 1) / (axial_stiffness + pretension)


@numba.njit
def front(
    tension: FloatArray, ratio: FloatArray, stretch: float, taken: float
) -> tuple[float, int]:
    """Tension at the first end of a cable that this end moves by ``taken`` [m], and its front.

    ``ratio`` is e^(-μφ) from that end, ``stretch`` that of one place for one newton [m/N].
    """
    rises = taken > 0.0
    held, scale, last = taken / stretch, 0.0, len(tension) - 1
    for k in range(last + 1):
        weight = 0.5 if k in (0, last) else 1.0
        held += weight * tension[k]
        scale += weight * (ratio[k] if rises else 1.0 / ratio[k])
        first = held / scale
        if k == last:
            break
        following = first * (ratio[k + 1] if rises else 1.0 / ratio[k + 1])
        if (following <= tension[k + 1]) if rises else (following >= tension[k + 1]):
            break
    return first, k


@numba.njit
def take_up(tension: FloatArray, ratio: FloatArray, stretch: float, taken: float) -> None:
    """Move the first end of a cable by ``taken``; see `front`."""
    first, last = front(tension, ratio, stretch, taken)
    for i in range(last + 1):
        tension[i] = first * (ratio[i] if taken > 0.0 else 1.0 / ratio[i])
