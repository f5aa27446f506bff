"""One step's two decisions, spring by spring and element by element: slack, and stick or slide.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import numba

from tendon_mj.typing import FloatArray


@numba.njit(cache=True)
def mean_tension(before: float, after: float) -> tuple[float, float]:
    """Mean of max(0, τ) from ``before`` to ``after`` [N], and its derivative in ``after`` [–].

    τ moves evenly; below 0 is slack. The discrete gradient of the spring's energy: mean tension ×
    change of length is the change of T²/2k exactly, slack or taut.
    """
    if before >= 0.0 and after >= 0.0:
        return 0.5 * (before + after), 0.5
    if before <= 0.0 and after <= 0.0:
        return 0.0, 0.0
    taut = max(before, after) / abs(after - before)  # share of the step in which it is taut
    if after > 0.0:
        return 0.5 * after * taut, 0.5 * taut * (2.0 - taut)
    return 0.5 * before * taut, 0.5 * taut * taut


@numba.njit(cache=True)
def releases(net: float, limit_pull: float, limit_loosen: float) -> int:
    """Direction in which a resting element breaks away (+1, −1), or 0 while it stays; eq. (1)."""
    if net > limit_pull:
        return 1
    if net < -limit_loosen:
        return -1
    return 0


@numba.njit(cache=True)
def solve_tridiagonal(
    lower: FloatArray, diagonal: FloatArray, upper: FloatArray, right: FloatArray, d: FloatArray
) -> None:
    """Solve the tridiagonal system into ``d`` (Thomas); ``upper`` and ``right`` are overwritten.

    The rows here are diagonally dominant by the mass, so that no pivoting is needed; a row
    "1 · d_i = 0" gives 0 exactly.
    """
    n = diagonal.size
    upper[0] /= diagonal[0]
    right[0] /= diagonal[0]
    for i in range(1, n):
        pivot = diagonal[i] - lower[i] * upper[i - 1]
        upper[i] /= pivot
        right[i] = (right[i] - lower[i] * right[i - 1]) / pivot
    d[n - 1] = right[n - 1]
    for i in range(n - 2, -1, -1):
        d[i] = right[i] - upper[i] * d[i + 1]
