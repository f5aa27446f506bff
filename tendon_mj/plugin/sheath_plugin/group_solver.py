"""Which groups of guides hold and which slide, and the friction of each.

A group holds where its slip can be ended in the step at hand:

    s_i/h + D_i M̂⁻¹ (F + r − Σ f_j D_j) = 0,   f_i at its bound if it slides.

Rows D are taken half way to their response (`response`), so that a change of friction costs a
product of rows. A sweep over all groups finds which of them slide, and conjugate gradients share
the load among those that hold.
"""

from __future__ import annotations

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.memory import coordinates
from tendon_mj.plugin.sheath_plugin.capstan_bounds import set_bounds
from tendon_mj.plugin.sheath_plugin.gear_losses import friction_of_cables, jams
from tendon_mj.plugin.sheath_plugin.groups import (
    ALONG,
    FORCES,
    Group,
    Member,
    group_of,
    half_places,
    half_row,
    half_vector,
    head_at,
    incoming_tension,
    input_half,
    input_row,
    member_of,
    response_at,
    rows_at,
)
from tendon_mj.plugin.sheath_plugin.response import go_half_way, weights_at
from tendon_mj.plugin.sheath_plugin.state import state_of, unpack
from tendon_mj.typing import FloatArray


@compiled
def pull_of(member: Member, force: float) -> float:
    """T_0 under MuJoCo's force along a tendon."""
    return -force if member.is_fixed != 0.0 else max(0.0, -force)


@compiled
def dot(a: FloatArray, b: FloatArray, n: int) -> float:
    """a · b."""
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


@compiled
def add_to(a: FloatArray, b: FloatArray, factor: float, n: int) -> None:
    """Add a multiple of b to a."""
    for k in range(n):
        a[k] += factor * b[k]


@compiled
def take_over(work: int, nv: int, group: Group, friction: float) -> None:
    """Give a group its friction; where the stretch is spread the input bears its share."""
    if group.share != 0.0:
        member = member_of(work, nv, int(group.member))
        member.constant += group.share * (friction - group.friction)
    group.friction = friction


_ROUNDS = 100  # of a sweep and the conjugate gradients that follow
_VISITS_IN_MOTION = 900  # of groups, in all rounds of a step
_EXACT = 1e-12  # of the accelerations, which is enough where groups move
_UNDAMPED = 10  # rounds, after which a sweep changes half as much as before
_CLOSE = 1e-12  # change of a tension, over the largest, that ends them
_RESOLVED = 1e-20  # of Σ missing²/mobility, that conjugate gradients leave
_NOTHING = 1e-12  # of the mobility of groups by themselves: of groups that move nothing together
_EPSILON = 2.2e-16  # of a double; of accelerations that add up to none if a group holds


@apart
def set_half_rows(m: Model, work: int, nv: int, h: float) -> None:
    """Set all rows half way, and the mobility of the groups."""
    head, response = head_at(work), response_at(work, nv)
    weights, room = weights_at(response, nv), half_vector(work, nv, ALONG)
    for k in range(int(head.members)):
        if member_of(work, nv, k).damping != 0.0:
            go_half_way(m, response, input_row(work, nv, k), input_half(work, nv, k))
    for g in range(int(head.groups)):
        group = group_of(work, g)
        if group.row < 0.0:
            continue
        go_half_way(m, response, coordinates(rows_at(work) + 8 * nv * g), room)
        half, places = half_row(work, nv, group), half_places(work, nv, group)
        count, mobility = 0, 0.0
        for i in range(nv):
            if room[i] != 0.0:
                half[count] = room[i]
                places[count] = i
                mobility += weights[i] * room[i] * room[i]
                count += 1
        group.count, group.mobility, group.eases = count, mobility, group.share
        member = member_of(work, nv, int(group.member))
        if member.damping != 0.0:
            at_input = input_half(work, nv, int(group.member))
            eases = 0.0
            for i in range(count):
                place = places[i]
                eases += half[i] * weights[place] * at_input[place]
            group.eases += h * member.damping * eases


@compiled
def _across(work: int, nv: int, group: Group, half: FloatArray) -> float:
    """D M̂⁻¹ F of a group and a force that is half way, times the weights."""
    row, places = half_row(work, nv, group), half_places(work, nv, group)
    total = 0.0
    for k in range(int(group.count)):
        total += row[k] * half[places[k]]
    return total


@compiled
def add_half(work: int, nv: int, group: Group, half: FloatArray, factor: float) -> None:
    """Add a multiple of the row of a group, times the weights, to a force that is half way."""
    row, places = half_row(work, nv, group), half_places(work, nv, group)
    weights = weights_at(response_at(work, nv), nv)
    for k in range(int(group.count)):
        i = places[k]
        half[i] += factor * weights[i] * row[k]


@compiled
def update_input(work: int, nv: int, k: int, h: float) -> None:
    """T_0 of a sheath with the acceleration at hand."""
    member = member_of(work, nv, k)
    force = member.constant
    if member.damping != 0.0:
        row, forces = input_half(work, nv, k), half_vector(work, nv, FORCES)
        for i in range(nv):
            force -= h * member.damping * row[i] * forces[i]
    member.input = pull_of(member, force)


@compiled
def set_jam(work: int, nv: int, group: Group, forces: FloatArray) -> None:
    """Tell whether a gear jams; the ``forces`` half way are all but the friction of its group."""
    tension, still, momentum = member_of(work, nv, int(group.member)).input, 0.0, 0.0
    if group.mobility > 0.0:
        still = _across(work, nv, group, forces) / group.mobility
        momentum = group.wanted / group.mobility
    group.jams = jams(group, tension, still, still + momentum)


@compiled
def _change(work: int, nv: int, group: Group, friction: float) -> None:
    """Change the friction of a group, and the acceleration with it."""
    change = friction - group.friction
    if change != 0.0:
        add_half(work, nv, group, half_vector(work, nv, FORCES), -change)
        take_over(work, nv, group, friction)


@compiled
def _bounds(group: Group, tension: float) -> tuple[float, float]:
    """Least and largest friction of a group, as T_0 changes with it."""
    if group.pretension >= 0.0:
        tension += group.eases * group.friction
        return friction_of_cables(group, tension, group.eases)
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
    row, places = half_row(work, nv, group), half_places(work, nv, group)
    forces = half_vector(work, nv, FORCES)
    missing, sizes = group.wanted, abs(group.wanted) + group.mobility * abs(group.friction)
    for k in range(int(group.count)):
        part = row[k] * forces[places[k]]
        missing, sizes = missing + part, sizes + abs(part)
    return missing, sizes


@apart
def _sweep(work: int, nv: int, h: float, least: float, part: float) -> bool:
    """Let every group hold or slide, one after the other, by a ``part`` of what that changes.

    Returns:
        Whether any tension would still change.
    """
    changed = largest = 0.0
    for g in range(int(head_at(work).groups)):
        group = group_of(work, g)
        if group.parent < 0.0:
            update_input(work, nv, int(group.member), h)
        tension = incoming_tension(work, nv, group)
        group.tension = tension
        if group.row < 0.0:
            continue
        friction, (missing, sizes) = group.friction, _missing(work, nv, group)
        if abs(missing) > least * sizes and group.mobility > 0.0:
            friction += missing / group.mobility
        low, high = _bounds(group, tension)
        if abs(missing) > least * sizes and not group.mobility > 0.0:
            friction = high if missing > 0.0 else low
        group.slides = 1.0 if friction > high else (-1.0 if friction < low else 0.0)
        change = min(max(friction, low), high) - group.friction
        changed = max(changed, abs(change))
        _change(work, nv, group, group.friction + part * change)
        if group.parent < 0.0:
            update_input(work, nv, int(group.member), h)
            tension = incoming_tension(work, nv, group)
        group.tension = tension + group.friction
        largest = max(largest, abs(group.tension), abs(tension))
    return changed > _CLOSE * largest


@compiled
def _free_group(work: int, k: int) -> Group:
    """The k-th group that holds with less friction than it can have."""
    return group_of(work, int(group_of(work, k).free))


@apart
def _begin_gradients(work: int, nv: int) -> float:
    """Set what all groups that hold miss, and go along that; return Σ missing²/mobility."""
    head, size_of_missing, is_missing = head_at(work), 0.0, False
    head.free = 0.0
    for g in range(int(head.groups)):
        group = group_of(work, g)
        if group.row >= 0.0 and group.slides == 0.0 and group.mobility > 0.0:
            group_of(work, int(head.free)).free = g
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
        Σ missing²/mobility afterwards; 0 if one came to its bound, or nothing is missing.
    """
    along = half_vector(work, nv, ALONG)
    count, curvature, most, bounded = int(head_at(work).free), 0.0, 0.0, False
    for i in range(nv):
        along[i] = 0.0
    for k in range(count):
        group = _free_group(work, k)
        add_half(work, nv, group, along, group.along)
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
        tension = group.tension - group.friction  # the tension behind stays
        low, high = _bounds(group, tension)
        room = (high if group.along > 0.0 else low) - group.friction
        if step * abs(group.along) > abs(room):
            step, bounded = abs(room) / abs(group.along), True
    left = 0.0
    for k in range(count):
        group = _free_group(work, k)
        take_over(work, nv, group, group.friction + step * group.along)
        group.missing -= step * group.answer
        left += group.missing * group.missing / group.mobility
    add_to(half_vector(work, nv, FORCES), along, -step, nv)
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
    """Return whether no group slid in the step before."""
    still = True
    for g in range(int(head_at(work).groups)):
        still = still and group_of(work, g).is_set_for == 0.0
    return still


@apart
def settle(work: int, nv: int, h: float) -> None:
    """Let every group hold or slide.

    A sweep finds which groups slide. Those that hold depend on each other: for them conjugate
    gradients, which share a load among all that can bear it, take about as many steps as there are
    directions in which bodies can move, and end where a group comes to its bound. Friction that
    magnifies what comes in can make sweeps swing: they go on in ever smaller parts. While tendon
    slides, a few rounds do where groups are many: the next step corrects what they leave.
    """
    least, rounds = _EPSILON, _ROUNDS
    if not _is_still(work):
        rounds = min(rounds, 1 + _VISITS_IN_MOTION // int(head_at(work).rough))
    part = 1.0
    for k in range(rounds):
        if k % _UNDAMPED == _UNDAMPED - 1:
            part *= 0.5
        if not _sweep(work, nv, h, least, part):
            break
        least = _EXACT
        _share_load(work, nv)


@apart
def release(m: Model, d: Data, work: int, nv: int) -> bool:
    """Let groups that broke loose slide at μ_d; return whether there are any."""
    released = False
    for g in range(int(head_at(work).groups)):
        group = group_of(work, g)
        if group.is_static == 0.0 or group.slides == 0.0:
            continue
        instance = int(member_of(work, nv, int(group.member)).instance)
        _, guides, _ = unpack(state_of(m, d, instance))
        upper, lower = group.upper_ratio, group.lower_ratio
        set_bounds(group, guides)
        released |= group.upper_ratio != upper or group.lower_ratio != lower
    return released
