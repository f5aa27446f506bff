"""Search for the strength at which an effect leaves a given residual, calibration done."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tendon_mj.typing import FloatArray

TOLERANCE = 0.05  # relative, of the ratio at which the search ends
MAX_EVALUATIONS = 10


@dataclass(frozen=True)
class FoundStrength:
    """Result of a search.

    Attributes:
        strength: of the effect, in its own unit.
        ratio: of residual to noise at this strength [-].
        reached: whether the ratio is within about 10 % of its target.
    """

    strength: float
    ratio: float
    reached: bool


def calibration_projector(
    sensitivities: list[FloatArray],
) -> Callable[[FloatArray], FloatArray]:
    """Projector onto the residuals that a linear calibration of parameters cannot remove.

    Args:
        sensitivities: of the whitened signal, (samples,) for each calibrated parameter.

    Returns:
        Function of a whitened residual r: r − Q Qᵀ r, with Q a basis of the sensitivities.
    """
    if not sensitivities:
        return lambda residual: residual
    basis, _ = np.linalg.qr(np.stack(sensitivities, axis=1))
    return lambda residual: residual - basis @ (basis.T @ residual)


def find_strength(
    ratio: Callable[[float], float], target: float, low: float, high: float, start: float
) -> FoundStrength:
    """Find a strength by the secant method in log ratio over log strength.

    Args:
        ratio: of residual to noise, increasing in the strength.
        target: wanted ratio [-].
        low: smallest strength.
        high: largest strength.
        start: strength of the first evaluation.

    Returns:
        The best strength evaluated, which need not reach the target. Steps stay inside the
        bracket of earlier evaluations.
    """
    below, above = math.log(low), math.log(high)
    at = min(max(math.log(start), below), above)
    points: list[tuple[float, float]] = []
    best = FoundStrength(start, 0.0, False)
    for _ in range(MAX_EVALUATIONS):
        value = ratio(math.exp(at))
        miss = math.log(max(value, 1e-12) / target)
        if not points or abs(miss) < abs(math.log(max(best.ratio, 1e-12) / target)):
            best = FoundStrength(math.exp(at), value, False)
        if abs(miss) <= math.log1p(TOLERANCE):
            break
        points.append((at, miss))
        if miss < 0.0:
            below = max(below, at)
        else:
            above = min(above, at)
        if above - below < 1e-6:
            break
        guess = at - miss
        if len(points) > 1 and abs(points[-1][1] - points[-2][1]) > 1e-9:
            (a, fa), (b, fb) = points[-2:]
            guess = b - fb * (b - a) / (fb - fa)
        edge = at in (math.log(low), math.log(high))
        if not below < guess < above:
            open_end = (miss < 0.0 and above == math.log(high)) and not edge
            open_start = (miss > 0.0 and below == math.log(low)) and not edge
            guess = above if open_end else below if open_start else 0.5 * (below + above)
        at = guess
    return FoundStrength(
        best.strength, best.ratio, abs(math.log(max(best.ratio, 1e-12) / target)) <= 0.1
    )
