"""How strong an effect is: the residual that calibration cannot remove, over the noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CLOSE = 0.05  # share by which the ratio may miss its target
TRIES = 10


@dataclass(frozen=True)
class Found:
    """A strength, the ratio that it makes, and whether that is the target's."""

    strength: float
    ratio: float
    reached: bool


def projector(sensitivities: list[FloatArray]) -> Callable[[FloatArray], FloatArray]:
    """What a linear calibration of the uncertain parameters leaves of a whitened residual."""
    if not sensitivities:
        return lambda residual: residual
    basis, _ = np.linalg.qr(np.stack(sensitivities, axis=1))
    return lambda residual: residual - basis @ (basis.T @ residual)


def find(
    ratio: Callable[[float], float], target: float, low: float, high: float, start: float
) -> Found:
    """Secant in log ratio over log strength, within [low, high], inside the bracket so far."""
    below, above = math.log(low), math.log(high)
    at = min(max(math.log(start), below), above)
    points: list[tuple[float, float]] = []
    best = Found(start, 0.0, False)
    for _ in range(TRIES):
        value = ratio(math.exp(at))
        miss = math.log(max(value, 1e-12) / target)
        if not points or abs(miss) < abs(math.log(max(best.ratio, 1e-12) / target)):
            best = Found(math.exp(at), value, False)
        if abs(miss) <= math.log1p(CLOSE):
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
    return Found(best.strength, best.ratio, abs(math.log(max(best.ratio, 1e-12) / target)) <= 0.1)
