"""The relation between a segment's tension and the unstretched length that it holds.

A segment of geometric length ℓ between two guides holds, at normalised tension τ = T/EA,

    s(τ) = (ℓ − g τ) / (1 + d + a τ)

which falls with τ. For a purely elastic segment between fixed points g = d = 0 and a = 1, that is
T = EA (ℓ/s − 1). The support compliance g [m] is the length that an elastic support at the
segment's end yields per unit τ (g = EA/k for a spring k). Damping shifts and scales the strain
(a < 1, d = κ ε⁻/(1+κ) with κ = c/(EA Δt), backward Euler); so do creep and the tangent of a tendon
that stiffens.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.sheath.records import Segments


@compiled
def held(segments: Segments, j: int, tau: float) -> tuple[float, float, float]:
    """Unstretched length s_j(τ) [m], its slope ds/dτ < 0, and d²s/dτ² > 0."""
    a = segments[j].strain_slope
    inverse = 1.0 / (1.0 + segments[j].strain_offset + a * tau)
    length = (segments[j].length - segments[j].support_compliance * tau) * inverse
    slope = -(segments[j].support_compliance + a * length) * inverse
    return length, slope, -2.0 * a * slope * inverse


@compiled
def tension_of(segments: Segments, j: int) -> float:
    """τ of a segment that keeps what it has stored; 0 when slack, inf if nothing can yield."""
    stored = segments[j].stored
    softness = segments[j].strain_slope * stored + segments[j].support_compliance
    if softness <= 0.0:
        return float("inf")
    pull = segments[j].length - stored * (1.0 + segments[j].strain_offset)
    return max(0.0, pull / softness)


@compiled
def strain_at(tau: float, stiffening: float) -> float:
    """Elastic strain ε ≥ 0 at a tension: the root of τ = ε (1 + κ ε)."""
    return 2.0 * tau / (1.0 + math.sqrt(1.0 + 4.0 * stiffening * tau))


@compiled
def convected(tau: float, stiffening: float) -> float:
    """Energy that a length convects as it leaves a segment, over EA and per unstretched metre.

    T (1 + ε) − w, from its pull and its elastic energy w. With T = EA ε that is T + T²/2EA.
    """
    if stiffening == 0.0:
        return tau * (1.0 + 0.5 * tau)
    strain = strain_at(tau, stiffening)
    return tau + strain * strain * (0.5 + 2.0 / 3.0 * stiffening * strain)


@compiled
def friction_work(left: float, right: float, flow: float) -> float:
    """Friction work over EA of a ``flow`` from τ ``right`` to τ ``left`` [m], ≥ 0 if it slides.

    The difference of the energies ``convected`` on both sides, for Hooke's law.
    """
    return flow * (left - right) * (1.0 + 0.5 * (left + right))
