"""How much unstretched tendon a segment holds at a given tension.

A segment of geometric length ℓ between two guides holds, at normalised tension τ = T/EA,

    s(τ) = (ℓ − g τ) / (1 + d + a τ)

which falls with τ. For a purely elastic segment between fixed points g = d = 0 and a = 1, that is
T = EA (ℓ/s − 1). The give g [m] is the length that an elastic support at that segment's end gives
up per unit τ (g = EA/k for a spring k). Damping shifts and scales the strain (a < 1, d = κ ε⁻/(1+κ)
with κ = c/(EA Δt), backward Euler).
"""

from __future__ import annotations

from tendon_mj.sheath.compiled import compiled
from tendon_mj.sheath.tables import GIVE, LENGTH, OFFSET, STORED, Table


@compiled
def held(segments: Table, a: float, j: int, tau: float) -> tuple[float, float, float]:
    """Unstretched length s_j(τ) [m], its slope ds/dτ < 0, and d²s/dτ² > 0."""
    inverse = 1.0 / (1.0 + segments[OFFSET, j] + a * tau)
    length = (segments[LENGTH, j] - segments[GIVE, j] * tau) * inverse
    slope = -(segments[GIVE, j] + a * length) * inverse
    return length, slope, -2.0 * a * slope * inverse


@compiled
def tension_of(segments: Table, a: float, j: int) -> float:
    """τ of a segment that keeps what it has stored; 0 when slack, inf when nothing is stored."""
    stored = segments[STORED, j]
    if stored <= 0.0:
        return float("inf")
    pull = segments[LENGTH, j] - stored * (1.0 + segments[OFFSET, j])
    return max(0.0, pull / (a * stored + segments[GIVE, j]))


@compiled
def released(left: float, right: float, flow: float) -> float:
    """Heat over EA when ``flow`` passes from τ ``right`` to τ ``left`` [m], ≥ 0 as friction slides.

    A length that leaves a segment takes T + T²/2EA a metre along: its pull and its elastic energy.
    """
    return flow * (left - right) * (1.0 + 0.5 * (left + right))
