"""The ratios of tensions that the guides can hold, from the law's coefficients and the bends.

    μ_i = μ max(0, 1 + γ u_i) max(0, 1 + β t) (1 ± α) + Δμ e^{−v_i/v_s},   φ_i + φ_x/n ≥ 0

u_i is the tendon that has passed guide i, v_i its sliding speed, seen through a short memory; both
are as the last finished step left them.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.sheath.tables import BACK_DYNAMIC, BACK_STATIC, CONSTANT, DYNAMIC, STATIC

_LEADING = st.CONSTANT_FRICTION + 1  # parameters at the front on which the ratios depend


@compiled
def _is_bound(state: Any) -> bool:
    """Whether the coefficients are those of the ratios at hand; they count as such from now on."""
    fades = state[st.STRIBECK_FRICTION] > 0.0 and state[st.STRIBECK_VELOCITY] > 0.0
    varies = fades or state[st.FRICTION_GRADIENT] != 0.0 or state[st.FRICTION_DRIFT] != 0.0
    bound = not varies and state[st.VARIED] == 0.0
    state[st.VARIED] = varies
    for k in range(_LEADING):
        bound &= state[st.BOUND + k] == state[k]
        state[st.BOUND + k] = state[k]
    bound &= state[st.BOUND_ASYMMETRY] == state[st.DIRECTION_ASYMMETRY]
    bound &= state[st.BOUND_EXTRA_BEND] == state[st.EXTRA_BEND]
    state[st.BOUND_ASYMMETRY] = state[st.DIRECTION_ASYMMETRY]
    state[st.BOUND_EXTRA_BEND] = state[st.EXTRA_BEND]
    return bound


@compiled
def _growth(state: Any, guides: Any, i: int, time: float) -> float:
    """By which factor μ has grown at guide i, with what passed it and with time."""
    passed = max(0.0, 1.0 + state[st.FRICTION_GRADIENT] * guides[st.PASSED, i])
    return passed * max(0.0, 1.0 + state[st.FRICTION_DRIFT] * max(0.0, time))


@compiled
def _at_rest(state: Any, guides: Any, i: int) -> float:
    """What is left of the friction that fades with sliding speed [-]."""
    if state[st.STRIBECK_FRICTION] == 0.0 or state[st.STRIBECK_VELOCITY] == 0.0:
        return 0.0
    return state[st.STRIBECK_FRICTION] * math.exp(
        -guides[st.SPEED, i] / state[st.STRIBECK_VELOCITY]
    )


@compiled
def bind_ratios(state: Any, guides: Any, time: float) -> None:
    """Bring the ratios up to date where a bend or a coefficient is not what it was.

    Args:
        time: of the simulation [s].
    """
    bound = _is_bound(state)
    n = guides.shape[1]
    sliding = state[st.FRICTION]
    static = max(sliding, state[st.STATIC_FRICTION])  # below: as where it is not given
    asymmetry = state[st.DIRECTION_ASYMMETRY]
    for i in range(n):
        angle = guides[st.ANGLE, i]
        if bound and angle == guides[st.BOUND_ANGLE, i]:
            continue
        guides[st.BOUND_ANGLE, i] = angle
        bend = angle
        if state[st.EXTRA_BEND] != 0.0:
            bend = max(0.0, angle + state[st.EXTRA_BEND] / n)
        grown, more = 1.0, 0.0
        if state[st.VARIED] != 0.0:
            grown, more = _growth(state, guides, i, time), _at_rest(state, guides, i)
        there = grown * (1.0 + asymmetry)
        guides[DYNAMIC, i] = math.exp((sliding * there + more) * bend)
        guides[STATIC, i] = guides[DYNAMIC, i]
        if static > sliding:
            guides[STATIC, i] = math.exp((static * there + more) * bend)
        guides[BACK_DYNAMIC, i], guides[BACK_STATIC, i] = guides[DYNAMIC, i], guides[STATIC, i]
        if asymmetry != 0.0:
            back = grown * (1.0 - asymmetry)
            guides[BACK_DYNAMIC, i] = math.exp((sliding * back + more) * bend)
            guides[BACK_STATIC, i] = math.exp((static * back + more) * bend)
        guides[CONSTANT, i] = state[st.CONSTANT_FRICTION] / (n * state[st.AXIAL_STIFFNESS])
