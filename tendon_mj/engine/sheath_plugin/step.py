"""A sheath's part in a time step: evaluate the tendon, apply its forces, commit what happened.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.compilation import apart, compiled
from tendon_mj.engine.abi.memory import coordinates, double, doubles, integer, pointer
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.engine.sheath_plugin.moment import control, is_stage
from tendon_mj.engine.sheath_plugin.momentum import fill_drag, leave_heat, remember_speed
from tendon_mj.engine.sheath_plugin.path import follow_path
from tendon_mj.engine.sheath_plugin.ratios import bind_ratios
from tendon_mj.engine.sheath_plugin.spool import flank_stiffness, on_drum, torque_on_drive, turned
from tendon_mj.engine.sheath_plugin.strain import (
    be_hookean,
    carry_strain,
    fill_strain,
    leave_strain,
    move_tangents,
    rest_strain,
    spool_torque,
    strain_after,
)
from tendon_mj.engine.sheath_plugin.wrench import add_force
from tendon_mj.sheath.flow import settle
from tendon_mj.sheath.segments import released
from tendon_mj.sheath.tables import (
    FLOW,
    GIVE,
    LENGTH,
    SLIP,
    STORED,
    TENSION,
    WAS,
)

_TANGENTS = 8  # to a strain law that is no line; about 2 are needed


@compiled
def _copy(segments: Any, row: int, into: int) -> None:
    """Copy a row; assigning slices compiles to several times as much."""
    for j in range(segments.shape[1]):
        segments[into, j] = segments[row, j]


@apart
def _start(layout: Any, m: int, d: int, state: Any, segments: Any) -> None:
    """Lay the tendon evenly along its first path.

    Its unstretched length is fixed by the pretension in the reference pose `qpos0`, as MuJoCo fixes
    a spring length: S = L(qpos0)/(1 + ε_0), and the tendon has crept as much as it will under it.
    """
    reference = double(pointer(m + layout.m_tendon_length0), int(state[st.TENDON]))
    strain, crept = rest_strain(state)
    unstretched = reference / (1.0 + strain + crept)
    state[st.WOUND_IN] = turned(layout, m, d, state, st.REEL_JOINT, st.REEL_RADIUS)
    state[st.WOUND_OUT] = turned(layout, m, d, state, st.OUTPUT_JOINT, st.OUTPUT_RADIUS)
    unstretched -= state[st.WOUND_IN] + state[st.WOUND_OUT]
    total = sum(segments[LENGTH])
    for j in range(segments.shape[1]):
        segments[STORED, j] = segments[LENGTH, j] * unstretched / total
        strain = total / unstretched - 1.0 - crept
        segments[st.STRAIN, j], segments[st.CREPT, j] = strain, crept
        segments[st.START, j] = strain * (1.0 + state[st.STIFFENING] * max(0.0, strain))
    be_hookean(segments)
    state[st.STRAINED] = 1.0  # so that the strains just written count
    state[st.LAID] = state[st.PRETENSION]
    state[st.COMMIT_TIME] = double(d + layout.d_time, 0) - double(m + layout.o_timestep, 0)
    state[st.STARTED] = 1.0


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
    if state[st.TENDON_MASS] > 0.0 or state[st.STIFFENING] > 0.0:
        leave_heat(state, segments, guides)
    _copy(segments, TENSION, st.TRIAL_START)
    if state[st.STRAINED] != 0.0:
        leave_strain(state, segments)
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
    _turn_back(layout, m, d, state, st.REEL_JOINT, state[st.REEL_TORQUE])
    torque = spool_torque(state, segments, last, state[st.OUTPUT_RADIUS])
    _turn_back(layout, m, d, state, st.OUTPUT_JOINT, torque)


@compiled
def _turn_back(layout: Any, m: int, d: int, state: Any, joint: int, torque: float) -> None:
    """The tendon unwinds its spool."""
    if state[joint] >= 0.0:
        dof = integer(pointer(m + layout.m_jnt_dofadr), int(state[joint]))
        doubles(pointer(d + layout.d_qfrc_passive) + 8 * dof, 1)[0] -= torque


@compiled
def _solve(state: Any, segments: Any, guides: Any, elapsed: float) -> bool:
    """Let the tendon flow, by a strain law that fits the tensions that come out."""
    dragged = fill_drag(state, guides, elapsed)
    tangents = _TANGENTS if state[st.STIFFENING] > 0.0 else 0
    solved = False
    for tried in range(tangents + 1):
        solved = settle(segments, guides, dragged)
        if not (solved and tried < tangents and move_tangents(state, segments, elapsed)):
            break
    return solved


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
    bind_ratios(state, guides, time)
    if fresh:
        _start(layout, m, d, state, segments)

    stage = is_stage(layout, m, time, state[st.ON_TRIAL], state[st.TRIAL_TIME])
    elapsed = time - state[st.COMMIT_TIME]
    if not elapsed > 0.0:
        elapsed = double(m + layout.o_timestep, 0)
    drive = turned(layout, m, d, state, st.REEL_JOINT, st.REEL_RADIUS)
    drive += control(layout, m, d, int(state[st.REEL_ACTUATOR]))
    flank = flank_stiffness(layout, m, state, elapsed)
    wound_in = on_drum(state, segments, drive, flank)
    wound_out = turned(layout, m, d, state, st.OUTPUT_JOINT, st.OUTPUT_RADIUS)
    strained = fill_strain(state, segments, elapsed)

    # for this evaluation only: wound tendon leaves the two end segments, the sheath's mount yields
    input_stored, output_stored = segments[STORED, 0], segments[STORED, last]
    segments[STORED, 0] -= wound_in - state[st.WOUND_IN]
    segments[STORED, last] -= wound_out - state[st.WOUND_OUT]
    input_length = segments[LENGTH, 0]
    segments[LENGTH, 0] = input_length + state[st.SHEATH_COMPLIANCE] * state[st.LAID]
    segments[GIVE, 0] = state[st.SHEATH_COMPLIANCE] * state[st.AXIAL_STIFFNESS]
    _copy(segments, st.START, TENSION)  # so that no earlier look at the pose shows
    possible = math.isfinite(drive + wound_out)
    solved = possible and _solve(state, segments, guides, elapsed)
    if strained:
        strain_after(state, segments, guides, elapsed)
    segments[LENGTH, 0] = input_length
    segments[STORED, last] = output_stored
    segments[STORED, 0] = input_stored
    if not solved:
        state[st.UNSOLVED] += 1.0
    state[st.REEL_TORQUE] = torque_on_drive(state, segments, drive - wound_in, flank)
    if not possible or not math.isfinite(segments[TENSION, last]):
        state[st.ON_TRIAL] = 0.0  # nothing that an earlier evaluation left may come true instead
        return
    _apply(layout, m, d, state, segments, points)
    if not stage:
        state[st.TRIAL_ELAPSED] = elapsed
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
    if state[st.STRAINED] != 0.0:
        carry_strain(segments, guides)
    for i in range(last):
        flow = guides[st.TRIAL_FLOW, i]
        segments[STORED, i] += flow
        segments[STORED, i + 1] -= flow
        guides[st.PASSED, i] += flow
        guides[WAS, i] = guides[st.TRIAL_SLIP, i]
        guides[st.WORK, i] += guides[st.TRIAL_WORK, i]
    _copy(segments, st.TRIAL_START, st.START)
    remember_speed(state, guides)
    state[st.WOUND_IN], state[st.WOUND_OUT] = state[st.TRIAL_WOUND_IN], state[st.TRIAL_WOUND_OUT]
    state[st.COMMIT_TIME] = state[st.TRIAL_TIME]
    state[st.ON_TRIAL] = 0.0
