"""The strain law of the tendon: Hooke's, with damping, stiffening and creep where they are set.

    T = EA ε_e (1 + κ ε_e) + c dε_e/dt,   ε = ε_e + ε_c,   τ_c dε_c/dt = χ T/EA − ε_c

The flow solver knows strains ε = d + a τ. Time derivatives become that by backward Euler; a tendon
that stiffens by its tangent, which is moved until the solution lies on it.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.sheath_plugin.state import LiveLaw, State
from tendon_mj.sheath import Guides, Segments, convected, strain_at

_CLOSE = 1e-13  # strain by which the tangent may miss the curve


@compiled
def rest_strain(law: LiveLaw, pretension: float) -> tuple[float, float]:
    """Elastic strain and creep strain under a pretension, when all has come to rest."""
    tau = pretension / law.axial_stiffness if law.axial_stiffness > 0.0 else 0.0
    creep = law.creep * tau if law.creep_time > 0.0 else 0.0
    return strain_at(tau, law.stiffening), creep


@compiled
def unstretched(state: State, length: float) -> float:
    """Unstretched length of tendon that has a ``length`` under its pretension [m]."""
    strain, creep = rest_strain(state.law, state.laid_pretension)
    return length / (1.0 + strain + creep)


@compiled
def _arrival(law: LiveLaw, elapsed: float) -> float:
    """Share of the creep still missing that comes within the step."""
    if law.creep_time == 0.0:
        return 0.0
    return elapsed / (law.creep_time + elapsed)


@compiled
def _tangent(law: LiveLaw, before: float, at: float, elapsed: float) -> tuple[float, float]:
    """Offset d and slope a of the strain law on its tangent ``at``, ``before`` the last strain.

    With K = c/(EA Δt), τ = g(ε) = ε (1 + κ ε) + K (ε − ε⁻); for κ = 0 that is a line.
    """
    kappa = law.axial_damping / (law.axial_stiffness * elapsed)
    stiffening = law.stiffening
    if stiffening == 0.0:
        share = 1.0 / (1.0 + kappa)
        return (1.0 - share) * before, share
    at = max(0.0, at)
    share = 1.0 / (1.0 + 2.0 * stiffening * at + kappa)
    return at - (at * (1.0 + stiffening * at) + kappa * (at - before)) * share, share


@apart
def reset_to_linear(segments: Segments) -> None:
    """Reset every segment to the linear law ε = τ."""
    for j in range(len(segments)):
        segments[j].strain_offset, segments[j].strain_slope = 0.0, 1.0


@apart
def _fill_tangents(state: State, segments: Segments, elapsed: float) -> None:
    """Set each segment's strain law to the tangent at the strain that it had."""
    if state.strain_kept == 0.0:
        for j in range(len(segments)):
            segments[j].strain = strain_at(segments[j].previous_tension, state.law.stiffening)
        state.strain_kept = 1.0
    arrives = _arrival(state.law, elapsed)
    for j in range(len(segments)):
        before = segments[j].strain
        offset, share = _tangent(state.law, before, before, elapsed)
        segments[j].strain_offset = offset + (1.0 - arrives) * segments[j].creep_strain
        segments[j].strain_slope = share + arrives * state.law.creep


@compiled
def fill_strain(state: State, segments: Segments, elapsed: float) -> bool:
    """Fill in each segment's strain law; return whether it is another than Hooke's."""
    plain = (
        state.law.axial_damping == 0.0
        and state.law.stiffening == 0.0
        and state.law.creep_time == 0.0
    )
    if plain:
        if state.strain_kept != 0.0:
            reset_to_linear(segments)
            state.strain_kept = 0.0
        return False
    _fill_tangents(state, segments, elapsed)
    return True


@apart
def move_tangents(state: State, segments: Segments, elapsed: float) -> bool:
    """Move the tangents to where the solution lies; return whether that made a difference."""
    law, moved = state.law, False
    arrives = _arrival(law, elapsed)
    for j in range(len(segments)):
        segment = segments[j]
        tau = segment.tension
        creep = (1.0 - arrives) * segment.creep_strain
        at = segment.strain_offset - creep + (segment.strain_slope - arrives * law.creep) * tau
        touching = at if tau > 0.0 else 0.0  # what a far tangent calls slack need not be
        offset, slope = _tangent(law, segment.strain, touching, elapsed)
        moved |= abs(offset + slope * tau - at) > _CLOSE
        segment.strain_offset = offset + creep
        segment.strain_slope = slope + arrives * law.creep
    return moved


@compiled
def _creep_after(state: State, segments: Segments, j: int, elapsed: float) -> float:
    """Creep strain of segment j at the end of the step."""
    arrives = _arrival(state.law, elapsed)
    reached = arrives * state.law.creep * segments[j].tension
    return (1.0 - arrives) * segments[j].creep_strain + reached


@apart
def store_new_strain(state: State, segments: Segments, guides: Guides, elapsed: float) -> None:
    """Store the elastic strain of every segment once the flow of this evaluation has passed."""
    n = len(guides)
    for j in range(n + 1):
        holds = segments[j].stored
        holds += guides[j].flow if j < n else 0.0
        holds -= guides[j - 1].flow if j > 0 else 0.0
        length = segments[j].length - segments[j].support_compliance * segments[j].tension
        segments[j].new_strain = length / holds - 1.0 - _creep_after(state, segments, j, elapsed)


@apart
def store_trial_strain(state: State, segments: Segments) -> None:
    """Store the strains of this evaluation for ``commit_strain``."""
    for j in range(len(segments)):
        segments[j].trial_strain = segments[j].new_strain
        segments[j].trial_creep_strain = _creep_after(state, segments, j, state.trial_elapsed)


@apart
def commit_strain(segments: Segments, guides: Guides) -> None:
    """Make the strains on trial the committed ones; creep strain is convected with the flow.

    That the tendon and not the place has crept is what keeps a flow from making energy. To be
    called before the flow changes what is stored.
    """
    for j in range(len(segments)):
        segments[j].strain = segments[j].trial_strain
        segments[j].creep_strain = segments[j].trial_creep_strain
    for i in range(len(guides)):
        flow = guides[i].trial_flow
        if flow != 0.0:
            to, source = (i, i + 1) if flow > 0.0 else (i + 1, i)
            share = abs(flow) / max(segments[to].stored + abs(flow), abs(flow))
            creep = segments[to].creep_strain
            segments[to].creep_strain = creep + share * (segments[source].creep_strain - creep)


@compiled
def spool_torque(state: State, segments: Segments, j: int, radius: float) -> float:
    """Torque that segment j exerts on a spool: −∂U/∂θ of U, r (T + T²/2EA)/(1 + ε_0).

    T²/2EA is the energy that goes onto the drum; with it no cycle gains any. In general the bracket
    is T (1 + ε) − w, w = w_e + EA ε_c²/2χ being the energy per unstretched length.
    """
    radius = unstretched(state, radius)
    tau, ea = segments[j].tension, state.law.axial_stiffness
    creeps = state.law.creep > 0.0 and state.law.creep_time > 0.0
    if state.law.stiffening == 0.0 and not creeps:
        return radius * ea * tau * (1.0 + 0.5 * tau)
    pull = convected(tau, state.law.stiffening)
    if creeps:
        pull += segments[j].creep_strain * (tau - 0.5 * segments[j].creep_strain / state.law.creep)
    return radius * ea * pull
