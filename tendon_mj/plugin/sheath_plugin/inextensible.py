"""Driven tendons without elasticity: dry friction of their guides, solved together for all tendons.

Guides between which the tendon cannot change its length hold or slide as one: a *group*. With T_0
the tension at the input, f_i what group i adds to it, and D_i = ∂L_i/∂q of the length L_i from the
group to the output end, the tendon's force is

    −T_0 D_0 − Σ f_i D_i,   T_i = T_{i−1} + f_i,   (T_{i−1} − c)/e^{λ} ≤ T_i ≤ T_{i−1} e^{λ} + c,

at the upper bound where tendon slides towards the output, s_i = D_i q̇ > 0, and at the lower one
if it slides back. MuJoCo applies T_0 D_0 itself. A group holds where its slip can be ended in
the step at hand:

    s_i/h + D_i M̂⁻¹ (F + r − Σ f_j D_j) = 0,   f_i at its bound if it slides,

with s_i that in the pose after the step, F all forces that are known, with those of `constraints`,
r what was not known in the last step, and M̂ as in `response`. The tensions T_i start from those of
the last step, so that a motor's change needs no slip.

**Pulleys.** Tensions count times the divisor of their branch, lengths over it. A branch that begins
where an earlier one ended takes over its tension.

**Constraints** of the tendon's own length: their force of the last step is part of T_0. Where a
limit or an equality holds the length of the tendon, its stretch is spread along it: D_i less the
share L_i/L_0 of D_0, and T_0 less that share of f_i.

**Dampers** that are integrated implicitly change T_0 within the step, by
h k D_0 M̂⁻¹ (F − Σ f_j D_j).

Equations: docs/theory.md, section 8.
"""

from __future__ import annotations

import math

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import RK4
from tendon_mj.plugin.abi.memory import address_of, coordinates, copy_doubles, doubles
from tendon_mj.plugin.sheath_plugin import group_solver, response
from tendon_mj.plugin.sheath_plugin.capstan_bounds import (
    set_bounds,
    tensions_behind,
    towards_input,
    towards_output,
)
from tendon_mj.plugin.sheath_plugin.constraints import (
    add_constraints,
    push_otherwise,
    take_constraints_out,
)
from tendon_mj.plugin.sheath_plugin.fixed_tendon import add_fixed_row, metres
from tendon_mj.plugin.sheath_plugin.forces import pull_segment
from tendon_mj.plugin.sheath_plugin.gear_losses import jams, set_gear
from tendon_mj.plugin.sheath_plugin.groups import (
    ACCELERATION,
    ALONG,
    BASE,
    CONSTRAINTS,
    FORCES,
    FRICTION,
    ROOM,
    Group,
    Member,
    gather,
    group_of,
    half_vector,
    has_friction,
    head_at,
    incoming_tension,
    input_row,
    is_span,
    member_of,
    owners_of,
    response_at,
    rows_at,
    vector_at,
)
from tendon_mj.plugin.sheath_plugin.input_force import actuator_damping, tendon_damping
from tendon_mj.plugin.sheath_plugin.servo_friction import has_servo, servo_bound
from tendon_mj.plugin.sheath_plugin.state import (
    State,
    known_forces_at,
    last_acceleration,
    state_at,
    state_of,
    unknown_forces,
    unpack,
)
from tendon_mj.sheath import Guides, Segments
from tendon_mj.typing import FloatArray

_SLIDES = 1.0 - 1e-6  # of a joint's `frictionloss`, of which less holds
_JOINT_LOSS = mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF.value
_DAMPER_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_LEAST_ARM = 1e-12  # [m]; a moment arm below is one of rounding
_UNEXPLAINED = 1e-9  # of a length: a change beyond what velocities say that is none of rounding


@apart
def _set_rows(m: Model, d: Data, work: int, k: int, state: State, segments: Segments) -> None:
    """Set the rows D of a sheath's groups, less their shares of D_0 if its stretch is spread."""
    nv = m.nv
    member, at_input, rows = member_of(work, nv, k), input_row(work, nv, k), rows_at(work)
    owners, first, last = owners_of(work, nv, member), int(member.first), int(member.last)
    doubles(rows + 8 * nv * first, nv * (last - first))[:] = 0.0
    for i in range(nv):
        at_input[i] = 0.0
    for j in range(len(segments)):
        if is_span(segments, j):
            owner = int(owners[j])
            row = coordinates(rows + 8 * nv * owner) if owner >= 0 else at_input
            pull_segment(m, d, state, segments[j], -1.0 / segments[j].divisor, row)
    if member.is_fixed != 0.0:
        add_fixed_row(m, state, coordinates(rows + 8 * nv * first))
    for g in range(last - 1, first - 1, -1):
        parent = int(group_of(work, g).parent)
        into = coordinates(rows + 8 * nv * parent) if parent >= 0 else at_input
        group_solver.add_to(into, coordinates(rows + 8 * nv * g), 1.0, nv)
    for g in range(first, last):
        row = coordinates(rows + 8 * nv * g)
        if member.spreads != 0.0:
            group_solver.add_to(row, at_input, -group_of(work, g).share, nv)
        for i in range(nv):
            if abs(row[i]) < _LEAST_ARM:
                row[i] = 0.0


@apart
def _set_ways(
    work: int, nv: int, member: Member, state: State, segments: Segments, guides: Guides
) -> None:
    """Set the length from each group to the output end, and how far tendon has passed it."""
    owners, first, last = owners_of(work, nv, member), int(member.first), int(member.last)
    whole = 0.0
    for g in range(first, last):
        group_of(work, g).share = 0.0
    for j in range(len(segments)):
        owner = int(owners[j])
        length = segments[j].length / segments[j].divisor
        if owner >= 0:
            group_of(work, owner).share += length
        whole += length
    for g in range(last - 1, first - 1, -1):
        group = group_of(work, g)
        if group.parent >= 0.0:
            group_of(work, int(group.parent)).share += group.share
    for g in range(first, last):
        group = group_of(work, g)
        way = group.share
        end = int(group.end) - 1
        group.passed = way - guides[end].way if state.finished != 0.0 else 0.0
        if member.is_stage == 0.0:
            for i in range(int(group.begin), end + 1):
                guides[i].trial_way = way
        group.share = way / whole


@compiled
def _slid(member: Member, group: Group, guides: Guides) -> float:
    """How a group slid in the step before, or, within a step of Runge-Kutta, at its beginning."""
    end = guides[int(group.end) - 1]
    return -(end.trial_slip if member.is_stage != 0.0 else end.previous_slip)


@apart
def set_up(m: Model, d: Data, work: int, instance: int, stage: bool, written: bool) -> None:
    """Set up the groups of a sheath in the pose at hand, and their friction as it was shown last.

    Where positions or velocities were ``written`` since the last step nothing slips meanwhile.
    """
    address = state_of(m, d, instance)
    state = state_at(address)
    segments, guides, _ = unpack(address)
    nv, head, h = m.nv, head_at(work), m.opt.timestep
    k, first = int(head.members), int(head.groups)
    member = member_of(work, nv, k)
    member.instance, member.first, member.is_stage = instance, first, stage
    member.owners, member.damping = head.segments, 0.0
    member.is_fixed = state.fixed
    member.spreads = state.spreads != 0.0 and state.constraint_force != 0.0
    gather(work, nv, k, guides, segments)
    last, rough = int(member.last), False
    head.members, head.groups, head.segments = k + 1, last, head.segments + len(segments)
    _set_ways(work, nv, member, state, segments, guides)
    for g in range(first, last):
        group = group_of(work, g)
        group.slides = _slid(member, group, guides)
        group.pretension = state.law.pretension if state.fixed != 0.0 else -1.0
        set_gear(group, state.gear_friction, state.gear_friction_back)
        group.servo = state.servo_bound if has_servo(state.servo) else -1.0
        group.wanted = group.mobility = group.eases = group.jams = 0.0
        if member.spreads == 0.0:
            group.share = 0.0
        set_bounds(group, guides)
        group.row = -1.0
        rough |= group.is_rough != 0.0
    if not rough:
        return
    _set_rows(m, d, work, k, state, segments)
    velocity = d.qvel
    for g in range(first, last):
        group = group_of(work, g)
        end = guides[int(group.end) - 1]
        speed = group_solver.dot(coordinates(rows_at(work) + 8 * nv * g), velocity, nv)
        curved = 0.0  # by which the slip changes in a step, as D does
        if state.finished != 0.0 and not written and state.slips_kept != 0.0:
            curved = speed - end.ended
        drawn = group.passed / h - (speed - 0.5 * curved)  # by bodies that move without a velocity
        on_arc = end.is_on_arc != 0.0 or guides[int(group.begin)].is_on_arc != 0.0
        is_known = member.spreads + state.fixed == 0.0 and not on_arc and not written
        if m.opt.integrator == RK4 or not is_known:
            drawn = 0.0
        if abs(h * drawn) <= _UNEXPLAINED * end.trial_way:
            drawn = 0.0
        if not is_known:
            group.passed = h * speed
        if group.slides == 0.0:  # one that slid is stopped together with others, whatever curves
            speed += curved
        group.wanted = (speed + drawn) / h
        if group.is_rough != 0.0:
            group.row = head.rough
            head.rough += 1.0


@compiled
def _start_group(member: Member, group: Group, guides: Guides) -> None:
    """Let a group slide or hold as in the step before, with the bounds of that."""
    group.friction, group.slides = 0.0, _slid(member, group, guides)
    if group.is_set_for != group.slides:  # in another solution for the same pose
        set_bounds(group, guides)


@apart
def _start(m: Model, d: Data, work: int, nv: int, k: int) -> None:
    """Read T_0 of a sheath, and the tensions that its groups held."""
    member = member_of(work, nv, k)
    state = state_at(state_of(m, d, int(member.instance)))
    segments, guides, _ = unpack(state_of(m, d, int(member.instance)))
    member.constant = state.input_force
    if not math.isfinite(state.input_force):
        member.constant = 0.0
    incoming = member.input = group_solver.pull_of(member, member.constant)
    before = state.input_force - state.constraint_force + state.previous_constraint
    follows = incoming - group_solver.pull_of(member, before) if member.spreads == 0.0 else 0.0
    for g in range(int(member.first), int(member.last)):
        group = group_of(work, g)
        _start_group(member, group, guides)
        group.before = group.before_in = incoming
        if state.finished != 0.0:
            group.before = segments[int(group.end)].previous_tension * group.divisor
            if group.mobility > 0.0:  # else nothing shows what it bears
                group.before += follows
            parent = int(group.parent)
            first = segments[0].previous_tension
            group.before_in = group_of(work, parent).before if parent >= 0 else first
            if member.spreads != 0.0:  # the constraint bears what the shares have changed by
                end = guides[int(group.end) - 1]
                grown = group.share * (end.trial_way - end.way) / end.trial_way
                member.constant -= grown * (group.before - group.before_in)
                state.input_force = member.constant


@apart
def _bound_servo(m: Model, d: Data, work: int, g: int, forces: FloatArray) -> None:
    """Set the largest friction of a servo; the ``forces`` but its motor's and dampers are load."""
    group = group_of(work, g)
    member = member_of(work, m.nv, int(group.member))
    state = state_at(state_of(m, d, int(member.instance)))
    row, radius = coordinates(rows_at(work) + 8 * m.nv * g), metres(state)
    velocity, damping = d.qvel, m.dof_damping
    damps = 0.0 if m.opt.disableflags & _DAMPER_OFF else 1.0
    along = square = speed = 0.0
    for i in range(m.nv):
        along += row[i] * (forces[i] + damps * damping[i] * velocity[i])
        square += row[i] * row[i]
        speed += row[i] * velocity[i]
    motor = -radius * member.input
    load = radius * along / square - motor
    group.servo = servo_bound(state.servo, motor, load, speed / radius) / abs(radius)
    state.servo_bound = group.servo


@apart
def _hold(work: int, nv: int, g: int) -> None:
    """Let a group hold the tension behind it, or its friction where its stretch is spread."""
    group = group_of(work, g)
    tension = incoming_tension(work, nv, group)
    held = group.before
    if member_of(work, nv, int(group.member)).spreads != 0.0:
        held = tension + group.before - group.before_in
    low, high = tensions_behind(group, tension)
    group.tension = min(max(held, low), high)
    group_solver.take_over(work, nv, group, group.tension - tension)


@apart
def _repeat(m: Model, d: Data, work: int, nv: int, g: int, moves: bool) -> None:
    """Let a group slide or hold as it was shown last, or, with ``moves``, slide as it moves.

    Within a step of Runge-Kutta its friction stays what it was, whatever comes in meanwhile: one
    that magnified that in each stage would make energy on a stiff drive.
    """
    group = group_of(work, g)
    member = member_of(work, nv, int(group.member))
    segments, _, _ = unpack(state_of(m, d, int(member.instance)))
    tension, parent = incoming_tension(work, nv, group), int(group.parent)
    held = group.divisor * segments[int(group.end)].trial_tension
    group.jams = jams(group, tension, held - tension, held - tension)
    low, high = tensions_behind(group, tension)
    slides = group.passed if moves else group.slides
    bound = high if slides > 0.0 else low
    if member.is_stage != 0.0:
        front = segments[int(group_of(work, parent).end) if parent >= 0 else 0]
        held += tension - front.divisor * front.trial_tension
    elif slides != 0.0 and math.isfinite(bound):  # a gear that locks itself does not slide there
        held = bound
    group.tension = min(max(held, low), high)
    group_solver.take_over(work, nv, group, group.tension - tension)


@apart
def repeat(m: Model, d: Data, work: int, moves: bool) -> None:
    """Set the friction of all groups as it was shown last, or, with ``moves``, as they move now."""
    nv, head = m.nv, head_at(work)
    for k in range(int(head.members)):
        _start(m, d, work, nv, k)
        member = member_of(work, nv, k)
        if member.is_stage != 0.0 and member.spreads != 0.0:  # the input bore shares of friction
            segments, _, _ = unpack(state_of(m, d, int(member.instance)))
            member.input = segments[0].trial_tension
    for g in range(int(head.groups)):
        _repeat(m, d, work, nv, g, moves)
    _add_friction(work, nv)


_STILL = 1e-12  # of its length, by which tendon that counts as still may pass a group in a step


@apart
def prepare(m: Model, d: Data, work: int) -> None:
    """Set up M̂ with the dampers that are integrated implicitly, and the constraints that bear."""
    last = address_of(last_acceleration(m, d, int(head_at(work).leader)))
    copy_doubles(vector_at(work, m.nv, ACCELERATION), last, m.nv)
    _set_response(m, d, work)


@apart
def _set_response(m: Model, d: Data, work: int) -> None:
    """Set up M̂ with the constraints that push at the vector ACCELERATION."""
    nv, head = m.nv, head_at(work)
    place = response_at(work, nv)
    response.begin_response(m, d, place)
    if response.is_implicit(m):
        response.add_actuator_dampers(m, d, place, coordinates(vector_at(work, nv, ROOM)))
        _add_tendon_dampers(m, d, work)
    acceleration = coordinates(vector_at(work, nv, ACCELERATION))
    room = coordinates(vector_at(work, nv, ROOM))
    forces = coordinates(vector_at(work, nv, CONSTRAINTS))
    head.pushing = add_constraints(m, d, place, acceleration, room, forces)
    response.factor_response(m, place)


@apart
def _add_tendon_dampers(m: Model, d: Data, work: int) -> None:
    """Add the dampers of the tendons to M̂, and set what they and actuators damp each with."""
    nv, head = m.nv, head_at(work)
    place = response_at(work, nv)
    for k in range(int(head.members)):
        member = member_of(work, nv, k)
        state = state_at(state_of(m, d, int(member.instance)))
        own = tendon_damping(m, state)
        member.damping = own + actuator_damping(m, d, state)
        if own > 0.0 and has_friction(work, member):
            response.add_damper(m, place, input_row(work, nv, k), own)


@compiled
def _write_guides(work: int, nv: int, group: Group, segments: Segments, guides: Guides) -> None:
    """Write the tensions, flows and friction work of a group's guides, on trial.

    If friction holds, the tension along the group is that share of what it would be at the bound
    which its end has.
    """
    incoming, up = incoming_tension(work, nv, group), group.friction > 0.0
    bound = tensions_behind(group, incoming)[1 if up else 0]
    part = group.friction / (bound - incoming) if bound != incoming else 0.0
    begin, end = int(group.begin), int(group.end)
    passed, slides = group.passed, group.slides
    if group.row < 0.0:
        slides = 1.0 if passed > 0.0 else -1.0
    still = abs(passed) <= _STILL * guides[end - 1].trial_way
    flow = 0.0 if still or slides * passed <= 0.0 else -passed
    extreme = tension = incoming
    for i in range(begin, end):
        guide, before = guides[i], tension
        if up:
            ratio, offset = towards_output(guide, group.divisor, group.is_set_for > 0.0)
            extreme = ratio * extreme + offset
        else:
            ratio, offset = towards_input(guide, group.divisor, group.is_set_for < 0.0)
            extreme = max(0.0, (extreme - offset) / ratio)
        tension = group.tension if i == end - 1 else incoming + part * (extreme - incoming)
        segments[i + 1].trial_tension = tension / group.divisor
        guide.flow = guide.trial_flow = flow
        guide.slip = guide.trial_slip = -slides if flow != 0.0 else 0.0
        guide.trial_friction_work = abs((tension - before) * flow)


@apart
def _write(m: Model, d: Data, work: int, nv: int, k: int, time: float) -> None:
    """Write the result of a sheath, and keep it on trial."""
    member = member_of(work, nv, k)
    address = state_of(m, d, int(member.instance))
    state = state_at(address)
    segments, guides, _ = unpack(address)
    owners = owners_of(work, nv, member)
    for j in range(len(segments)):
        owner = int(owners[j])
        tension = group_of(work, owner).tension if owner >= 0 else member.input
        segments[j].trial_tension = tension / segments[j].divisor
    for g in range(int(member.first), int(member.last)):
        _write_guides(work, nv, group_of(work, g), segments, guides)
    changes = group_solver.pull_of(member, state.input_force) - member.input
    for j in range(len(segments)):
        changed = changes if member.damping != 0.0 else 0.0
        segment = segments[j]
        segment.tension = segment.trial_tension + changed / segment.divisor
        if member.is_fixed == 0.0:
            segment.tension = max(0.0, segment.tension)
    state.trial_time, state.trial_elapsed = time, m.opt.timestep
    state.has_trial = 1.0 if math.isfinite(state.input_force) else 0.0


@apart
def _add_friction(work: int, nv: int) -> None:
    """Add the friction of all groups to the vector FRICTION."""
    friction = coordinates(vector_at(work, nv, FRICTION))
    for g in range(int(head_at(work).groups)):
        group = group_of(work, g)
        if group.friction != 0.0:
            row = coordinates(rows_at(work) + 8 * nv * g)
            group_solver.add_to(friction, row, -group.friction, nv)


@apart
def _add_up(m: Model, d: Data, work: int, nv: int) -> FloatArray:
    """Add up the forces that are known before friction."""
    place = known_forces_at(m, d, int(head_at(work).leader))
    known = coordinates(place)
    base = coordinates(vector_at(work, nv, BASE))
    for i in range(nv):
        known[i] = base[i]
    response.add_smooth_forces(m, d, place)
    return known


@apart
def _settle(m: Model, d: Data, work: int, known: FloatArray, friction: FloatArray) -> None:
    """Let every group hold or slide, from the tensions of the last step on."""
    nv, head, place = m.nv, head_at(work), response_at(work, m.nv)
    forces, room = half_vector(work, nv, FORCES), coordinates(vector_at(work, nv, ROOM))
    unknown = unknown_forces(m, d, int(head.leader))
    constraints = coordinates(vector_at(work, nv, CONSTRAINTS))
    for i in range(nv):
        room[i] = known[i] + friction[i] + unknown[i] + constraints[i]
    response.go_half_way(m, place, room, forces)
    weights = response.weights_at(place, nv)
    for i in range(nv):
        forces[i] *= weights[i]
    for g in range(int(head.groups)):
        group = group_of(work, g)
        if group.servo >= 0.0:
            _bound_servo(m, d, work, g, room)
        if group.back < 0.0:
            group_solver.set_jam(work, nv, group, forces)
        _hold(work, nv, g)
        if group.friction != 0.0:
            group_solver.add_half(work, nv, group, forces, -group.friction)
    for _ in range(1 + 2 * int(head.rough)):
        group_solver.settle(work, nv, m.opt.timestep)
        if not group_solver.release(m, d, work, nv):
            break


@apart
def _push_otherwise(m: Model, d: Data, work: int) -> bool:
    """Set the vector ACCELERATION to what came out; return whether other constraints push there."""
    nv = m.nv
    before, room = vector_at(work, nv, ACCELERATION), coordinates(vector_at(work, nv, ROOM))
    acceleration = half_vector(work, nv, ALONG)
    copy_doubles(address_of(acceleration), address_of(half_vector(work, nv, FORCES)), nv)
    response.go_on(m, response_at(work, nv), acceleration)
    otherwise = push_otherwise(m, d, coordinates(before), acceleration, room)
    copy_doubles(before, address_of(acceleration), nv)
    return otherwise


@apart
def solve(m: Model, d: Data, work: int) -> None:
    """Solve the friction of all groups under the forces at hand, and add it to FRICTION."""
    nv, head, h = m.nv, head_at(work), m.opt.timestep
    stage = False
    for k in range(int(head.members)):
        member = member_of(work, nv, k)
        stage |= member.is_stage != 0.0
        state_at(state_of(m, d, int(member.instance))).applied = 1.0
    friction, known = coordinates(vector_at(work, nv, FRICTION)), _add_up(m, d, work, nv)
    if stage:
        repeat(m, d, work, False)
        group_solver.add_to(known, friction, 1.0, nv)
        return
    if head.rough > 0.0:
        group_solver.set_half_rows(m, work, nv, h)
    for k in range(int(head.members)):
        _start(m, d, work, nv, k)
    if head.rough > 0.0:
        _settle(m, d, work, known, friction)
        if head.pushing != 0.0 and _push_otherwise(m, d, work):
            _set_response(m, d, work)
            group_solver.set_half_rows(m, work, nv, h)
            for k in range(int(head.members)):
                member = member_of(work, nv, k)
                _, guides, _ = unpack(state_of(m, d, int(member.instance)))
                for g in range(int(member.first), int(member.last)):
                    group_solver.take_over(work, nv, group_of(work, g), 0.0)
                    _start_group(member, group_of(work, g), guides)
                member.input = group_solver.pull_of(member, member.constant)
            _settle(m, d, work, known, friction)
    for k in range(int(head.members)):
        group_solver.update_input(work, nv, k, h)
    for g in range(int(head.groups)):
        group = group_of(work, g)
        incoming = incoming_tension(work, nv, group)
        tension = incoming + group.friction
        if group.pretension < 0.0:
            tension = max(0.0, tension)
        if group.row >= 0.0 and group.share == 0.0:  # what the rounds left is no more than it holds
            low, high = tensions_behind(group, incoming)
            tension = min(max(tension, low), high)
        group.tension = tension
        group.friction = tension - incoming
    _add_friction(work, nv)
    group_solver.add_to(known, friction, 1.0, nv)
    time = d.time
    for k in range(int(head.members)):
        _write(m, d, work, nv, k, time)


@apart
def keep_slips(m: Model, d: Data, work: int) -> None:
    """Keep how all groups slip at the end of the step, as in the pose at its beginning."""
    nv, velocity = m.nv, d.qvel
    for k in range(int(head_at(work).members)):
        member = member_of(work, nv, k)
        address = state_of(m, d, int(member.instance))
        if not has_friction(work, member):  # nor are there rows
            continue
        state_at(address).slips_kept = 1.0
        _, guides, _ = unpack(address)
        for g in range(int(member.first), int(member.last)):
            group = group_of(work, g)
            ended = group_solver.dot(coordinates(rows_at(work) + 8 * nv * g), velocity, nv)
            for i in range(int(group.begin), int(group.end)):
                guides[i].ended = ended


@apart
def keep_unknown_forces(m: Model, d: Data, first: int) -> None:
    """Keep the forces of the step that ends which friction did not know.

    Dry friction of a joint is among them while the joint slides on in one sense: at rest it answers
    what is left, and where the joint turns it changes its sign.
    """
    unknown, known = unknown_forces(m, d, first), coordinates(known_forces_at(m, d, first))
    smooth, constraint = d.qfrc_smooth, d.qfrc_constraint
    for i in range(m.nv):
        unknown[i] = smooth[i] + constraint[i] - known[i]
    for row in range(d.ne, d.ne + d.nf):
        if d.efc_type[row] == _JOINT_LOSS:
            dof, force = d.efc_id[row], d.efc_force[row]
            slides = abs(force) > _SLIDES * m.dof_frictionloss[dof] and force * d.qvel[dof] < 0.0
            unknown[dof] -= 0.0 if slides else force
    take_constraints_out(m, d, unknown)
    acceleration, last = d.qacc, last_acceleration(m, d, first)
    for i in range(m.nv):
        last[i] = acceleration[i] if math.isfinite(acceleration[i]) else 0.0
        unknown[i] = unknown[i] if math.isfinite(unknown[i]) else 0.0


@compiled
def commit_inextensible(segments: Segments, guides: Guides) -> None:
    """Make the step on trial the committed state."""
    for i in range(len(guides)):
        guide = guides[i]
        guide.way = guide.trial_way
        guide.passed += guide.trial_flow
        guide.previous_slip = guide.trial_slip
        guide.friction_work += guide.trial_friction_work
    for j in range(len(segments)):
        segments[j].previous_tension = segments[j].trial_tension
