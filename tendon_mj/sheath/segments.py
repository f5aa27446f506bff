"""How much unstretched tendon a segment holds at a given tension.

A segment of geometric length ℓ between two guides holds, at normalised tension τ = T/EA,

    s(τ) = (ℓ − g τ) / (1 + d + a τ)

which falls with τ. For a purely elastic segment between fixed points g = d = 0 and a = 1, that is
T = EA (ℓ/s − 1). The give g [m] is the length that an elastic support at that segment's end gives
up per unit τ (g = EA/k for a spring k). Damping shifts and scales the strain (a < 1, d = κ ε⁻/(1+κ)
with κ = c/(EA Δt), backward Euler); so do creep and the tangent of a tendon that stiffens.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.sheath.tables import GIVE, LENGTH, OFFSET, SHARE, STORED, Table


@compiled
def held(segments: Table, j: int, tau: float) -> tuple[float, float, float]:
    """Unstretched length s_j(τ) [m], its slope ds/dτ < 0, and d²s/dτ² > 0."""
    a = segments[SHARE, j]
    inverse = 1.0 / (1.0 + segments[OFFSET, j] + a * tau)
    length = (segments[LENGTH, j] - segments[GIVE, j] * tau) * inverse
    slope = -(segments[GIVE, j] + a * length) * inverse
    return length, slope, -2.0 * a * slope * inverse


@compiled
def tension_of(segments: Table, j: int) -> float:
    """τ of a segment that keeps what it has stored; 0 when slack, inf when nothing is stored."""
    stored = segments[STORED, j]
    if stored <= 0.0:
        return float("inf")
    pull = segments[LENGTH, j] - stored * (1.0 + segments[OFFSET, j])
    return max(0.0, pull / (segments[SHARE, j] * stored + segments[GIVE, j]))


@compiled
def strain_at(tau: float, stiffening: float) -> float:
    """Elastic strain ε ≥ 0 at a tension: the root of τ = ε (1 + κ ε)."""
    return 2.0 * tau / (1.0 + math.sqrt(1.0 + 4.0 * stiffening * tau))


@compiled
def borne(tau: float, stiffening: float) -> float:
    """What a length that leaves takes along, over EA and per unstretched metre.

    T (1 + ε) − w, its pull and its elastic energy w. With T = EA ε that is T + T²/2EA.
    """
    if stiffening == 0.0:
        return tau * (1.0 + 0.5 * tau)
    strain = strain_at(tau, stiffening)
    return tau + strain * strain * (0.5 + 2.0 / 3.0 * stiffening * strain)


@compiled
def released(left: float, right: float, flow: float) -> float:
    """Heat over EA when ``flow`` passes from τ ``right`` to τ ``left`` [m], ≥ 0 as friction slides.

    A length that leaves a segment takes along what is ``borne`` there; this is for Hooke's law.
    """
    return flow * (left - right) * (1.0 + 0.5 * (left + right))
