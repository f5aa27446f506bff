"""Driven tendons without elasticity: dry friction of their guides, solved together for all tendons.

Guides between which the tendon cannot change its length hold or slide as one: a *group*. With T_0
the tension at the input, f_i what group i adds to it, and D_i = ∂L_i/∂q of the length L_i from the
group to the output end, the tendon's force is

    −T_0 D_0 − Σ f_i D_i,   T_i = T_{i−1} + f_i,   (T_{i−1} − c)/e^{λ} ≤ T_i ≤ T_{i−1} e^{λ} + c,

at the upper bound where tendon slides towards the output, s_i = D_i q̇ > 0, and at the lower one
where it slides back. MuJoCo applies T_0 D_0 itself. A group holds where its slip can be ended in
the step at hand:

    s_i/h + D_i M̂⁻¹ (F + r − Σ f_j D_j) = 0,   f_i at its bound where it slides,

with s_i that in the pose after the step, F all forces but those of constraints, r those of
constraints in the last step, and M̂ as in `response`. The tensions T_i start from those of the last
step, so that a motor's change needs no slip.

**Pulleys.** Tensions count times the divisor of their branch, lengths over it. A branch that begins
where an earlier one ended takes over its tension.

**Constraints** are solved after friction; their force of the last step is part of T_0. Where a
limit or an equality holds the length of the tendon, its stretch is spread along it: D_i less the
share L_i/L_0 of D_0, and T_0 less that share of f_i.

**Dampers** that are integrated implicitly change T_0 within the step, by
h k D_0 M̂⁻¹ (F − Σ f_j D_j).

Equations: docs/theory.md, section 8.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco

from tendon_mj.native import Record, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import RK4, free, malloc
from tendon_mj.plugin.abi.memory import coordinates, doubles, word, words
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.fixed_tendon import add_fixed_row
from tendon_mj.plugin.sheath_plugin.forces import pull_segment
from tendon_mj.plugin.sheath_plugin.input_force import actuator_damping, tendon_damping
from tendon_mj.plugin.sheath_plugin.response import (
    add_actuator_dampers,
    add_damper,
    add_smooth_forces,
    go_half_way,
    is_implicit,
    most_dampers,
    prepare_response,
    response_size,
    response_width,
    set_weights,
)
from tendon_mj.plugin.sheath_plugin.state import (
    SHEATH,
    WORKSPACE,
    State,
    binding_at,
    binding_of,
    known_forces_at,
    state_at,
    state_of,
    unknown_forces,
    unpack,
)
from tendon_mj.sheath import Guide, Guides, Segments, record_type
from tendon_mj.typing import FloatArray, IntArray


class Group:
    """Guides that hold or slide as one; tensions times the divisor of their branch."""

    member: float  # the sheath
    begin: float  # first guide
    end: float  # the one after the last guide
    parent: float  # group whose tension comes in, −1: the input's
    divisor: float
    upper_ratio: float  # T_i ≤ upper_ratio T_{i−1} + upper_offset
    upper_offset: float  # [N]
    lower_ratio: float  # T_i ≥ (T_{i−1} − lower_offset) / lower_ratio
    lower_offset: float  # [N]
    fall: float  # f ≥ fall T_{i−1} − fall_offset
    fall_offset: float  # [N]
    pretension: float  # P of two cables that pull against each other [N]; −1: of one that pulls
    least: float  # friction of that pretension [N]
    is_rough: float  # whether there is any friction
    is_static: float  # whether friction at rest is more than that of sliding
    is_set_for: float  # ``slides`` for which these bounds are
    slides: float  # +1 at the upper bound, −1 at the lower one, 0 where it holds
    share: float  # L_i/L_0 where the stretch of the tendon is spread along it, else 0
    passed: float  # Δl, since the last step towards the output [m]
    wanted: float  # what the slip has to be slowed by in this step [m/s²]
    mobility: float  # A_ii [1/kg]
    eases: float  # how much less T_0 is for each newton of friction
    row: float  # of D half way, −1 where there is no friction
    count: float  # how many numbers of that are not 0
    before: float  # T_i of the last step [N]
    before_in: float  # the same in front of the group [N]
    friction: float  # f [N]
    missing: float  # what its slip has still to be slowed by [m/s²]
    along: float  # change of friction along the conjugate gradient [N]
    free: float  # which group is the k-th that shares a load, for group k
    answer: float  # D M̂⁻¹ Dᵀ of that [m/s²]
    tension: float  # T_i [N]


GROUP = record_type(Group)
_GROUP_COUNT = GROUP.itemsize // 8
_group_at: Callable[[int], Group] = Record(GROUP)


class Member:
    """A sheath whose tendon is inextensible."""

    instance: float
    first: float  # group
    last: float  # the one after its last
    owners: float  # index of its first segment among those of all
    is_stage: float  # whether this is an inner stage of Runge-Kutta
    input: float  # T_0 [N]
    constant: float  # what it would be without friction and acceleration
    damping: float  # k of its implicit damping [N s/m]
    spreads: float  # whether its stretch is spread along it
    is_fixed: float  # whether its cable is not drawn, and T_0 may have either sign


MEMBER = record_type(Member)
_MEMBER_COUNT = MEMBER.itemsize // 8
_member_at: Callable[[int], Member] = Record(MEMBER)


class Head:
    """What is known of all groups, in front of them."""

    room: float  # groups that there is memory for
    width: float  # of a row half way
    spots: float  # segments that there is memory for
    sheaths: float  # that there is memory for
    leader: float  # first sheath of the model, which keeps forces for all
    driven: float  # how many driven sheaths there are
    elastic: float  # of them with a stated elasticity
    members: float  # of them without
    groups: float  # how many groups
    segments: float  # of these sheaths
    rough: float  # how many of them have friction
    free: float  # how many of these hold with less friction than they can have
    signature: float  # of the velocities for which they were set up, 0: none
    is_nested: float  # whether actuators are being computed once more
    gives: float  # whether passive forces are being computed once more, with the friction known


HEAD = record_type(Head)
_HEAD_COUNT = HEAD.itemsize // 8
head_at: Callable[[int], Head] = Record(HEAD)


@compiled
def _size_of(room: int, spots: int, sheaths: int, nv: int, width: int) -> int:
    """Numbers of a workspace: groups, their rows, sheaths, owners of segments, vectors."""
    groups = room * (_GROUP_COUNT + nv + 2 * width)
    vectors = spots + 3 * (nv + width)
    return _HEAD_COUNT + groups + sheaths * (_MEMBER_COUNT + 1 + nv + width) + vectors


@compiled
def _group(work: int, g: int) -> Group:
    return _group_at(work + 8 * (_HEAD_COUNT + _GROUP_COUNT * g))


@compiled
def _rows_at(work: int) -> int:
    """Address of the rows of D."""
    return work + 8 * (_HEAD_COUNT + _GROUP_COUNT * int(head_at(work).room))


@compiled
def _half(work: int, nv: int, group: Group) -> FloatArray:
    """Row of D half way: the numbers that are not 0."""
    head = head_at(work)
    rows = _rows_at(work) + 8 * nv * int(head.room)
    return coordinates(rows + 16 * int(head.width) * int(group.row))


@compiled
def _places(work: int, nv: int, group: Group) -> IntArray:
    """Where these numbers are."""
    head = head_at(work)
    rows = _rows_at(work) + 8 * nv * int(head.room)
    return words(rows + 16 * int(head.width) * int(group.row) + 8 * int(head.width))


@compiled
def _members_at(work: int, nv: int) -> int:
    head = head_at(work)
    return _rows_at(work) + 8 * int(head.room) * (nv + 2 * int(head.width))


@compiled
def driven_sheaths(work: int, nv: int) -> FloatArray:
    """Instances of all driven sheaths."""
    return coordinates(_members_at(work, nv) + 8 * _MEMBER_COUNT * int(head_at(work).sheaths))


@compiled
def _member(work: int, nv: int, k: int) -> Member:
    return _member_at(_members_at(work, nv) + 8 * _MEMBER_COUNT * k)


@compiled
def _owners_at(work: int, nv: int) -> int:
    return _members_at(work, nv) + 8 * (_MEMBER_COUNT + 1) * int(head_at(work).sheaths)


@compiled
def _owners(work: int, nv: int, member: Member) -> FloatArray:
    """Group whose tension a segment of a sheath has, −1: the input's."""
    return coordinates(_owners_at(work, nv) + 8 * int(member.owners))


@compiled
def vector_at(work: int, nv: int, which: int) -> int:
    """Address of a vector: passive forces before friction, friction, room for one."""
    return _owners_at(work, nv) + 8 * (int(head_at(work).spots) + which * nv)


BASE, FRICTION, _ROOM = range(3)


@compiled
def _half_vector(work: int, nv: int, which: int) -> FloatArray:
    """A vector half way: all forces and their changes along the conjugate gradient, both times
    the weights, and the weights.
    """
    return coordinates(vector_at(work, nv, _ROOM + 1) + 8 * int(head_at(work).width) * which)


_FORCES, _ALONG, _WEIGHTS = range(3)


@compiled
def _input_at(work: int, nv: int, k: int) -> int:
    head = head_at(work)
    inputs = vector_at(work, nv, _ROOM + 1) + 24 * int(head.width)
    return inputs + 8 * (nv + int(head.width)) * k


@compiled
def _input_row(work: int, nv: int, k: int) -> FloatArray:
    """D_0 of a sheath."""
    return coordinates(_input_at(work, nv, k))


@compiled
def _input_half(work: int, nv: int, k: int) -> FloatArray:
    """D_0 of a sheath, half way."""
    return coordinates(_input_at(work, nv, k) + 8 * nv)


@compiled
def response_at(work: int, nv: int) -> int:
    """Address of the response M̂⁻¹."""
    return _input_at(work, nv, int(head_at(work).sheaths))


@compiled
def is_wide_enough(m: Model, work: int) -> bool:
    """Whether there is memory for all dampers, of which another integrator has more."""
    head = head_at(work)
    return head.width >= m.nv + most_dampers(m, int(head.sheaths))


@apart
def workspace(m: Model, d: Data, first: int, last: int) -> int:
    """Memory for the groups of all sheaths, kept in the binding of the last one."""
    room, sheaths, nv = 0, 0, m.nv
    for instance in range(first, last + 1):
        if is_sheath(m, instance, first) and binding_of(d, instance, SHEATH) != 0:
            guides = int(binding_at(binding_of(d, instance, SHEATH)).guides)
            room, sheaths = room + guides, sheaths + 1
    place = binding_of(d, last, SHEATH) + WORKSPACE
    work = word(place)
    spots = room + sheaths
    width = nv + most_dampers(m, sheaths)
    head = head_at(work)
    if work != 0 and (head.room < room or head.sheaths < sheaths or not is_wide_enough(m, work)):
        free(work)
        work = 0
    if work == 0:
        count = _size_of(room, spots, sheaths, nv, width) + response_size(m, sheaths)
        work = malloc(8 * count)
        doubles(work, count)[:] = 0.0
        head = head_at(work)
        head.room, head.spots, head.sheaths, head.width = room, spots, sheaths, width
        words(place)[0] = work
    return work


@compiled
def _is_span(segments: Segments, j: int) -> bool:
    """Whether the length of a segment can change."""
    return segments[j].point >= 0.0 and segments[j].near_body != segments[j].far_body


@apart
def _gather(work: int, nv: int, k: int, guides: Guides, segments: Segments) -> None:
    """Gather the guides of a sheath into groups, in the order of its path."""
    member = _member(work, nv, k)
    owners, g = _owners(work, nv, member), int(member.first)
    owners[0] = owner = -1.0
    begins = True
    for i in range(len(guides)):
        owners[i + 1] = owner
        if guides[i].is_pulley != 0.0:
            fed_by = int(guides[i].fed_by)
            owners[i + 1] = owner = owners[fed_by] if 0 <= fed_by <= i else -1.0
            begins = True
            continue
        if begins or _is_span(segments, i):
            group = _group(work, g)
            group.member, group.begin = k, i
            group.parent, group.divisor = owner, segments[i].divisor
            owner, g = g, g + 1
        _group(work, g - 1).end = i + 1
        owners[i + 1] = owner
        begins = False
    member.last = g


@compiled
def _towards_output(guide: Guide, unit: float, slides: bool) -> tuple[float, float]:
    """Ratio and offset of the largest tension behind a guide."""
    ratio = guide.dynamic_ratio_back if slides else guide.static_ratio_back
    return ratio, unit * guide.constant_friction


@compiled
def _towards_input(guide: Guide, unit: float, slides: bool) -> tuple[float, float]:
    """Ratio and offset of the largest tension in front of a guide."""
    return guide.dynamic_ratio if slides else guide.static_ratio, unit * guide.constant_friction


@compiled
def _set_bounds(group: Group, guides: Guides) -> None:
    """Combine the bounds of a group's guides; at rest, those of static friction."""
    upper, more, lower, less = 1.0, 0.0, 1.0, 0.0
    static = False
    for i in range(int(group.begin), int(group.end)):
        guide = guides[i]
        ratio, offset = _towards_output(guide, group.divisor, group.slides > 0.0)
        upper, more = upper * ratio, more * ratio + offset
        ratio, offset = _towards_input(guide, group.divisor, group.slides < 0.0)
        lower, less = lower * ratio, less + offset * lower
        static |= guide.static_ratio != guide.dynamic_ratio
    group.upper_ratio, group.upper_offset = upper, more
    group.lower_ratio, group.lower_offset = lower, less
    group.fall, group.fall_offset = 1.0 / lower - 1.0, less / lower
    group.is_static, group.is_set_for = static, group.slides
    group.is_rough = upper > 1.0 or more > 0.0 or lower > 1.0
    if group.pretension >= 0.0:
        group.least = more + group.pretension * _exponents(group, guides)


@apart
def _exponents(group: Group, guides: Guides) -> float:
    """Sum of the exponents of two cables, one of which slides either way, the other back."""
    total, slides = 0.0, group.slides != 0.0
    for i in range(int(group.begin), int(group.end)):
        ratio, _ = _towards_output(guides[i], 1.0, slides)
        back, _ = _towards_input(guides[i], 1.0, slides)
        total += math.log(ratio) + math.log(back)
    return total


@compiled
def _pull(member: Member, force: float) -> float:
    """T_0 under MuJoCo's force along a tendon."""
    return -force if member.is_fixed != 0.0 else max(0.0, -force)


@compiled
def _of_cables(group: Group, tension: float, eases: float) -> tuple[float, float]:
    """Least and largest friction of cables that pull one way or the other."""
    up = max(1e-3, 1.0 + eases * (group.upper_ratio - 1.0))
    down = max(1e-3, 1.0 + eases * group.fall)
    one, other = (group.upper_ratio - 1.0) * tension, group.fall * tension
    more, less = group.upper_offset, group.fall_offset
    low = min(-group.least, (one - more) / up, (other - less) / down)
    return low, max(group.least, (one + more) / up, (other + less) / down)


@compiled
def _upper(group: Group, tension: float) -> float:
    if group.pretension >= 0.0:
        return tension + _of_cables(group, tension, 0.0)[1]
    return group.upper_ratio * tension + group.upper_offset


@compiled
def _lower(group: Group, tension: float) -> float:
    if group.pretension >= 0.0:
        return tension + _of_cables(group, tension, 0.0)[0]
    return max(0.0, (tension - group.lower_offset) / group.lower_ratio)


@compiled
def _dot(a: FloatArray, b: FloatArray, n: int) -> float:
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


@compiled
def _add_to(a: FloatArray, b: FloatArray, factor: float, n: int) -> None:
    for k in range(n):
        a[k] += factor * b[k]


_SLIDES = 1.0 - 1e-6  # of a joint's `frictionloss`, of which less holds
_JOINT_LOSS = mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF.value
_LEAST_ARM = 1e-12  # [m]; a moment arm below is one of rounding
_UNEXPLAINED = 1e-9  # of a length: a change beyond what velocities say that is none of rounding


@apart
def _set_rows(m: Model, d: Data, work: int, k: int, state: State, segments: Segments) -> None:
    """Set the rows D of a sheath's groups, less their shares of D_0 if its stretch is spread."""
    nv = m.nv
    member, at_input, rows = _member(work, nv, k), _input_row(work, nv, k), _rows_at(work)
    owners, first, last = _owners(work, nv, member), int(member.first), int(member.last)
    doubles(rows + 8 * nv * first, nv * (last - first))[:] = 0.0
    for i in range(nv):
        at_input[i] = 0.0
    for j in range(len(segments)):
        if _is_span(segments, j):
            owner = int(owners[j])
            row = coordinates(rows + 8 * nv * owner) if owner >= 0 else at_input
            pull_segment(m, d, state, segments[j], -1.0 / segments[j].divisor, row)
    if member.is_fixed != 0.0:
        add_fixed_row(m, state, coordinates(rows + 8 * nv * first))
    for g in range(last - 1, first - 1, -1):
        parent = int(_group(work, g).parent)
        into = coordinates(rows + 8 * nv * parent) if parent >= 0 else at_input
        _add_to(into, coordinates(rows + 8 * nv * g), 1.0, nv)
    for g in range(first, last):
        row = coordinates(rows + 8 * nv * g)
        if member.spreads != 0.0:
            _add_to(row, at_input, -_group(work, g).share, nv)
        for i in range(nv):
            if abs(row[i]) < _LEAST_ARM:
                row[i] = 0.0


@apart
def _set_ways(
    work: int, nv: int, member: Member, state: State, segments: Segments, guides: Guides
) -> None:
    """Set the length from each group to the output end, and how far tendon has passed it."""
    owners, first, last = _owners(work, nv, member), int(member.first), int(member.last)
    whole = 0.0
    for g in range(first, last):
        _group(work, g).share = 0.0
    for j in range(len(segments)):
        owner = int(owners[j])
        length = segments[j].length / segments[j].divisor
        if owner >= 0:
            _group(work, owner).share += length
        whole += length
    for g in range(last - 1, first - 1, -1):
        group = _group(work, g)
        if group.parent >= 0.0:
            _group(work, int(group.parent)).share += group.share
    for g in range(first, last):
        group = _group(work, g)
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
    member = _member(work, nv, k)
    member.instance, member.first, member.is_stage = instance, first, stage
    member.owners, member.damping = head.segments, 0.0
    member.is_fixed = state.fixed
    member.spreads = state.spreads != 0.0 and state.constraint_force != 0.0
    _gather(work, nv, k, guides, segments)
    last, rough = int(member.last), False
    head.members, head.groups, head.segments = k + 1, last, head.segments + len(segments)
    _set_ways(work, nv, member, state, segments, guides)
    for g in range(first, last):
        group = _group(work, g)
        group.slides = _slid(member, group, guides)
        group.pretension = state.law.pretension if state.fixed != 0.0 else -1.0
        group.wanted = group.mobility = group.eases = 0.0
        if member.spreads == 0.0:
            group.share = 0.0
        _set_bounds(group, guides)
        group.row = -1.0
        rough |= group.is_rough != 0.0
    if not rough:
        return
    _set_rows(m, d, work, k, state, segments)
    velocity = d.qvel
    for g in range(first, last):
        group = _group(work, g)
        end = guides[int(group.end) - 1]
        speed = _dot(coordinates(_rows_at(work) + 8 * nv * g), velocity, nv)
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
        group.wanted = (speed + curved + drawn) / h
        if group.is_rough != 0.0:
            group.row = head.rough
            head.rough += 1.0


@compiled
def _incoming(work: int, nv: int, group: Group) -> float:
    """Tension in front of a group."""
    if group.parent >= 0.0:
        return _group(work, int(group.parent)).tension
    return _member(work, nv, int(group.member)).input


@compiled
def _take_over(work: int, nv: int, group: Group, friction: float) -> None:
    """Give a group its friction; where the stretch is spread the input bears its share."""
    if group.share != 0.0:
        member = _member(work, nv, int(group.member))
        member.constant += group.share * (friction - group.friction)
    group.friction = friction


@apart
def _start(m: Model, d: Data, work: int, nv: int, k: int) -> None:
    """Read T_0 of a sheath, and the tensions that its groups held."""
    member = _member(work, nv, k)
    state = state_at(state_of(m, d, int(member.instance)))
    segments, guides, _ = unpack(state_of(m, d, int(member.instance)))
    member.constant = state.input_force
    if not math.isfinite(state.input_force):
        member.constant = 0.0
    incoming = member.input = _pull(member, member.constant)
    before = state.input_force - state.constraint_force + state.previous_constraint
    follows = incoming - _pull(member, before) if member.spreads == 0.0 else 0.0
    for g in range(int(member.first), int(member.last)):
        group = _group(work, g)
        group.friction, group.slides = 0.0, _slid(member, group, guides)
        if group.is_set_for != group.slides:  # in another solution for the same pose
            _set_bounds(group, guides)
        group.before = group.before_in = incoming
        if state.finished != 0.0:
            group.before = segments[int(group.end)].previous_tension * group.divisor
            if group.mobility > 0.0:  # else nothing shows what it bears
                group.before += follows
            parent = int(group.parent)
            first = segments[0].previous_tension
            group.before_in = _group(work, parent).before if parent >= 0 else first
            if member.spreads != 0.0:  # the constraint bears what the shares have changed by
                end = guides[int(group.end) - 1]
                grown = group.share * (end.trial_way - end.way) / end.trial_way
                member.constant -= grown * (group.before - group.before_in)
                state.input_force = member.constant


@apart
def _hold(work: int, nv: int, g: int) -> None:
    """Let a group hold the tension behind it, or its friction where its stretch is spread."""
    group = _group(work, g)
    tension = _incoming(work, nv, group)
    held = group.before
    if _member(work, nv, int(group.member)).spreads != 0.0:
        held = tension + group.before - group.before_in
    group.tension = min(max(held, _lower(group, tension)), _upper(group, tension))
    _take_over(work, nv, group, group.tension - tension)


@apart
def _repeat(m: Model, d: Data, work: int, nv: int, g: int, moves: bool) -> None:
    """Let a group slide or hold as it was shown last, or, with ``moves``, slide as it moves."""
    group = _group(work, g)
    member = _member(work, nv, int(group.member))
    segments, _, _ = unpack(state_of(m, d, int(member.instance)))
    tension = _incoming(work, nv, group)
    low, high = _lower(group, tension), _upper(group, tension)
    held = group.divisor * segments[int(group.end)].trial_tension
    slides = group.passed if moves else group.slides
    if slides != 0.0:
        held = high if slides > 0.0 else low
    group.tension = min(max(held, low), high)
    _take_over(work, nv, group, group.tension - tension)


@apart
def repeat(m: Model, d: Data, work: int, moves: bool) -> None:
    """Set the friction of all groups as it was shown last, or, with ``moves``, as they move now."""
    nv, head = m.nv, head_at(work)
    for k in range(int(head.members)):
        _start(m, d, work, nv, k)
        member = _member(work, nv, k)
        if member.is_stage != 0.0 and member.spreads != 0.0:  # the input bore shares of friction
            segments, _, _ = unpack(state_of(m, d, int(member.instance)))
            member.input = segments[0].trial_tension
    for g in range(int(head.groups)):
        _repeat(m, d, work, nv, g, moves)
    _add_friction(work, nv)


_ROUNDS = 100  # of a sweep and the conjugate gradients that follow
_VISITS_IN_MOTION = 900  # of groups, in all rounds of a step
_EXACT = 1e-12  # of the accelerations, which is enough where groups move
_CLOSE = 1e-12  # change of a tension, over the largest, that ends them
_RESOLVED = 1e-20  # of Σ missing²/mobility, that conjugate gradients leave
_NOTHING = 1e-12  # of the mobility of groups by themselves: of groups that move nothing together
_EPSILON = 2.2e-16  # of a double; of accelerations that add up to none where a group holds
_STILL = 1e-12  # of its length, by which tendon that counts as still may pass a group in a step


@apart
def prepare(m: Model, d: Data, work: int) -> None:
    """Set up M̂ with the dampers that are integrated implicitly."""
    nv, head = m.nv, head_at(work)
    response = response_at(work, nv)
    prepare_response(m, d, response)
    if not is_implicit(m):
        return
    add_actuator_dampers(m, d, response, coordinates(vector_at(work, nv, _ROOM)))
    for k in range(int(head.members)):
        member = _member(work, nv, k)
        state = state_at(state_of(m, d, int(member.instance)))
        own = tendon_damping(m, state)
        member.damping = own + actuator_damping(m, d, state)
        if own > 0.0 and _is_rough(work, member):
            add_damper(m, response, _input_row(work, nv, k), own)


@apart
def _go_half_way(m: Model, work: int, nv: int, h: float) -> None:
    """Set all rows half way, and the mobility of the groups."""
    head, response = head_at(work), response_at(work, nv)
    weights, room = _half_vector(work, nv, _WEIGHTS), _half_vector(work, nv, _ALONG)
    set_weights(response, weights)
    width = response_width(response)
    for k in range(int(head.members)):
        if _member(work, nv, k).damping != 0.0:
            go_half_way(m, response, _input_row(work, nv, k), _input_half(work, nv, k))
    for g in range(int(head.groups)):
        group = _group(work, g)
        if group.row < 0.0:
            continue
        go_half_way(m, response, coordinates(_rows_at(work) + 8 * nv * g), room)
        half, places = _half(work, nv, group), _places(work, nv, group)
        count, mobility = 0, 0.0
        for i in range(width):
            if room[i] != 0.0:
                half[count] = room[i]
                places[count] = i
                mobility += weights[i] * room[i] * room[i]
                count += 1
        group.count, group.mobility, group.eases = count, mobility, group.share
        member = _member(work, nv, int(group.member))
        if member.damping != 0.0:
            at_input = _input_half(work, nv, int(group.member))
            eases = 0.0
            for i in range(count):
                place = places[i]
                eases += half[i] * weights[place] * at_input[place]
            group.eases += h * member.damping * eases


@compiled
def _across(work: int, nv: int, group: Group, half: FloatArray) -> float:
    """D M̂⁻¹ F of a group and a force that is half way, times the weights."""
    row, places = _half(work, nv, group), _places(work, nv, group)
    total = 0.0
    for k in range(int(group.count)):
        total += row[k] * half[places[k]]
    return total


@compiled
def _add_half(work: int, nv: int, group: Group, half: FloatArray, factor: float) -> None:
    """Add a multiple of the row of a group, times the weights, to a force that is half way."""
    row, places = _half(work, nv, group), _places(work, nv, group)
    weights = _half_vector(work, nv, _WEIGHTS)
    for k in range(int(group.count)):
        i = places[k]
        half[i] += factor * weights[i] * row[k]


@compiled
def _is_rough(work: int, member: Member) -> bool:
    """Whether a sheath has friction at all."""
    rough = False
    for g in range(int(member.first), int(member.last)):
        rough |= _group(work, g).row >= 0.0
    return rough


@compiled
def _update_input(work: int, nv: int, k: int, h: float) -> None:
    """T_0 of a sheath with the acceleration at hand."""
    member = _member(work, nv, k)
    force = member.constant
    if member.damping != 0.0:
        row, forces = _input_half(work, nv, k), _half_vector(work, nv, _FORCES)
        for i in range(response_width(response_at(work, nv))):
            force -= h * member.damping * row[i] * forces[i]
    member.input = _pull(member, force)


@compiled
def _change(work: int, nv: int, group: Group, friction: float) -> None:
    """Change the friction of a group, and the acceleration with it."""
    change = friction - group.friction
    if change != 0.0:
        _add_half(work, nv, group, _half_vector(work, nv, _FORCES), -change)
        _take_over(work, nv, group, friction)


@compiled
def _bounds(group: Group, tension: float) -> tuple[float, float]:
    """Least and largest friction of a group, as T_0 changes with it."""
    if group.pretension >= 0.0:
        return _of_cables(group, tension + group.eases * group.friction, group.eases)
    rise, fall = group.upper_ratio - 1.0, group.fall
    if group.eases != 0.0:
        tension += group.eases * group.friction
        high = (rise * tension + group.upper_offset) / max(1e-3, 1.0 + group.eases * rise)
        low = (fall * tension - group.fall_offset) / max(1e-3, 1.0 + group.eases * fall)
    else:
        high, low = rise * tension + group.upper_offset, fall * tension - group.fall_offset
    return max(low, -max(0.0, tension)), max(0.0, high)


@compiled
def _missing(work: int, nv: int, group: Group) -> tuple[float, float]:
    """By how much more the slip of a group has to be slowed, and what that is the sum of [m/s²]."""
    row, places = _half(work, nv, group), _places(work, nv, group)
    forces = _half_vector(work, nv, _FORCES)
    missing, sizes = group.wanted, abs(group.wanted) + group.mobility * abs(group.friction)
    for k in range(int(group.count)):
        part = row[k] * forces[places[k]]
        missing, sizes = missing + part, sizes + abs(part)
    return missing, sizes


@apart
def _sweep(work: int, nv: int, h: float, least: float) -> bool:
    """Let every group hold or slide, one after the other; return whether any tension changed."""
    changed = largest = 0.0
    for g in range(int(head_at(work).groups)):
        group = _group(work, g)
        if group.parent < 0.0:
            _update_input(work, nv, int(group.member), h)
        tension = _incoming(work, nv, group)
        group.tension = tension
        if group.row < 0.0:
            continue
        low, high = _bounds(group, tension)
        friction, (missing, sizes) = group.friction, _missing(work, nv, group)
        if abs(missing) > least * sizes:
            if group.mobility > 0.0:
                friction += missing / group.mobility
            else:
                friction = high if missing > 0.0 else low
        group.slides = 1.0 if friction > high else (-1.0 if friction < low else 0.0)
        friction = min(max(friction, low), high)
        changed = max(changed, abs(friction - group.friction))
        _change(work, nv, group, friction)
        if group.parent < 0.0:
            _update_input(work, nv, int(group.member), h)
            tension = _incoming(work, nv, group)
        group.tension = tension + friction
        largest = max(largest, abs(group.tension), abs(tension))
    return changed > _CLOSE * largest


@compiled
def _free_group(work: int, k: int) -> Group:
    """The k-th group that holds with less friction than it can have."""
    return _group(work, int(_group(work, k).free))


@apart
def _begin_gradients(work: int, nv: int) -> float:
    """Set what all groups that hold miss, and go along that; return Σ missing²/mobility."""
    head, size_of_missing, is_missing = head_at(work), 0.0, False
    head.free = 0.0
    for g in range(int(head.groups)):
        group = _group(work, g)
        if group.row >= 0.0 and group.slides == 0.0 and group.mobility > 0.0:
            _group(work, int(head.free)).free = g
            head.free += 1.0
            group.missing, sizes = _missing(work, nv, group)
            is_missing |= abs(group.missing) > _EXACT * sizes
            group.along = group.missing / group.mobility
            size_of_missing += group.missing * group.along
    return size_of_missing if is_missing else 0.0


@apart
def _go_along(work: int, nv: int, size_of_missing: float) -> float:
    """Change the friction of all groups that hold along the conjugate gradient.

    Returns:
        Σ missing²/mobility afterwards; 0 where one came to its bound, or nothing is missing.
    """
    along, width = _half_vector(work, nv, _ALONG), response_width(response_at(work, nv))
    count, curvature, most, bounded = int(head_at(work).free), 0.0, 0.0, False
    for i in range(width):
        along[i] = 0.0
    for k in range(count):
        group = _free_group(work, k)
        _add_half(work, nv, group, along, group.along)
    for k in range(count):
        group = _free_group(work, k)
        group.answer = _across(work, nv, group, along)
        curvature += group.along * group.answer
        most += group.along * group.along * group.mobility
    if not curvature > _NOTHING * most:
        return 0.0
    step = size_of_missing / curvature
    for k in range(count):
        group = _free_group(work, k)
        low, high = _bounds(group, group.tension - group.friction)  # the tension behind stays
        room = (high if group.along > 0.0 else low) - group.friction
        if step * abs(group.along) > abs(room):
            step, bounded = abs(room) / abs(group.along), True
    left = 0.0
    for k in range(count):
        group = _free_group(work, k)
        _take_over(work, nv, group, group.friction + step * group.along)
        group.missing -= step * group.answer
        left += group.missing * group.missing / group.mobility
    _add_to(_half_vector(work, nv, _FORCES), along, -step, width)
    for k in range(count):
        group = _free_group(work, k)
        group.along = group.missing / group.mobility + left / size_of_missing * group.along
    return 0.0 if bounded else left


@apart
def _share_load(work: int, nv: int) -> None:
    """Let the groups that hold share what is missing, until one comes to its bound."""
    missing = first = _begin_gradients(work, nv)
    for _ in range(nv):
        if not missing > _RESOLVED * first:
            break
        missing = _go_along(work, nv, missing)


@compiled
def _is_still(work: int) -> bool:
    """Whether no group slid in the step before."""
    still = True
    for g in range(int(head_at(work).groups)):
        still = still and _group(work, g).is_set_for == 0.0
    return still


@apart
def _settle(work: int, nv: int, h: float) -> None:
    """Let every group hold or slide.

    A sweep finds which groups slide. Those that hold depend on each other: for them conjugate
    gradients, which share a load among all that can bear it, take about as many steps as there are
    directions in which bodies can move, and end where a group comes to its bound. While tendon
    slides, a few rounds do where groups are many: the next step corrects what they leave.
    """
    least, rounds = _EPSILON, _ROUNDS
    if not _is_still(work):
        rounds = min(rounds, 1 + _VISITS_IN_MOTION // int(head_at(work).rough))
    for _ in range(rounds):
        if not _sweep(work, nv, h, least):
            break
        least = _EXACT
        _share_load(work, nv)


@apart
def _release(m: Model, d: Data, work: int, nv: int) -> bool:
    """Let groups that broke loose slide at μ_d; return whether there are any."""
    released = False
    for g in range(int(head_at(work).groups)):
        group = _group(work, g)
        if group.is_static == 0.0 or group.slides == 0.0:
            continue
        instance = int(_member(work, nv, int(group.member)).instance)
        _, guides, _ = unpack(state_of(m, d, instance))
        upper, lower = group.upper_ratio, group.lower_ratio
        _set_bounds(group, guides)
        released |= group.upper_ratio != upper or group.lower_ratio != lower
    return released


@compiled
def _write_guides(work: int, nv: int, group: Group, segments: Segments, guides: Guides) -> None:
    """Write the tensions, flows and friction work of a group's guides, on trial.

    Where friction holds, the tension along the group is that share of what it would be at the bound
    which its end has.
    """
    incoming, up = _incoming(work, nv, group), group.friction > 0.0
    bound = _upper(group, incoming) if up else _lower(group, incoming)
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
            ratio, offset = _towards_output(guide, group.divisor, group.is_set_for > 0.0)
            extreme = ratio * extreme + offset
        else:
            ratio, offset = _towards_input(guide, group.divisor, group.is_set_for < 0.0)
            extreme = max(0.0, (extreme - offset) / ratio)
        tension = group.tension if i == end - 1 else incoming + part * (extreme - incoming)
        segments[i + 1].trial_tension = tension / group.divisor
        guide.flow = guide.trial_flow = flow
        guide.slip = guide.trial_slip = -slides if flow != 0.0 else 0.0
        guide.trial_friction_work = abs((tension - before) * flow)


@apart
def _write(m: Model, d: Data, work: int, nv: int, k: int, time: float) -> None:
    """Write the result of a sheath, and keep it on trial."""
    member = _member(work, nv, k)
    address = state_of(m, d, int(member.instance))
    state = state_at(address)
    segments, guides, _ = unpack(address)
    owners = _owners(work, nv, member)
    for j in range(len(segments)):
        owner = int(owners[j])
        tension = _group(work, owner).tension if owner >= 0 else member.input
        segments[j].trial_tension = tension / segments[j].divisor
    for g in range(int(member.first), int(member.last)):
        _write_guides(work, nv, _group(work, g), segments, guides)
    changes = _pull(member, state.input_force) - member.input
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
        group = _group(work, g)
        if group.friction != 0.0:
            _add_to(friction, coordinates(_rows_at(work) + 8 * nv * g), -group.friction, nv)


@apart
def _add_up(m: Model, d: Data, work: int, nv: int) -> FloatArray:
    """Add up the forces that are known before friction."""
    place = known_forces_at(m, d, int(head_at(work).leader))
    known = coordinates(place)
    base = coordinates(vector_at(work, nv, BASE))
    for i in range(nv):
        known[i] = base[i]
    add_smooth_forces(m, d, place)
    return known


@apart
def solve(m: Model, d: Data, work: int) -> None:
    """Solve the friction of all groups under the forces at hand, and add it to FRICTION."""
    nv, head, h = m.nv, head_at(work), m.opt.timestep
    stage = False
    for k in range(int(head.members)):
        member = _member(work, nv, k)
        stage |= member.is_stage != 0.0
        state_at(state_of(m, d, int(member.instance))).applied = 1.0
    friction, known = coordinates(vector_at(work, nv, FRICTION)), _add_up(m, d, work, nv)
    if stage:
        repeat(m, d, work, False)
        _add_to(known, friction, 1.0, nv)
        return
    if head.rough > 0.0:
        _go_half_way(m, work, nv, h)
    for k in range(int(head.members)):
        _start(m, d, work, nv, k)
    if head.rough > 0.0:
        forces, room = _half_vector(work, nv, _FORCES), coordinates(vector_at(work, nv, _ROOM))
        unknown = unknown_forces(m, d, int(head.leader))
        for i in range(nv):
            room[i] = known[i] + friction[i] + unknown[i]
        go_half_way(m, response_at(work, nv), room, forces)
        weights = _half_vector(work, nv, _WEIGHTS)
        for i in range(response_width(response_at(work, nv))):
            forces[i] *= weights[i]
        for g in range(int(head.groups)):
            group = _group(work, g)
            _hold(work, nv, g)
            if group.friction != 0.0:
                _add_half(work, nv, group, forces, -group.friction)
        for _ in range(1 + 2 * int(head.rough)):
            _settle(work, nv, h)
            if not _release(m, d, work, nv):
                break
    for k in range(int(head.members)):
        _update_input(work, nv, k, h)
    for g in range(int(head.groups)):
        group = _group(work, g)
        incoming = _incoming(work, nv, group)
        tension = incoming + group.friction
        if group.pretension < 0.0:
            tension = max(0.0, tension)
        if group.slides != 0.0 and group.row >= 0.0 and group.share == 0.0:
            tension = _upper(group, incoming) if group.slides > 0.0 else _lower(group, incoming)
        group.tension = tension
        group.friction = tension - incoming
    _add_friction(work, nv)
    _add_to(known, friction, 1.0, nv)
    time = d.time
    for k in range(int(head.members)):
        _write(m, d, work, nv, k, time)


@apart
def keep_slips(m: Model, d: Data, work: int) -> None:
    """Keep how all groups slip at the end of the step, as in the pose at its beginning."""
    nv, velocity = m.nv, d.qvel
    for k in range(int(head_at(work).members)):
        member = _member(work, nv, k)
        address = state_of(m, d, int(member.instance))
        if not _is_rough(work, member):  # nor are there rows
            continue
        state_at(address).slips_kept = 1.0
        _, guides, _ = unpack(address)
        for g in range(int(member.first), int(member.last)):
            group = _group(work, g)
            ended = _dot(coordinates(_rows_at(work) + 8 * nv * g), velocity, nv)
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
    for i in range(m.nv):
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
