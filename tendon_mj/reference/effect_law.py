"""Laws of one spring and of the friction of all elements, with effects (Numba).

Springs are written in newtons: τ = EA × strain. With α = 1/EA, k = EA/ℓ, ℓ the place that a piece
of tendon has and s the unstretched length in it, at first ℓ/(1 + α τ_0), then less by what left, g:

    τ = EA (ℓ/s − 1) = (τ_0 e + k (g − y))/(e − α k g),   e = 1/(1 + α τ_0),

y what ℓ itself has lost because its output end moved. α = 0 is infinitesimal strain.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math

from tendon_mj.compilation import checked
from tendon_mj.reference.checks import FloatArray


@checked
def pull(
    gain: float,
    shift: float,
    yielding: float,
    giving: float,
    k: float,
    alpha: float,
    start: float,
    crept: float,
    stiffening: float,
    pretension: float,
    guess: float,
) -> tuple[float, float, float]:
    """Return the tension of a spring [N] and its derivatives in ``gain`` and −``shift`` [N/m].

    ``gain`` is what it has lost of unstretched length on the input side less what it got on the
    output side; ``shift`` is y. ``yielding`` [m/N] is the compliance of the mount that takes some
    of ``gain``, ``giving`` [m/N] that of a massless output, which adds to ``shift``. ``start`` is
    τ_0, ``crept`` is EA ε_c. Newton from ``guess``.
    """
    e = 1.0 / (1.0 + alpha * start)
    tension = guess
    pulled, let = 0.0, 0.0
    for _ in range(30):
        excess = tension - pretension
        g = gain - yielding * excess
        bottom = e - alpha * k * g
        top = start * e + k * (g - shift - giving * excess)
        elastic = top / bottom - crept
        if elastic <= 0.0:  # slack: by the mount's and the output's yield alone
            if tension <= 0.0:
                return 0.0, 0.0, 0.0
            tension = 0.0
            continue
        steep = 1.0 + 2.0 * stiffening * alpha * elastic
        let = steep * k / bottom
        pulled = let + steep * alpha * k * top / bottom**2
        stiff = 1.0 + yielding * pulled + giving * let
        change = (elastic * (1.0 + stiffening * alpha * elastic) - tension) / stiff
        tension += change
        pulled, let = pulled / stiff, let / stiff
        if abs(change) <= 1e-11 * (1.0 + tension):
            break
    return max(tension, 0.0), pulled, let


@checked
def ratios(
    angle: FloatArray,
    resting: FloatArray,
    sliding: FloatArray,
    asymmetry: float,
    gradient: float,
    aged: float,
    weakening: float,
    weak_speed: float,
    passed: FloatArray,
    speed: FloatArray,
    hold: FloatArray,
    slide: FloatArray,
) -> None:
    """Fill T_high/T_low of each element at rest and sliding, rows: to the input, to the output.

    ``aged`` is max(0, 1 + β t).
    """
    for i in range(angle.size):
        scale = aged * max(0.0, 1.0 + gradient * passed[i])
        extra = weakening * math.exp(-speed[i] / weak_speed) if weakening > 0.0 else 0.0
        for side in range(2):
            way = scale * (1.0 + asymmetry if side == 0 else 1.0 - asymmetry)
            slide[side, i] = math.exp((sliding[i] * way + extra) * angle[i])
            hold[side, i] = slide[side, i]
            if resting[i] > sliding[i]:
                hold[side, i] = math.exp((resting[i] * way + extra) * angle[i])
