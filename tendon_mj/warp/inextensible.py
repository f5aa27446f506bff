"""Kernels: friction of the groups of all inextensible tendons, solved together in each world.

The same as `tendon_mj.plugin.sheath_plugin.inextensible`, where the method is explained, without
friction work. Slip is D q̇, not a difference of lengths, which single precision would round.

`set_up` follows each path and gathers groups, `fill_rows` computes D for each dof, `accelerate` of
`response` what moves without friction, `answer` M̂⁻¹ Dᵀ for each group, `solve` the friction of a
world, `publish` the tensions of each sheath, and `add_friction` adds the forces for each dof.
"""

import warp as wp

from tendon_mj.warp.groups import Groups
from tendon_mj.warp.motion import Dynamics, input_force, span_jacobian
from tendon_mj.warp.path import Scene, trace_path
from tendon_mj.warp.response import damping_of, respond, step_of, tendon_damping
from tendon_mj.warp.tendons import (
    HALF,
    INF,
    ONE,
    ZERO,
    Tendons,
    capstan,
    follow_speed,
    reset_sheath,
    sheath_at,
)

wp.set_module_options({"enable_backward": False})

_TENDON = wp.constant(3)  # mjtTrn
_LEAST_ARM = wp.constant(1e-7)  # [m]; a moment arm below is one of rounding
_UNEXPLAINED = wp.constant(wp.float64(1e-6))  # of a length: a change that is not of rounding
_ROUNDS = wp.constant(100)  # of a sweep and the conjugate gradients that follow
_UNDAMPED = wp.constant(10)  # rounds, after which a sweep changes half as much as before
_VISITS_IN_MOTION = wp.constant(900)  # of groups, in all rounds of a step
_RESOLVED = wp.constant(wp.float64(1e-14))  # of Σ missing²/mobility, single precision squared
_CLOSE = wp.constant(wp.float64(1e-9))  # change of a tension, over the largest, that ends them
_ROUNDED = wp.constant(wp.float64(2.4e-7))  # of accelerations that add up to none
_STILL = wp.constant(wp.float64(1e-12))  # of its length, by which one that is still may move
_LEAST = wp.constant(wp.float64(1e-3))  # denominator of a bound


@wp.func
def _speed(y: Groups, c: int, qvel: wp.array2d[wp.float32], w: int) -> wp.float64:
    """D q̇ of a group [m/s]."""
    i = y.member[c]
    first, row = y.first_dof[i], y.row[c]
    total = wp.float64(0.0)
    for e in range(first, y.first_dof[i + 1]):
        total += wp.float64(y.D[row + e - first, w]) * wp.float64(qvel[w, y.dof[e]])
    return total


@wp.func
def commit_member(
    t: Tendons,
    y: Groups,
    qvel: wp.array2d[wp.float32],
    timestep: wp.array[wp.float32],
    i: int,
    w: int,
) -> None:
    """Make the step on trial the committed state."""
    k, h = y.sheath[i], wp.float64(timestep[w % timestep.shape[0]])
    y.input_before[i, w] = y.input[i, w]
    for c in range(y.first_cell[i], y.first_cell[i + 1]):
        y.before[c, w] = y.tension[c, w]
        y.slid[c, w] = wp.int8(wp.where(y.flows[c, w], int(y.slides[c, w]), 0))
        y.way_before[c, w] = y.way[c, w]
        speed = wp.where(y.flows[c, w], wp.float64(y.speed[y.head[c, w], w]), ZERO)
        for guide in range(y.begin[c], y.end[c]):
            follow_speed(t, k, guide, speed, h, w)
        y.speed_before[c, w] = wp.float32(_speed(y, y.head[c, w], qvel, w))
    t.previous_constraint[k, w] = t.constraint_force[k, w]
    t.constraint_force[k, w] = t.solved_force[k, w]
    t.started[k, w] = True
    t.has_trial[k, w] = False


@wp.kernel
def keep_unknown(
    time: wp.array[wp.float32],
    smooth: wp.array2d[wp.float32],
    constraint: wp.array2d[wp.float32],
    acceleration: wp.array2d[wp.float32],
    t: Tendons,
    y: Groups,
) -> None:
    """Keep the forces of ended steps that friction did not know; threads (dofs, worlds)."""
    dof, w = wp.tid()
    k = y.sheath[0]
    if t.has_trial[k, w] and time[w] > t.trial_time[k, w]:
        force = wp.float64(smooth[w, dof]) + wp.float64(constraint[w, dof]) - y.known[dof, w]
        force -= y.borne[dof, w]
        y.unknown[dof, w] = wp.where(wp.isfinite(force), force, ZERO)
        last = acceleration[w, dof]
        y.last[dof, w] = wp.float64(wp.where(wp.isfinite(last), last, 0.0))


@wp.kernel
def commit_groups(
    time: wp.array[wp.float32],
    timestep: wp.array[wp.float32],
    qvel: wp.array2d[wp.float32],
    t: Tendons,
    y: Groups,
) -> None:
    """Commit ended steps; threads (members, worlds)."""
    i, w = wp.tid()
    k = y.sheath[i]
    if t.has_trial[k, w] and time[w] > t.trial_time[k, w]:
        commit_member(t, y, qvel, timestep, i, w)


@wp.func
def _gather(t: Tendons, y: Groups, i: int, w: int) -> None:
    """Gather cells into groups in the pose at hand, with their lengths to the output end."""
    k = y.sheath[i]
    first, last = y.first_cell[i], y.first_cell[i + 1]
    behind = t.first_segment[k] - t.first_guide[k]
    head = int(0)
    for c in range(first, last):
        segment = behind + y.begin[c]
        if y.begins[c] or t.near_body[segment, w] != t.far_body[segment, w]:
            head = int(c)
        y.head[c, w] = head
        y.way[c, w] = ZERO
        y.is_rough[c, w] = False
        y.friction[c, w] = ZERO
    whole = wp.float64(0.0)
    for row in range(t.first_segment[k], t.first_segment[k] + t.guides[k] + 1):
        length = t.length[row, w] / y.segment_divisor[row]
        if y.owner[row] >= 0:
            owner = y.head[y.owner[row], w]
            y.way[owner, w] = y.way[owner, w] + length
        whole += length
    for back in range(last - first):
        c = last - 1 - back
        if y.head[c, w] == c and y.parent[c] >= 0:
            parent = y.head[y.parent[c], w]
            y.way[parent, w] = y.way[parent, w] + y.way[c, w]
    for c in range(first, last):
        y.way[c, w] = y.way[y.head[c, w], w]
    spreads = y.may_spread[i] and t.constraint_force[k, w] != ZERO
    y.whole[i, w] = wp.where(spreads, whole, INF)


@wp.func
def _tail(y: Groups, c: int, last: int, w: int) -> int:
    """Last cell of the group that begins with cell c, of a sheath whose cells end at ``last``."""
    tail = int(c)
    for n in range(c + 1, last):
        if y.head[n, w] == c:
            tail = int(n)
    return tail


@wp.func
def _set_bounds(t: Tendons, y: Groups, c: int, w: int) -> None:
    """Combine the bounds of a group's guides; at rest, those of static friction."""
    i = y.member[c]
    k = y.sheath[i]
    upper, more = wp.float64(1.0), wp.float64(0.0)
    lower, less = wp.float64(1.0), wp.float64(0.0)
    slides = int(y.slides[c, w])
    tail = _tail(y, c, y.first_cell[i + 1], w)
    for guide in range(y.begin[c], y.end[tail]):
        dynamic, static, constant = capstan(t, guide, k, w)
        offset = y.divisor[c] * constant
        ratio = wp.where(slides > 0, dynamic, static)
        upper, more = upper * ratio, more * ratio + offset
        ratio = wp.where(slides < 0, dynamic, static)
        lower, less = lower * ratio, less + offset * lower
    y.upper_ratio[c, w] = wp.float32(upper)
    y.upper_offset[c, w] = wp.float32(more)
    y.lower_ratio[c, w] = wp.float32(lower)
    y.lower_offset[c, w] = wp.float32(less)
    y.set_for[c, w] = wp.int8(slides)


@wp.func
def _slide_on(t: Tendons, y: Groups, c: int, w: int) -> None:
    """Let a group slide or hold as in the step before, with the bounds of that."""
    i, slid = y.member[c], int(0)
    if t.started[y.sheath[i], w]:
        slid = int(y.slid[_tail(y, c, y.first_cell[i + 1], w), w])
    y.slides[c, w] = wp.int8(slid)
    _set_bounds(t, y, c, w)


@wp.func
def _read_input(b: Dynamics, t: Tendons, y: Groups, i: int, w: int) -> bool:
    """Read the force along a tendon, and its damping; return whether the force is finite."""
    k = y.sheath[i]
    tendon = t.tendon[k]
    force = input_force(b, tendon, w) + t.constraint_force[k, w]
    y.force[i, w] = force
    damping = tendon_damping(b, tendon, w)
    if b.implicit:
        for n in range(y.damper.shape[0]):
            a = y.damper[n]
            if a >= 0:
                if b.actuator_trntype[a] == _TENDON and b.actuator_trnid[a][0] == tendon:
                    gear = wp.float64(b.actuator_gear[w % b.actuator_gear.shape[0], a][0])
                    damping += gear * gear * damping_of(b, a, w)
    y.damping[i, w] = damping
    return wp.isfinite(force)


@wp.kernel
def set_up(m: Scene, b: Dynamics, t: Tendons, y: Groups) -> None:
    """Paths, groups and input tensions in the pose at hand; threads (members, worlds)."""
    i, w = wp.tid()
    k, now = y.sheath[i], b.time[w]
    if now < t.trial_time[k, w]:
        reset_sheath(t, k, w)
    elif t.has_trial[k, w] and now > t.trial_time[k, w]:
        commit_member(t, y, b.qvel, b.timestep, i, w)
    t.trial_time[k, w] = now
    trace_path(m, t, sheath_at(t, k, w))
    _gather(t, y, i, w)
    y.active[i, w] = _read_input(b, t, y, i, w)
    t.has_trial[k, w] = y.active[i, w]
    if not y.active[i, w]:
        t.unsolved[w, k] += 1


@wp.kernel
def fill_rows(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Entries of all rows D of a sheath for one dof; threads (entries, worlds)."""
    e, w = wp.tid()
    i, dof = y.dof_member[e], y.dof[e]
    k = y.sheath[i]
    at = e - y.first_dof[i]
    first, last = y.first_cell[i], y.first_cell[i + 1]
    at_input = float(0.0)
    for c in range(first, last):
        y.D[y.row[c] + at, w] = 0.0
    for row in range(t.first_segment[k], t.first_segment[k] + t.guides[k] + 1):
        if t.near_body[row, w] != t.far_body[row, w]:
            slope = span_jacobian(b, t, row, w, dof) / wp.float32(y.segment_divisor[row])
            if y.owner[row] >= 0:
                own = y.row[y.head[y.owner[row], w]] + at
                y.D[own, w] = y.D[own, w] + slope
            else:
                at_input += slope
    for back in range(last - first):
        c = last - 1 - back
        if y.head[c, w] == c:
            slope = y.D[y.row[c] + at, w]
            if y.parent[c] >= 0:
                into = y.row[y.head[y.parent[c], w]] + at
                y.D[into, w] = y.D[into, w] + slope
            else:
                at_input += slope
    y.input_row[e, w] = at_input
    for c in range(first, last):
        share = wp.float32(y.way[c, w] / y.whole[i, w])
        slope = y.D[y.row[c] + at, w] - share * at_input
        y.D[y.row[c] + at, w] = wp.where(wp.abs(slope) < _LEAST_ARM, 0.0, slope)


@wp.func
def _beyond(
    t: Tendons, y: Groups, c: int, tail: int, speed: wp.float64, h: wp.float64, w: int
) -> wp.float64:
    """Speed by which more passes in this step than D q̇: as D changes, and by moved bodies [m/s].

    As D changes only where it held: one that slid is stopped together with others. What bodies
    move without a velocity is not known of guides on geoms, which move themselves, and where the
    stretch is spread.
    """
    curved = wp.float64(0.0)
    if wp.isfinite(y.speed_before[tail, w]):
        curved = speed - wp.float64(y.speed_before[tail, w])
    held = wp.where(int(y.slides[c, w]) == 0, curved, ZERO)
    on_arc = t.is_on_arc[y.begin[c], w] or t.is_on_arc[y.end[tail] - 1, w]
    if on_arc or wp.isfinite(y.whole[y.member[c], w]):
        return held
    drawn = (y.way[c, w] - y.way_before[tail, w]) / h - (speed - HALF * curved)
    return held + wp.where(wp.abs(h * drawn) > _UNEXPLAINED * y.way[c, w], drawn, ZERO)


@wp.kernel
def answer(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Slip of each group; its M̂⁻¹ Dᵀ and mobility if it rubs; threads (cells, worlds)."""
    c, w = wp.tid()
    i = y.member[c]
    if y.head[c, w] != c or not y.active[i, w] or not y.pending[w]:
        return
    k, low, high = y.sheath[i], y.low[i], y.high[i]
    base, row, first = y.solved_row[c], y.row[c], y.first_dof[i]
    _slide_on(t, y, c, w)
    rubs = y.upper_ratio[c, w] > 1.0 or y.lower_ratio[c, w] > 1.0
    y.is_rough[c, w] = rubs or y.upper_offset[c, w] > 0.0
    h, speed = step_of(b, w), _speed(y, c, b.qvel, w)
    if t.started[k, w]:
        tail = _tail(y, c, y.first_cell[i + 1], w)
        speed += _beyond(t, y, c, tail, speed, h, w)
    y.speed[c, w] = wp.float32(speed)
    if not y.is_rough[c, w]:
        return
    for n in range(base, base + high - low):
        y.solved[n, w] = 0.0
    for e in range(first, y.first_dof[i + 1]):
        y.solved[base + y.dof[e] - low, w] = y.D[row + e - first, w]
    respond(b, y, y.solved, base, low, high, w)
    mobility, along = wp.float64(0.0), wp.float64(0.0)
    for e in range(first, y.first_dof[i + 1]):
        moves = wp.float64(y.solved[base + y.dof[e] - low, w])
        mobility += wp.float64(y.D[row + e - first, w]) * moves
        along += wp.float64(y.input_row[e, w]) * moves
    y.mobility[c, w] = wp.float32(mobility)
    y.eases[c, w] = wp.float32(y.way[c, w] / y.whole[i, w] + h * y.damping[i, w] * along)


@wp.func
def _incoming(y: Groups, c: int, w: int) -> wp.float64:
    """Tension in front of a group."""
    if y.parent[c] >= 0:
        return y.tension[y.head[y.parent[c], w], w]
    return y.input[y.member[c], w]


@wp.func
def _lower(y: Groups, c: int, tension: wp.float64, w: int) -> wp.float64:
    offset, ratio = wp.float64(y.lower_offset[c, w]), wp.float64(y.lower_ratio[c, w])
    return wp.max(ZERO, (tension - offset) / ratio)


@wp.func
def _upper(y: Groups, c: int, tension: wp.float64, w: int) -> wp.float64:
    return wp.float64(y.upper_ratio[c, w]) * tension + wp.float64(y.upper_offset[c, w])


@wp.func
def _take_over(y: Groups, c: int, friction: wp.float64, w: int) -> None:
    """Give a group its friction; where the stretch is spread the input bears its share."""
    i = y.member[c]
    share = y.way[c, w] / y.whole[i, w]
    y.constant[i, w] = y.constant[i, w] + share * (friction - y.friction[c, w])
    y.friction[c, w] = friction


@wp.func
def _add_row(y: Groups, c: int, factor: wp.float64, x: wp.array2d[wp.float64], w: int) -> None:
    """Add a multiple of a group's M̂⁻¹ Dᵀ to x."""
    i = y.member[c]
    at = y.solved_row[c] - y.low[i]
    for dof in range(y.low[i], y.high[i]):
        x[dof, w] = x[dof, w] + factor * wp.float64(y.solved[at + dof, w])


@wp.func
def _change(y: Groups, c: int, friction: wp.float64, w: int) -> None:
    """Change the friction of a group, and the acceleration with it."""
    change = friction - y.friction[c, w]
    if change != ZERO:
        _add_row(y, c, -change, y.acceleration, w)
        _take_over(y, c, friction, w)


@wp.func
def _hold(t: Tendons, y: Groups, i: int, w: int) -> None:
    """Let the groups of a sheath hold the tensions that they did, or friction where it spreads."""
    k = y.sheath[i]
    y.constant[i, w] = y.force[i, w]
    incoming = wp.max(ZERO, -y.force[i, w])
    y.input[i, w] = incoming
    unconstrained = y.force[i, w] - t.constraint_force[k, w]
    spreads = wp.isfinite(y.whole[i, w])
    follows = wp.float64(0.0)
    if not spreads:
        before = unconstrained + t.previous_constraint[k, w]
        follows = incoming - wp.max(ZERO, -before)
    last = y.first_cell[i + 1]
    for c in range(y.first_cell[i], last):
        if y.head[c, w] != c:
            continue
        y.friction[c, w] = ZERO
        tension = _incoming(y, c, w)
        held = wp.where(spreads, tension, incoming)
        if t.started[k, w]:
            tail = _tail(y, c, last, w)
            before, before_in = wp.float64(y.before[tail, w]), wp.float64(y.input_before[i, w])
            if y.parent[c] >= 0:
                before_in = wp.float64(y.before[y.parent[c], w])
            held = before + wp.where(y.mobility[c, w] > 0.0, follows, ZERO)
            if spreads:  # the constraint bears what the shares have changed by
                held = tension + before - before_in
                grown = (y.way[c, w] - y.way_before[tail, w]) / y.whole[i, w]
                y.constant[i, w] = y.constant[i, w] - grown * (before - before_in)
        held = wp.min(wp.max(held, _lower(y, c, tension, w)), _upper(y, c, tension, w))
        y.tension[c, w] = held
        if y.is_rough[c, w]:
            _change(y, c, held - tension, w)


@wp.func
def _update_input(y: Groups, i: int, h: wp.float64, w: int) -> None:
    """T_0 of a sheath with the acceleration at hand."""
    force = y.constant[i, w]
    damping = y.damping[i, w]
    if damping != ZERO:
        along = wp.float64(0.0)
        for e in range(y.first_dof[i], y.first_dof[i + 1]):
            along += wp.float64(y.input_row[e, w]) * y.acceleration[y.dof[e], w]
        force -= h * damping * along
    y.input[i, w] = wp.max(ZERO, -force)


@wp.func
def _bounds(y: Groups, c: int, tension: wp.float64, w: int) -> tuple[wp.float64, wp.float64]:
    """Least and largest friction of a group, as T_0 changes with it."""
    eases, back = wp.float64(y.eases[c, w]), ONE / wp.float64(y.lower_ratio[c, w])
    tension += eases * y.friction[c, w]
    rise, fall = wp.float64(y.upper_ratio[c, w]) - ONE, back - ONE
    high = rise * tension + wp.float64(y.upper_offset[c, w])
    high /= wp.max(_LEAST, ONE + eases * rise)
    low = fall * tension - wp.float64(y.lower_offset[c, w]) * back
    low /= wp.max(_LEAST, ONE + eases * fall)
    return wp.max(low, -wp.max(ZERO, tension)), wp.max(ZERO, high)


@wp.func
def _mobility(y: Groups, c: int, w: int) -> wp.float64:
    return wp.float64(y.mobility[c, w])


@wp.func
def _missing(y: Groups, c: int, h: wp.float64, w: int) -> wp.float64:
    """By how much more the slip of a group has to be slowed, 0 if that is rounding [m/s²]."""
    i = y.member[c]
    first, row = y.first_dof[i], y.row[c]
    missing = wp.float64(y.speed[c, w]) / h
    sizes = wp.abs(missing) + _mobility(y, c, w) * wp.abs(y.friction[c, w])
    for e in range(first, y.first_dof[i + 1]):
        part = wp.float64(y.D[row + e - first, w]) * y.acceleration[y.dof[e], w]
        missing += part
        sizes += wp.abs(part)
    return wp.where(wp.abs(missing) > _ROUNDED * sizes, missing, ZERO)


@wp.func
def _move(
    y: Groups, c: int, tension: wp.float64, h: wp.float64, part: wp.float64, w: int
) -> wp.float64:
    """Let a group hold or slide, by a ``part`` of what that changes; return the whole of it."""
    low, high = _bounds(y, c, tension, w)
    before = wp.float64(y.friction[c, w])  # a copy: else it is read where it is used
    friction, missing = wp.float64(before), _missing(y, c, h, w)
    if missing != ZERO:
        if y.mobility[c, w] > 0.0:
            friction += missing / _mobility(y, c, w)
        else:
            friction = wp.where(missing > ZERO, high, low)
    y.slides[c, w] = wp.int8(wp.where(friction > high, 1, wp.where(friction < low, -1, 0)))
    change = wp.min(wp.max(friction, low), high) - before
    _change(y, c, before + part * change, w)
    return wp.abs(change)


@wp.func
def _sweep(y: Groups, h: wp.float64, part: wp.float64, w: int) -> bool:
    """Let every group hold or slide, by a ``part``; return whether any would still change."""
    changed, largest = wp.float64(0.0), wp.float64(0.0)
    for c in range(y.member.shape[0]):
        i = y.member[c]
        if y.head[c, w] != c or not y.active[i, w]:
            continue
        if y.parent[c] < 0:
            _update_input(y, i, h, w)
        tension = _incoming(y, c, w)
        if y.is_rough[c, w]:
            changed = wp.max(changed, _move(y, c, tension, h, part, w))
            if y.parent[c] < 0:
                _update_input(y, i, h, w)
                tension = _incoming(y, c, w)
        y.tension[c, w] = tension + y.friction[c, w]
        largest = wp.max(largest, wp.max(tension, y.tension[c, w]))
    return changed > _CLOSE * largest


@wp.func
def _along(y: Groups, c: int, x: wp.array2d[wp.float64], w: int) -> wp.float64:
    """D x of a group."""
    i = y.member[c]
    first, row = y.first_dof[i], y.row[c]
    total = wp.float64(0.0)
    for e in range(first, y.first_dof[i + 1]):
        total += wp.float64(y.D[row + e - first, w]) * x[y.dof[e], w]
    return total


@wp.func
def _is_free(y: Groups, c: int, w: int) -> bool:
    """Return whether a group holds with less friction than it can have."""
    return y.is_rough[c, w] and int(y.slides[c, w]) == 0 and y.mobility[c, w] > 0.0


@wp.func
def _begin_gradients(y: Groups, h: wp.float64, w: int) -> wp.float64:
    """Set what all groups that hold miss, and go along that; return Σ missing²/mobility."""
    size = wp.float64(0.0)
    for c in range(y.member.shape[0]):
        missing, along = wp.float64(0.0), wp.float64(0.0)
        if _is_free(y, c, w):
            missing = _missing(y, c, h, w)
            along = missing / _mobility(y, c, w)
        y.missing[c, w] = wp.float32(missing)
        y.along[c, w] = wp.float32(along)
        size += missing * along
    return size


@wp.func
def _go_along(y: Groups, nv: int, size: wp.float64, w: int) -> wp.float64:
    """Change the friction of all groups that hold along the conjugate gradient.

    ``size`` is Σ missing²/mobility; returns that afterwards, 0 if a group comes to its bound, or
    nothing is missing.
    """
    cells = y.member.shape[0]
    for dof in range(nv):
        y.gradient[dof, w] = ZERO
    for c in range(cells):
        along = wp.float64(y.along[c, w])
        if along != ZERO:
            _add_row(y, c, along, y.gradient, w)
    curvature, most, free = wp.float64(0.0), wp.float64(0.0), bool(True)
    for c in range(cells):
        if _is_free(y, c, w):
            answers = _along(y, c, y.gradient, w)
            y.answer[c, w] = wp.float32(answers)
            along = wp.float64(y.along[c, w])
            curvature += along * answers
            most += along * along * _mobility(y, c, w)
    if not curvature > _ROUNDED * most:  # groups against each other, which moves nothing
        return ZERO
    step = size / curvature
    for c in range(cells):
        along = wp.float64(y.along[c, w])
        if along != ZERO:
            low, high = _bounds(y, c, y.tension[c, w] - y.friction[c, w], w)
            room = wp.abs(wp.where(along > ZERO, high, low) - y.friction[c, w])
            if step * wp.abs(along) > room:
                step = room / wp.abs(along)
                free = False
    left = wp.float64(0.0)
    for c in range(cells):
        if _is_free(y, c, w):
            _take_over(y, c, y.friction[c, w] + step * wp.float64(y.along[c, w]), w)
            missing = wp.float64(y.missing[c, w]) - step * wp.float64(y.answer[c, w])
            y.missing[c, w] = wp.float32(missing)
            left += missing * missing / _mobility(y, c, w)
    for dof in range(nv):
        y.acceleration[dof, w] = y.acceleration[dof, w] - step * y.gradient[dof, w]
    for c in range(cells):
        if _is_free(y, c, w):
            steepest = y.missing[c, w] / y.mobility[c, w]
            y.along[c, w] = steepest + wp.float32(left / size) * y.along[c, w]
    return wp.where(free, left, ZERO)


@wp.func
def _settle(y: Groups, nv: int, h: wp.float64, rough: int, w: int) -> None:
    """Let every group hold or slide: sweeps, each with conjugate gradients for those that hold.

    Friction that magnifies what comes in can make sweeps swing: they go on in ever smaller parts.
    While tendon slides, a few rounds do where groups are many: the next step corrects what they
    leave.
    """
    rounds = int(_ROUNDS)
    for c in range(y.member.shape[0]):
        if y.is_rough[c, w] and int(y.set_for[c, w]) != 0:
            rounds = wp.min(_ROUNDS, 1 + _VISITS_IN_MOTION // rough)
    part, done = wp.float64(1.0), int(0)
    while done < rounds:
        done += 1
        if done % _UNDAMPED == 0:
            part *= HALF
        if not _sweep(y, h, part, w):
            return
        missing, steps = _begin_gradients(y, h, w), int(nv)
        least = _RESOLVED * missing
        while steps > 0 and missing > least:
            steps -= 1
            missing = _go_along(y, nv, missing, w)


@wp.func
def _release(t: Tendons, y: Groups, w: int) -> bool:
    """Let groups that broke loose slide at μ_d; return whether there are any."""
    released = bool(False)
    for c in range(y.member.shape[0]):
        k = y.sheath[y.member[c]]
        if t.static_friction[w, k] > t.friction[w, k] and y.is_rough[c, w]:
            if int(y.slides[c, w]) != 0:
                upper, lower = wp.float32(y.upper_ratio[c, w]), wp.float32(y.lower_ratio[c, w])
                _set_bounds(t, y, c, w)
                released = released or y.upper_ratio[c, w] != upper
                released = released or y.lower_ratio[c, w] != lower
    return released


@wp.kernel(module="unique", module_options={"max_unroll": 0}, enable_backward=False)
def solve_groups(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Friction of all groups of a world; threads (worlds,)."""
    w = wp.tid()
    if not y.pending[w]:
        return
    h = step_of(b, w)
    rough = int(0)
    for i in range(y.sheath.shape[0]):
        if y.active[i, w]:
            _hold(t, y, i, w)
    for c in range(y.member.shape[0]):
        if y.is_rough[c, w]:
            rough += 1
    tries = wp.where(rough > 0, 1 + 2 * rough, 0)
    while tries > 0:
        tries -= 1
        _settle(y, b.nv, h, rough, w)
        if not _release(t, y, w):
            tries = 0
    for i in range(y.sheath.shape[0]):
        _update_input(y, i, h, w)
    for c in range(y.member.shape[0]):
        if y.head[c, w] == c:
            incoming = _incoming(y, c, w)
            tension = wp.max(ZERO, incoming + y.friction[c, w])
            if y.is_rough[c, w] and not wp.isfinite(y.whole[y.member[c], w]):
                # what the rounds left is no more than it holds
                tension = wp.max(tension, _lower(y, c, incoming, w))
                tension = wp.min(tension, _upper(y, c, incoming, w))
                y.friction[c, w] = tension - incoming
            y.tension[c, w] = tension


@wp.func
def _publish_group(
    t: Tendons, y: Groups, c: int, changes: wp.float64, h: wp.float64, w: int
) -> None:
    """Write the tensions of a group's guides, and the slip of its cells.

    If friction holds, the tension along the group is that share of what it would be at the bound
    which its end has.
    """
    i = y.member[c]
    k = y.sheath[i]
    incoming, friction, at_end = _incoming(y, c, w), y.friction[c, w], wp.float64(y.tension[c, w])
    bound = wp.where(friction > ZERO, _upper(y, c, incoming, w), _lower(y, c, incoming, w))
    part = wp.float64(0.0)
    if bound != incoming:
        part = friction / (bound - incoming)
    slides, set_for = int(y.slides[c, w]), int(y.set_for[c, w])
    passed = h * wp.float64(y.speed[c, w])
    if not y.is_rough[c, w]:
        slides = wp.where(passed > ZERO, 1, -1)
    flows = wp.abs(passed) > _STILL * y.way[c, w] and wp.float64(slides) * passed > ZERO
    extreme = wp.float64(incoming)
    tail = _tail(y, c, y.first_cell[i + 1], w)
    for n in range(c, tail + 1):
        for guide in range(y.begin[n], y.end[n]):
            dynamic, static, constant = capstan(t, guide, k, w)
            offset = y.divisor[c] * constant
            if friction > ZERO:
                extreme = wp.where(set_for > 0, dynamic, static) * extreme + offset
            else:
                ratio = wp.where(set_for < 0, dynamic, static)
                extreme = wp.max(ZERO, (extreme - offset) / ratio)
            tension = incoming + part * (extreme - incoming)
            if guide == y.end[tail] - 1:
                tension = wp.float64(at_end)
            _show(t, y, k, guide + t.first_segment[k] - t.first_guide[k] + 1, tension, changes, w)
            y.tension[n, w] = tension
        y.slides[n, w] = wp.int8(slides)
        y.flows[n, w] = flows


@wp.func
def _show(
    t: Tendons,
    y: Groups,
    k: int,
    row: int,
    tension: wp.float64,
    changes: wp.float64,
    w: int,
) -> None:
    """Show the tension of a segment, times its divisor, and what it adds to MuJoCo Warp's."""
    shown = wp.max(ZERO, tension + changes) / y.segment_divisor[row]
    t.tension_out[w, t.first_shown[k] + row - t.first_segment[k]] = wp.float32(shown)
    t.pull[row, w] = shown - t.given_tension[k, w] / y.segment_divisor[row]


@wp.kernel
def publish(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Tensions of segments, which are kept on trial behind each cell; threads (members, worlds)."""
    i, w = wp.tid()
    k = y.sheath[i]
    first, last = t.first_segment[k], t.first_segment[k] + t.guides[k]
    if not y.active[i, w]:
        for row in range(first, last + 1):
            t.pull[row, w] = ZERO
        return
    incoming = wp.max(ZERO, -y.force[i, w])
    t.given_tension[k, w] = incoming
    changes = wp.float64(0.0)
    if y.damping[i, w] != ZERO:
        changes = incoming - y.input[i, w]
    # behind a pulley, and at the input
    for row in range(first, last + 1):
        owner = y.owner[row]
        tension = y.input[i, w]
        if owner >= 0:
            tension = y.tension[y.head[owner, w], w]
        _show(t, y, k, row, tension, changes, w)
    h = step_of(b, w)
    # from the last group on, as a group's tension is that of those before it
    cells = y.first_cell[i + 1] - y.first_cell[i]
    for back in range(cells):
        c = y.first_cell[i + 1] - 1 - back
        if y.head[c, w] == c:
            _publish_group(t, y, c, changes, h, w)
    t.input_tension[w, k] = t.tension_out[w, t.first_shown[k]]
    t.output_tension[w, k] = t.tension_out[w, t.first_shown[k] + t.guides[k]]


@wp.kernel
def add_friction(t: Tendons, y: Groups, qfrc: wp.array2d[wp.float32]) -> None:
    """Add the forces of friction; threads (dofs, worlds)."""
    dof, w = wp.tid()
    total = wp.float64(0.0)
    for n in range(y.first_entry[dof], y.first_entry[dof + 1]):
        e = y.entry[n]
        i = y.dof_member[e]
        for c in range(y.first_cell[i], y.first_cell[i + 1]):
            friction = y.friction[c, w]
            if friction != ZERO:
                total -= friction * wp.float64(y.D[y.row[c] + e - y.first_dof[i], w])
    y.known[dof, w] = y.known[dof, w] + total
    if total != ZERO:
        qfrc[w, dof] += wp.float32(total)
