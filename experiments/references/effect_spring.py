"""Tensions of the springs of a chain with effects, and their derivatives (Numba).

Springs are written in newtons: τ = EA × strain. With a = 1/EA, k = EA/ℓ, ℓ the place that a piece
of tendon has and s the unstretched length in it, at first ℓ/(1 + a τ_0), then less by what left, g:

    τ = EA (ℓ/s − 1) = (τ_0 e + k (g − y))/(e − a k g),   e = 1/(1 + a τ_0),

y what ℓ itself has lost because its output end moved. a = 0 is infinitesimal strain.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import numba

from experiments.references.effect_system import EffectChain, Material

_ITERATIONS = 30
_TOLERANCE = 1e-11  # of 1 N + tension


@numba.njit(cache=True)
def spring_tension(
    material: Material,
    k: float,
    creep_strain: float,
    gain: float,
    shift: float,
    mount_compliance: float,
    output_compliance: float,
    guess: float,
) -> tuple[float, float, float]:
    """Return the tension of a spring [N] and its derivatives in ``gain`` and −``shift`` [N/m].

    ``gain`` is what it has lost of unstretched length on the input side less what it got on the
    output side; ``shift`` is y. ``mount_compliance`` [m/N] is that of the mount, which takes some
    of ``gain``, ``output_compliance`` [m/N] that of a massless output, which adds to ``shift``.
    ``creep_strain`` is EA ε_c [N]. Newton from ``guess``.
    """
    a, start, stiffening = material.compliance, material.initial_strain, material.stiffening
    e = 1.0 / (1.0 + a * start)
    tension = guess
    gain_slope, shift_slope = 0.0, 0.0
    for _ in range(_ITERATIONS):
        excess = tension - material.pretension
        g = gain - mount_compliance * excess
        bottom = e - a * k * g
        top = start * e + k * (g - shift - output_compliance * excess)
        elastic = top / bottom - creep_strain
        if elastic <= 0.0:  # slack: the compliances alone set the length
            if tension <= 0.0:
                return 0.0, 0.0, 0.0
            tension = 0.0
            continue
        tangent = 1.0 + 2.0 * stiffening * a * elastic
        shift_slope = tangent * k / bottom
        gain_slope = shift_slope + tangent * a * k * top / bottom**2
        total = 1.0 + mount_compliance * gain_slope + output_compliance * shift_slope
        change = (elastic * (1.0 + stiffening * a * elastic) - tension) / total
        tension += change
        gain_slope, shift_slope = gain_slope / total, shift_slope / total
        if abs(change) <= _TOLERANCE * (1.0 + tension):
            break
    return max(tension, 0.0), gain_slope, shift_slope


@numba.njit(cache=True)
def linearise_springs(chain: EffectChain, drum: float) -> None:
    """Set the tensions of all springs at the end of a step, and their derivatives [N/m].

    ``drum`` is the displacement of the drum [m]. Retardation acts on what the elements pass; mount,
    drum and output move too slowly to matter.
    """
    material, nodes, springs = chain.material, chain.nodes, chain.springs
    n, free = chain.elements.size, chain.carriages.size == 0
    gain = drum
    for j in range(n + 1):
        spring, shift = springs[j], 0.0
        if j > 0:
            gain = nodes[j - 1].displacement + nodes[j - 1].increment
        if j < n:
            gain -= nodes[j].displacement + nodes[j].increment
        elif not free:
            shift = nodes[n].displacement + nodes[n].increment
        spring.tension, spring.input_slope, spring.output_slope = spring_tension(
            material,
            spring.stiffness,
            spring.next_creep_strain,
            gain,
            shift,
            chain.mount_compliance if j == 0 else 0.0,
            chain.output_compliance if j == n and free else 0.0,
            spring.tension,
        )
        if j < n:
            spring.output_slope = spring.input_slope
        if material.retardation_time > 0.0 and 0 < j < n:
            before, behind = nodes[j - 1], nodes[j]
            slow = material.retardation_time * spring.stiffness
            spring.tension += slow * (before.rate * before.increment + before.rate_offset)
            spring.tension -= slow * (behind.rate * behind.increment + behind.rate_offset)
            spring.input_slope += slow * before.rate
            spring.output_slope += slow * behind.rate
