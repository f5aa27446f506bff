"""A sheath's part in a time step: evaluate the tendon, apply its forces, commit what happened.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.engine import state as st
from tendon_mj.engine.memory import coordinates, double, doubles, integer, pointer
from tendon_mj.engine.moment import control, is_stage
from tendon_mj.engine.path import follow_path
from tendon_mj.engine.wrench import add_force
from tendon_mj.sheath.compiled import compiled
from tendon_mj.sheath.flow import settle
from tendon_mj.sheath.segments import released
from tendon_mj.sheath.tables import (
    CONSTANT,
    DYNAMIC,
    FLOW,
    LENGTH,
    OFFSET,
    SLIP,
    STATIC,
    STORED,
    TENSION,
    WAS,
)

_LAWS = st.CONSTANT_FRICTION + 1  # the leading parameters, on which the guides' ratios depend


@compiled
def _copy(segments: Any, row: int, into: int) -> None:
    """Copy a row; assigning slices compiles to several times as much."""
    for j in range(segments.shape[1]):
        segments[into, j] = segments[row, j]


@compiled
def _turned(layout: Any, m: int, d: int, state: Any, joint: int, radius: int) -> float:
    """Tendon that the spool on a joint has wound in since `qpos0` [m]; 0 without a spool."""
    if state[joint] < 0.0:
        return 0.0
    adr = integer(pointer(m + layout.m_jnt_qposadr), int(state[joint]))
    turn = double(pointer(d + layout.d_qpos), adr) - double(pointer(m + layout.m_qpos0), adr)
    return state[radius] * turn


@compiled
def _start(layout: Any, m: int, d: int, state: Any, segments: Any) -> None:
    """Lay the tendon evenly along its first path.

    Its unstretched length is fixed by the pretension in the reference pose `qpos0`, as MuJoCo fixes
    a spring length: S = L(qpos0)/(1 + T_0/EA).
    """
    reference = double(pointer(m + layout.m_tendon_length0), int(state[st.TENDON]))
    unstretched = reference / (1.0 + state[st.PRETENSION] / state[st.AXIAL_STIFFNESS])
    state[st.WOUND_IN] = _turned(layout, m, d, state, st.REEL_JOINT, st.REEL_RADIUS)
    state[st.WOUND_OUT] = _turned(layout, m, d, state, st.OUTPUT_JOINT, st.OUTPUT_RADIUS)
    unstretched -= state[st.WOUND_IN] + state[st.WOUND_OUT]
    total = segments[LENGTH].sum()
    for j in range(segments.shape[1]):
        segments[STORED, j] = segments[LENGTH, j] * unstretched / total
        segments[st.STRAIN, j] = total / unstretched - 1.0
        segments[st.START, j] = total / unstretched - 1.0
    state[st.COMMIT_TIME] = double(d + layout.d_time, 0) - double(m + layout.o_timestep, 0)
    state[st.STARTED] = 1.0


@compiled
def _bind_guides(state: Any, guides: Any) -> None:
    """Ratios that the guides can hold, where a bend or a coefficient is not what it was."""
    anew = False
    for k in range(_LAWS):
        anew |= state[st.BOUND + k] != state[k]
        state[st.BOUND + k] = state[k]
    n = guides.shape[1]
    same = state[st.STATIC_FRICTION] <= state[st.FRICTION]  # as where it is not given
    for i in range(n):
        angle = guides[st.ANGLE, i]
        if anew or angle != guides[st.BOUND_ANGLE, i]:
            guides[DYNAMIC, i] = math.exp(state[st.FRICTION] * angle)
            guides[STATIC, i] = guides[DYNAMIC, i]
            if not same:
                guides[STATIC, i] = math.exp(state[st.STATIC_FRICTION] * angle)
            guides[CONSTANT, i] = state[st.CONSTANT_FRICTION] / (n * state[st.AXIAL_STIFFNESS])
            guides[st.BOUND_ANGLE, i] = angle


@compiled
def _leave_trial(
    state: Any, segments: Any, guides: Any, wound_in: float, wound_out: float, time: float
) -> None:
    """Remember the evaluation, for `advance` to make it true."""
    ea = state[st.AXIAL_STIFFNESS]
    for i in range(guides.shape[1]):
        flow = guides[FLOW, i]
        left, right = segments[TENSION, i], segments[TENSION, i + 1]
        guides[st.TRIAL_FLOW, i] = flow
        guides[st.TRIAL_SLIP, i] = guides[SLIP, i] if flow != 0.0 else 0.0
        guides[st.TRIAL_WORK, i] = ea * released(left, right, flow)
    _copy(segments, TENSION, st.TRIAL_START)
    if state[st.AXIAL_DAMPING] > 0.0:
        _copy(segments, st.FRESH_STRAIN, st.TRIAL_STRAIN)
    state[st.TRIAL_WOUND_IN], state[st.TRIAL_WOUND_OUT] = wound_in, wound_out
    state[st.TRIAL_TIME] = time
    state[st.ON_TRIAL] = 1.0


@compiled
def _apply(layout: Any, m: int, d: int, state: Any, segments: Any, p: Any) -> None:
    """Tendon forces on the bodies along the path and on the spools."""
    ea, last = state[st.AXIAL_STIFFNESS], segments.shape[1] - 1
    first = integer(pointer(m + layout.m_tendon_adr), int(state[st.TENDON]))
    sites = pointer(m + layout.m_wrap_objid)
    bodies = pointer(m + layout.m_site_bodyid)
    # a segment pulls its two ends together; on one body that does nothing
    body = integer(bodies, integer(sites, first))
    for j in range(last + 1):
        other = integer(bodies, integer(sites, first + j + 1))
        if body != other and segments[TENSION, j] > 0.0:
            pull = ea * segments[TENSION, j] / segments[LENGTH, j]
            fx = pull * (p[3 * j + 3] - p[3 * j])
            fy = pull * (p[3 * j + 4] - p[3 * j + 1])
            fz = pull * (p[3 * j + 5] - p[3 * j + 2])
            add_force(layout, m, d, body, p, 3 * j, fx, fy, fz)
            add_force(layout, m, d, other, p, 3 * j + 3, -fx, -fy, -fz)
        body = other
    _turn_back(layout, m, d, state, st.REEL_JOINT, st.REEL_RADIUS, segments[TENSION, 0])
    _turn_back(layout, m, d, state, st.OUTPUT_JOINT, st.OUTPUT_RADIUS, segments[TENSION, last])


@compiled
def spool_torque(radius: float, ea: float, tau: float) -> float:
    """Torque on a spool: r (T + T²/2EA), the second term being the energy that goes onto the drum.

    With it the torque is exactly −∂U/∂θ of the elastic energy U, so no cycle gains any.
    """
    return radius * ea * tau * (1.0 + 0.5 * tau)


@compiled
def _turn_back(
    layout: Any, m: int, d: int, state: Any, joint: int, radius: int, tau: float
) -> None:
    """The tendon unwinds its spool."""
    if state[joint] >= 0.0:
        dof = integer(pointer(m + layout.m_jnt_dofadr), int(state[joint]))
        torque = spool_torque(state[radius], state[st.AXIAL_STIFFNESS], tau)
        doubles(pointer(d + layout.d_qfrc_passive) + 8 * dof, 1)[0] -= torque


@compiled
def _damp(state: Any, segments: Any, elapsed: float, timestep: float) -> float:
    """Fill in how axial damping shifts each strain; return how much it scales it (1: none).

    T = EA ε + c (ε − ε⁻)/Δt, hence ε = (τ + κ ε⁻)/(1 + κ) with κ = c/(EA Δt).
    """
    if not elapsed > 0.0:
        elapsed = timestep
    kappa = state[st.AXIAL_DAMPING] / (state[st.AXIAL_STIFFNESS] * elapsed)
    share = 1.0 / (1.0 + kappa)
    for j in range(segments.shape[1]):
        segments[OFFSET, j] = (1.0 - share) * segments[st.STRAIN, j]
    return share


@compiled
def _strain_after(segments: Any, guides: Any) -> None:
    """Strain of every segment once the flow of this evaluation has passed."""
    n = guides.shape[1]
    for j in range(n + 1):
        holds = segments[STORED, j]
        holds += guides[FLOW, j] if j < n else 0.0
        holds -= guides[FLOW, j - 1] if j > 0 else 0.0
        segments[st.FRESH_STRAIN, j] = segments[LENGTH, j] / holds - 1.0


@compiled
def evaluate(layout: Any, m: int, d: int, address: int) -> None:
    """Solve the tendon for the pose at hand, from the committed state, and apply its forces."""
    state, segments, guides, path = st.unpack(address)
    last = guides.shape[1]
    time = double(d + layout.d_time, 0)
    start = integer(pointer(d + layout.d_ten_wrapadr), int(state[st.TENDON]))
    points = coordinates(pointer(d + layout.d_wrap_xpos) + 24 * start)
    fresh = state[st.STARTED] == 0.0
    follow_path(points, coordinates(path), segments[LENGTH], guides[st.ANGLE], fresh)
    _bind_guides(state, guides)
    if fresh:
        _start(layout, m, d, state, segments)

    stage = is_stage(layout, m, time, state[st.ON_TRIAL], state[st.TRIAL_TIME])
    wound_in = _turned(layout, m, d, state, st.REEL_JOINT, st.REEL_RADIUS)
    wound_in += control(layout, m, d, int(state[st.REEL_ACTUATOR]))
    wound_out = _turned(layout, m, d, state, st.OUTPUT_JOINT, st.OUTPUT_RADIUS)
    damped = state[st.AXIAL_DAMPING] > 0.0
    share = 1.0
    if damped:
        timestep = double(m + layout.o_timestep, 0)
        share = _damp(state, segments, time - state[st.COMMIT_TIME], timestep)

    # wound tendon leaves the two end segments, for this evaluation only
    input_stored, output_stored = segments[STORED, 0], segments[STORED, last]
    segments[STORED, 0] -= wound_in - state[st.WOUND_IN]
    segments[STORED, last] -= wound_out - state[st.WOUND_OUT]
    _copy(segments, st.START, TENSION)  # so that no earlier look at the pose shows
    possible = math.isfinite(wound_in + wound_out)
    solved = possible and settle(segments, guides, share)
    if damped:
        _strain_after(segments, guides)
    segments[STORED, last] = output_stored
    segments[STORED, 0] = input_stored
    if not solved:
        state[st.UNSOLVED] += 1.0
    if not possible or not math.isfinite(segments[TENSION, last]):
        state[st.ON_TRIAL] = 0.0  # nothing that an earlier evaluation left may come true instead
        return
    _apply(layout, m, d, state, segments, points)
    if not stage:
        _leave_trial(state, segments, guides, wound_in, wound_out, time)


@compiled
def commit(address: int) -> None:
    """Make the step on trial the committed state."""
    state, segments, guides, _ = st.unpack(address)
    if state[st.ON_TRIAL] == 0.0:
        return
    last = guides.shape[1]
    segments[STORED, 0] -= state[st.TRIAL_WOUND_IN] - state[st.WOUND_IN]
    segments[STORED, last] -= state[st.TRIAL_WOUND_OUT] - state[st.WOUND_OUT]
    for i in range(last):
        flow = guides[st.TRIAL_FLOW, i]
        segments[STORED, i] += flow
        segments[STORED, i + 1] -= flow
        guides[WAS, i] = guides[st.TRIAL_SLIP, i]
        guides[st.WORK, i] += guides[st.TRIAL_WORK, i]
    _copy(segments, st.TRIAL_START, st.START)
    if state[st.AXIAL_DAMPING] > 0.0:
        _copy(segments, st.TRIAL_STRAIN, st.STRAIN)
    state[st.WOUND_IN], state[st.WOUND_OUT] = state[st.TRIAL_WOUND_IN], state[st.TRIAL_WOUND_OUT]
    state[st.COMMIT_TIME] = state[st.TRIAL_TIME]
    state[st.ON_TRIAL] = 0.0
