"""Groups of guides of tendons without elasticity, and the memory for them.

Guides between which the tendon cannot change its length hold or slide as one. The memory of all
sheaths of a model is one block, which the binding of the last sheath keeps: a `Head`, the groups,
their rows, the sheaths, and vectors. Numbers that say where something is are whole.
"""

from __future__ import annotations

from collections.abc import Callable

from tendon_mj.native import Record, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import free, malloc
from tendon_mj.plugin.abi.memory import coordinates, doubles, word, words
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.response import response_size
from tendon_mj.plugin.sheath_plugin.state import SHEATH, WORKSPACE, binding_at, binding_of
from tendon_mj.sheath import Guides, Segments, record_type
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
    forward: float  # η_f of a gear before these cables
    back: float  # 1/η_b of it, inf and below 0 if it locks itself
    jams: float  # whether the load has jammed that, which the motor turns to release
    servo: float  # largest friction of a servo before these, −1 without one [N]
    is_rough: float  # whether there is any friction
    is_static: float  # whether friction at rest is more than that of sliding
    is_set_for: float  # ``slides`` for which these bounds are
    slides: float  # +1 at the upper bound, −1 at the lower one, 0 if it holds
    share: float  # L_i/L_0 where the stretch of the tendon is spread along it, else 0
    passed: float  # Δl, since the last step towards the output [m]
    wanted: float  # what the slip has to be slowed by in this step [m/s²]
    mobility: float  # A_ii [1/kg]
    eases: float  # how much less T_0 is for each newton of friction
    row: float  # of D half way, −1 if there is no friction
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
    spots: float  # segments that there is memory for
    sheaths: float  # that there is memory for
    leader: float  # first sheath of the model, which keeps forces for all
    driven: float  # how many driven sheaths there are
    elastic: float  # of them with a stated elasticity
    members: float  # of them without
    groups: float  # how many groups
    segments: float  # of these sheaths
    rough: float  # how many of them have friction
    pushing: float  # whether there are constraints that push only
    free: float  # how many of these hold with less friction than they can have
    signature: float  # of the velocities for which they were set up, 0: none
    is_nested: float  # whether actuators are being computed once more
    gives: float  # whether passive forces are being computed once more, with the friction known


HEAD = record_type(Head)
_HEAD_COUNT = HEAD.itemsize // 8
head_at: Callable[[int], Head] = Record(HEAD)


@compiled
def _size_of(room: int, spots: int, sheaths: int, nv: int) -> int:
    """Numbers of a workspace: groups, their rows, sheaths, owners of segments, vectors."""
    groups = room * (_GROUP_COUNT + 3 * nv)
    return _HEAD_COUNT + groups + sheaths * (_MEMBER_COUNT + 1 + 2 * nv) + spots + 7 * nv


@compiled
def group_of(work: int, g: int) -> Group:
    """Group number g."""
    return _group_at(work + 8 * (_HEAD_COUNT + _GROUP_COUNT * g))


@compiled
def rows_at(work: int) -> int:
    """Address of the rows of D."""
    return work + 8 * (_HEAD_COUNT + _GROUP_COUNT * int(head_at(work).room))


@compiled
def half_row(work: int, nv: int, group: Group) -> FloatArray:
    """Row of D half way: the numbers that are not 0."""
    rows = rows_at(work) + 8 * nv * int(head_at(work).room)
    return coordinates(rows + 16 * nv * int(group.row))


@compiled
def half_places(work: int, nv: int, group: Group) -> IntArray:
    """Where these numbers are."""
    rows = rows_at(work) + 8 * nv * int(head_at(work).room)
    return words(rows + 16 * nv * int(group.row) + 8 * nv)


@compiled
def _members_at(work: int, nv: int) -> int:
    return rows_at(work) + 24 * nv * int(head_at(work).room)


@compiled
def driven_sheaths(work: int, nv: int) -> FloatArray:
    """Instances of all driven sheaths."""
    return coordinates(_members_at(work, nv) + 8 * _MEMBER_COUNT * int(head_at(work).sheaths))


@compiled
def member_of(work: int, nv: int, k: int) -> Member:
    """Sheath number k of those whose tendon is inextensible."""
    return _member_at(_members_at(work, nv) + 8 * _MEMBER_COUNT * k)


@compiled
def _owners_at(work: int, nv: int) -> int:
    return _members_at(work, nv) + 8 * (_MEMBER_COUNT + 1) * int(head_at(work).sheaths)


@compiled
def owners_of(work: int, nv: int, member: Member) -> FloatArray:
    """Group whose tension a segment of a sheath has, −1: the input's."""
    return coordinates(_owners_at(work, nv) + 8 * int(member.owners))


@compiled
def vector_at(work: int, nv: int, which: int) -> int:
    """Address of a vector.

    Passive forces before friction, friction, constraints at no acceleration, the acceleration that
    tells which of them push, room for one.
    """
    return _owners_at(work, nv) + 8 * (int(head_at(work).spots) + which * nv)


BASE, FRICTION, CONSTRAINTS, ACCELERATION, ROOM = range(5)


@compiled
def half_vector(work: int, nv: int, which: int) -> FloatArray:
    """All forces half way, and their changes along the conjugate gradient, times the weights."""
    return coordinates(vector_at(work, nv, ROOM + 1 + which))


FORCES, ALONG = range(2)


@compiled
def _input_at(work: int, nv: int, k: int) -> int:
    return vector_at(work, nv, ROOM + 3 + 2 * k)


@compiled
def input_row(work: int, nv: int, k: int) -> FloatArray:
    """D_0 of a sheath."""
    return coordinates(_input_at(work, nv, k))


@compiled
def input_half(work: int, nv: int, k: int) -> FloatArray:
    """D_0 of a sheath, half way."""
    return coordinates(_input_at(work, nv, k) + 8 * nv)


@compiled
def response_at(work: int, nv: int) -> int:
    """Address of the response M̂⁻¹."""
    return _input_at(work, nv, int(head_at(work).sheaths))


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
    head = head_at(work)
    if work != 0 and (head.room < room or head.sheaths < sheaths):
        free(work)
        work = 0
    if work == 0:
        count = _size_of(room, spots, sheaths, nv) + response_size(m)
        work = malloc(8 * count)
        doubles(work, count)[:] = 0.0
        head = head_at(work)
        head.room, head.spots, head.sheaths = room, spots, sheaths
        words(place)[0] = work
    return work


@compiled
def is_span(segments: Segments, j: int) -> bool:
    """Return whether the length of a segment can change."""
    return segments[j].point >= 0.0 and segments[j].near_body != segments[j].far_body


@apart
def gather(work: int, nv: int, k: int, guides: Guides, segments: Segments) -> None:
    """Gather the guides of a sheath into groups, in the order of its path."""
    member = member_of(work, nv, k)
    owners, g = owners_of(work, nv, member), int(member.first)
    owners[0] = owner = -1.0
    begins = True
    for i in range(len(guides)):
        owners[i + 1] = owner
        if guides[i].is_pulley != 0.0:
            fed_by = int(guides[i].fed_by)
            owners[i + 1] = owner = owners[fed_by] if 0 <= fed_by <= i else -1.0
            begins = True
            continue
        if begins or is_span(segments, i):
            group = group_of(work, g)
            group.member, group.begin = k, i
            group.parent, group.divisor = owner, segments[i].divisor
            owner, g = g, g + 1
        group_of(work, g - 1).end = i + 1
        owners[i + 1] = owner
        begins = False
    member.last = g


@compiled
def incoming_tension(work: int, nv: int, group: Group) -> float:
    """Tension in front of a group."""
    if group.parent >= 0.0:
        return group_of(work, int(group.parent)).tension
    return member_of(work, nv, int(group.member)).input


@compiled
def has_friction(work: int, member: Member) -> bool:
    """Return whether a sheath has friction at all."""
    rough = False
    for g in range(int(member.first), int(member.last)):
        rough |= group_of(work, g).row >= 0.0
    return rough
