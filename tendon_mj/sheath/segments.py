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


@compiled
def held(length: float, give: float, offset: float, a: float, tau: float) -> float:
    """Unstretched length s(τ) of a segment [m]."""
    return (length - give * tau) / (1.0 + offset + a * tau)


@compiled
def held_slope(length: float, give: float, offset: float, a: float, tau: float) -> float:
    """ds/dτ of a segment [m], negative."""
    strain = 1.0 + offset + a * tau
    return -(give * strain + a * (length - give * tau)) / (strain * strain)


@compiled
def tension_of(length: float, give: float, offset: float, a: float, stored: float) -> float:
    """Normalised tension of a segment that holds ``stored``; 0 when slack, inf when stored ≤ 0."""
    if stored <= 0.0:
        return float("inf")
    return max(0.0, (length - stored * (1.0 + offset)) / (a * stored + give))
