"""Resistance of sliding itself: viscous friction, the tendon's mass, the speed they depend on.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

from tendon_mj.compilation import apart, compiled
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.sheath import Guides, Segments, convected

MEMORY = 0.02  # time constant with which friction follows a change of sliding speed [s]


@compiled
def fill_drag(state: State, guides: Guides, elapsed: float) -> bool:
    """Fill in the tension that a flow takes at each guide; return whether it takes any.

    (c/n) f/Δt + (m/n) (f/Δt − v⁻)/Δt = EA (D f + b).
    """
    if state.law.viscous_friction == 0.0 and state.law.tendon_mass == 0.0:
        return False
    _fill_drag(state, guides, elapsed)
    return True


@apart
def _fill_drag(state: State, guides: Guides, elapsed: float) -> None:
    n = len(guides)
    shared = n * elapsed * state.law.axial_stiffness
    drag = (state.law.viscous_friction + state.law.tendon_mass / elapsed) / shared
    for i in range(n):
        guides[i].drag = drag
        guides[i].momentum = -state.law.tendon_mass * guides[i].previous_velocity / shared


@compiled
def _friction_work(
    state: State, segments: Segments, guides: Guides, i: int, elapsed: float
) -> float:
    """Friction work at guide i [J] where the tendon stiffens, or where tension accelerates it."""
    law, flow, n = state.law, guides[i].flow, len(guides)
    left, right = segments[i].tension, segments[i + 1].tension
    shared = n * elapsed * law.axial_stiffness
    inertia = law.tendon_mass * (flow / elapsed - guides[i].previous_velocity) / shared
    slope = 1.0
    if left != right:
        stiffening = law.stiffening
        slope = (convected(left, stiffening) - convected(right, stiffening)) / (left - right)
    return law.axial_stiffness * flow * (left - right - inertia) * slope


@apart
def store_trial_friction_work(state: State, segments: Segments, guides: Guides) -> None:
    """Store the friction work of every guide in the step on trial; a pulley does not rub."""
    for i in range(len(guides)):
        if guides[i].is_pulley == 0.0:
            work = _friction_work(state, segments, guides, i, state.trial_elapsed)
            guides[i].trial_friction_work = work


@apart
def _update_velocity(guides: Guides, elapsed: float) -> None:
    fresh = elapsed / (MEMORY + elapsed)
    for i in range(len(guides)):
        guide = guides[i]
        guide.previous_velocity = guide.trial_flow / elapsed
        guide.sliding_speed += fresh * (abs(guide.previous_velocity) - guide.sliding_speed)


@apart
def _reset_velocity(guides: Guides) -> None:
    for i in range(len(guides)):
        guides[i].previous_velocity, guides[i].sliding_speed = 0.0, 0.0


@compiled
def commit_velocity(state: State, guides: Guides) -> None:
    """Make the speed of the step on trial the one before, where an effect asks for it."""
    wanted = state.law.tendon_mass > 0.0 or state.law.stribeck_friction > 0.0
    if wanted:
        _update_velocity(guides, state.trial_elapsed)
    elif state.speed_kept != 0.0:
        _reset_velocity(guides)
    state.speed_kept = wanted
