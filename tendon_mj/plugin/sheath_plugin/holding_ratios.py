"""The ratios of tensions that the guides can hold, from the law's coefficients and the bends.

    μ_i = μ max(0, 1 + γ u_i) max(0, 1 + β t) (1 ± α) + Δμ e^{−v_i/v_s},   φ_i + φ_x/n ≥ 0

u_i is the tendon that has passed guide i, v_i its sliding speed, seen through a short memory; both
are as the last finished step left them. φ_x and F_c are shared by the n guides at sites and at the
input end; those on geoms, which the tendon may leave, have no part in them.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.sheath_plugin.state import LiveLaw, State, keep_ratio_law
from tendon_mj.sheath import Guide, Guides

_HOLDS_ANYTHING = 230.0  # μφ beyond which nothing changes, but e^{μφ} overflows in the end


@compiled
def _are_current(address: int, state: State) -> bool:
    """Whether the ratios at hand are those of the law; they count as such from now on."""
    law = state.law
    fades = law.stribeck_friction > 0.0 and law.stribeck_velocity > 0.0
    vary = fades or law.friction_gradient != 0.0 or law.friction_drift != 0.0
    varied = state.ratios_vary != 0.0
    state.ratios_vary = vary
    return keep_ratio_law(address) and not (vary or varied)


@compiled
def _growth(law: LiveLaw, guide: Guide, time: float) -> float:
    """Factor by which μ has grown at a guide, with the tendon that passed it and with time."""
    passed = max(0.0, 1.0 + law.friction_gradient * guide.passed)
    return passed * max(0.0, 1.0 + law.friction_drift * max(0.0, time))


@compiled
def _stribeck(law: LiveLaw, guide: Guide) -> float:
    """Addition to μ that fades with sliding speed [-]."""
    if law.stribeck_friction == 0.0 or law.stribeck_velocity == 0.0:
        return 0.0
    return law.stribeck_friction * math.exp(-guide.sliding_speed / law.stribeck_velocity)


@compiled
def _capstan(exponent: float) -> float:
    """e^{μφ}, finite: an infinite one would leave no tension beside a slack segment."""
    return math.exp(min(exponent, _HOLDS_ANYTHING))


@compiled
def update_ratios(address: int, state: State, guides: Guides, time: float) -> None:
    """Bring the ratios up to date where a bend or a parameter is not what it was.

    Args:
        address: of the sheath's state.
        state, guides: of the sheath.
        time: of the simulation [s].
    """
    current = _are_current(address, state)
    law, n = state.law, len(guides)
    shared = max(1.0, n - state.pulleys - state.arcs * state.arc_guides)  # by how many guides
    sliding = law.friction
    static = max(sliding, law.static_friction)  # below: as where it is not given
    asymmetry = law.direction_asymmetry
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
            grown, more = _growth(law, guide, time), _stribeck(law, guide)
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
            guide.constant_friction = law.constant_friction / (shared * law.axial_stiffness)
