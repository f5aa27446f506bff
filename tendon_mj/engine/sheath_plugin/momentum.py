"""What sliding itself takes: viscous friction, the tendon's mass, and the speed they depend on.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

from typing import Any

from tendon_mj.compilation import apart, compiled
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.sheath.segments import borne
from tendon_mj.sheath.tables import DRAG, FLOW, PUSH, TENSION

MEMORY = 0.02  # time in which friction comes to know a change of sliding speed [s]


@compiled
def fill_drag(state: Any, guides: Any, elapsed: float) -> bool:
    """Fill in what a flow takes of the tension at each guide; return whether it takes any.

    (c/n) f/Δt + (m/n) (f/Δt − v⁻)/Δt = EA (D f + b).
    """
    if state[st.VISCOUS_FRICTION] == 0.0 and state[st.TENDON_MASS] == 0.0:
        return False
    _drag(state, guides, elapsed)
    return True


@apart
def _drag(state: Any, guides: Any, elapsed: float) -> None:
    n = guides.shape[1]
    shared = n * elapsed * state[st.AXIAL_STIFFNESS]
    drag = (state[st.VISCOUS_FRICTION] + state[st.TENDON_MASS] / elapsed) / shared
    for i in range(n):
        guides[DRAG, i] = drag
        guides[PUSH, i] = -state[st.TENDON_MASS] * guides[st.RAN, i] / shared


@compiled
def _rubbed(state: Any, segments: Any, guides: Any, i: int, elapsed: float) -> float:
    """Heat at guide i [J] where the tendon stiffens, or where tension also changes its speed."""
    flow, n = guides[FLOW, i], guides.shape[1]
    left, right = segments[TENSION, i], segments[TENSION, i + 1]
    shared = n * elapsed * state[st.AXIAL_STIFFNESS]
    inertia = state[st.TENDON_MASS] * (flow / elapsed - guides[st.RAN, i]) / shared
    carried = 1.0
    if left != right:
        stiffening = state[st.STIFFENING]
        carried = (borne(left, stiffening) - borne(right, stiffening)) / (left - right)
    return state[st.AXIAL_STIFFNESS] * flow * (left - right - inertia) * carried


@apart
def leave_heat(state: Any, segments: Any, guides: Any) -> None:
    """Heat of every guide in the step on trial."""
    for i in range(guides.shape[1]):
        guides[st.TRIAL_WORK, i] = _rubbed(state, segments, guides, i, state[st.TRIAL_ELAPSED])


@apart
def _remember(state: Any, guides: Any, elapsed: float) -> None:
    fresh = elapsed / (MEMORY + elapsed)
    for i in range(guides.shape[1]):
        guides[st.RAN, i] = guides[st.TRIAL_FLOW, i] / elapsed
        guides[st.SPEED, i] += fresh * (abs(guides[st.RAN, i]) - guides[st.SPEED, i])


@apart
def _forget(guides: Any) -> None:
    for i in range(guides.shape[1]):
        guides[st.RAN, i], guides[st.SPEED, i] = 0.0, 0.0


@compiled
def remember_speed(state: Any, guides: Any) -> None:
    """Make the speed of the step on trial the one before, where an effect asks for it."""
    wanted = state[st.TENDON_MASS] > 0.0 or state[st.STRIBECK_FRICTION] > 0.0
    if wanted:
        _remember(state, guides, state[st.TRIAL_ELAPSED])
    elif state[st.REMEMBERED] != 0.0:
        _forget(guides)
    state[st.REMEMBERED] = wanted
