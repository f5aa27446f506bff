"""Friction at the guides: the ratios of tensions that they hold, and the resistance of sliding.

    μ_i = μ max(0, 1 + γ u_i) max(0, 1 + λ (T_i − T_0)) max(0, 1 + β t) (1 ± α) + Δμ e^{−v_i/v_s},
    φ_i + φ_x/n ≥ 0

u_i is the tendon that has passed guide i, T_i the mean of the tensions beside it, v_i its sliding
speed, seen through a short memory; all are as the last finished step left them. φ_x and F_c are
shared by the n guides at sites and at the input end; those on geoms, which the tendon may leave,
have no part in them.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.sheath_plugin.state import LiveLaw, State, keep_ratio_law, tension_unit
from tendon_mj.sheath import Guide, Guides, Segments, convected

_HOLDS_ANYTHING = 37.0  # μφ: beyond it one tension is less than the rounding of the other


@compiled
def _are_current(address: int, state: State) -> bool:
    """Return whether the ratios are those of the law; they are marked as such."""
    law = state.law
    fades = law.stribeck_friction > 0.0 and law.stribeck_velocity > 0.0
    vary = fades or law.friction_gradient != 0.0 or law.friction_drift != 0.0
    vary = vary or law.load_gradient != 0.0
    varied = state.ratios_vary != 0.0
    state.ratios_vary = vary
    return keep_ratio_law(address) and state.started != 0.0 and not (vary or varied)


@compiled
def _growth(law: LiveLaw, guide: Guide, tension: float, time: float) -> float:
    """Factor by which μ has grown at a guide with what has passed it, what it bears, and time."""
    passed = max(0.0, 1.0 + law.friction_gradient * guide.passed)
    loaded = max(0.0, 1.0 + law.load_gradient * (tension - law.pretension))
    return passed * loaded * max(0.0, 1.0 + law.friction_drift * max(0.0, time))


@compiled
def _stribeck(law: LiveLaw, guide: Guide) -> float:
    """Addition to μ that fades with sliding speed [-]."""
    if law.stribeck_friction == 0.0 or law.stribeck_velocity == 0.0:
        return 0.0
    return law.stribeck_friction * math.exp(-guide.sliding_speed / law.stribeck_velocity)


@compiled
def _capstan(exponent: float) -> float:
    """e^{μφ}, so far as it makes a difference: its products over the guides stay numbers."""
    return math.exp(min(exponent, _HOLDS_ANYTHING))


@compiled
def update_ratios(
    address: int, state: State, segments: Segments, guides: Guides, time: float
) -> None:
    """Compute the ratios again where a bend or a parameter has changed; ``time`` in seconds."""
    current = _are_current(address, state)
    law, n = state.law, len(guides)
    shared = max(1.0, n - state.pulleys - state.arcs * state.arc_guides)  # by how many guides
    sliding = law.friction
    static = max(sliding, law.static_friction)  # below: as where it is not given
    asymmetry = law.direction_asymmetry
    unit = 0.5 * tension_unit(state)
    for i in range(n):
        guide = guides[i]
        angle = guide.angle
        if current and angle == guide.ratio_angle:
            continue
        guide.ratio_angle = angle
        shares = guide.is_on_arc == 0.0
        bend = angle
        if shares and law.extra_bend != 0.0:
            bend = max(0.0, angle + law.extra_bend / shared)
        grown, more = 1.0, 0.0
        if state.ratios_vary != 0.0:
            beside = segments[i].previous_tension + segments[i + 1].previous_tension
            grown, more = _growth(law, guide, unit * beside, time), _stribeck(law, guide)
        there = grown * (1.0 + asymmetry)
        guide.dynamic_ratio = _capstan((sliding * there + more) * bend)
        guide.static_ratio = guide.dynamic_ratio
        if static > sliding:
            guide.static_ratio = _capstan((static * there + more) * bend)
        guide.dynamic_ratio_back, guide.static_ratio_back = guide.dynamic_ratio, guide.static_ratio
        if asymmetry != 0.0:
            back = grown * (1.0 - asymmetry)
            guide.dynamic_ratio_back = _capstan((sliding * back + more) * bend)
            guide.static_ratio_back = _capstan((static * back + more) * bend)
        guide.constant_friction = 0.0
        if shares:
            guide.constant_friction = law.constant_friction / (shared * tension_unit(state))


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
