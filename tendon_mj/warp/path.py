"""Lengths, bends and spans of a tendon over sites and around spheres and cylinders.

The same as `tendon_mj.plugin.sheath_plugin.wraps`. Where the input is the last
site, elements and points come in the reverse of their order.

Sites and geoms are placed anew, in double precision: a stretch between two of one body would else
change by the rounding of their places to single precision. Tangent points are MuJoCo Warp's; a geom
and a straight line share their error.
"""

import warp as wp

from tendon_mj.warp.tendons import INEXTENSIBLE, ZERO, Sheath, Tendons

wp.set_module_options({"enable_backward": False})

_PULLEY, _SITE, _SPHERE = wp.constant(2), wp.constant(3), wp.constant(4)  # mjtWrap
_SHORTEST = wp.constant(wp.float64(1e-9))  # [m]
_WHOLE = wp.constant(wp.float64(6.283185307179586))


@wp.struct
class Scene:
    """The tendons of a model and their geoms, from which the path follows."""

    # of the model
    tendon_adr: wp.array[wp.int32]
    tendon_num: wp.array[wp.int32]
    wrap_type: wp.array[wp.int32]
    wrap_objid: wp.array[wp.int32]
    site_bodyid: wp.array[wp.int32]
    site_pos: wp.array2d[wp.vec3]
    geom_bodyid: wp.array[wp.int32]
    geom_pos: wp.array2d[wp.vec3]
    geom_size: wp.array2d[wp.vec3]
    # of the worlds
    xpos: wp.array2d[wp.vec3]
    xmat: wp.array2d[wp.mat33]
    geom_xmat: wp.array2d[wp.mat33]
    ten_wrapadr: wp.array2d[wp.int32]
    ten_wrapnum: wp.array2d[wp.int32]
    wrap_obj: wp.array2d[wp.vec2i]
    wrap_xpos: wp.array2d[wp.spatial_vector]


@wp.func
def _tangent(m: Scene, w: int, at: int) -> wp.vec3d:
    """A point of MuJoCo's path, two of which it keeps in a row."""
    pair = m.wrap_xpos[w, at // 2]
    if at % 2 == 0:
        return wp.vec3d(wp.spatial_top(pair))
    return wp.vec3d(wp.spatial_bottom(pair))


@wp.func
def _place(m: Scene, w: int, body: int, at: wp.vec3) -> wp.vec3d:
    """A point of a body in the world [m]."""
    return wp.vec3d(m.xpos[w, body]) + wp.mat33d(m.xmat[w, body]) * wp.vec3d(at)


@wp.func
def _site(m: Scene, w: int, element: int) -> wp.vec3d:
    """The site that is an element of a path, in the world [m]."""
    site = m.wrap_objid[element]
    return _place(m, w, m.site_bodyid[site], m.site_pos[w % m.site_pos.shape[0], site])


@wp.func
def _angle(a: wp.vec3d, b: wp.vec3d) -> wp.float64:
    """Angle between two directions [rad]; 0 if one of them is none."""
    return wp.atan2(wp.length(wp.cross(a, b)), wp.dot(a, b))


@wp.func
def _turn_in_sense(y: wp.float64, x: wp.float64) -> wp.float64:
    """Angle of the direction (x, y) from 0 to 2π [rad]; one short of it by rounding is none."""
    if y >= ZERO:
        return wp.atan2(y, x)
    turn = _WHOLE - wp.atan2(-y, x)
    return wp.where(turn < _WHOLE - wp.float64(1e-6), turn, ZERO)


@wp.func
def _arc(
    kind: int, radius: wp.float64, p: wp.vec3d, q: wp.vec3d, u: wp.vec3d
) -> tuple[wp.float64, wp.float64]:
    """Length [m] and turn [rad] of an arc from p to q that begins in the direction u, locally."""
    if kind == _SPHERE:
        along = u - wp.dot(u, p) / wp.dot(p, p) * p
        turn = _turn_in_sense(wp.dot(q, along) * wp.length(p), wp.dot(q, p) * wp.length(along))
        return radius * turn, turn
    sense = wp.where(p[0] * u[1] - p[1] * u[0] >= ZERO, wp.float64(1.0), wp.float64(-1.0))
    turn = _turn_in_sense(sense * (p[0] * q[1] - p[1] * q[0]), p[0] * q[0] + p[1] * q[1])
    around = radius * turn
    rise = q[2] - p[2]
    length = wp.sqrt(around * around + rise * rise)
    return length, wp.where(length > ZERO, turn * around / length, ZERO)


@wp.func
def _along(now: wp.vec3d, before: wp.vec3d, u: wp.vec3d) -> wp.float64:
    """Way of a tangent point along the drum in the direction u [m]; positive to the output."""
    return wp.dot(now - before, u) / wp.max(_SHORTEST, wp.length(u))


@wp.func
def _is_flipped(t: Tendons, arc: int, w: int, p: wp.vec3d, q: wp.vec3d) -> bool:
    """Return whether the tendon changed sides, so that an arc from p to q turns the other way."""
    before, behind = t.near_tangent[arc, w], t.far_tangent[arc, w]
    is_short = wp.dot(p, q) > ZERO and wp.dot(before, behind) > ZERO
    return is_short and wp.dot(wp.cross(p, q), wp.cross(before, behind)) < ZERO


@wp.func
def _set_span(
    t: Tendons,
    s: Sheath,
    j: int,
    rest: wp.float64,
    start: wp.vec3d,
    goes: wp.vec3d,
    near: int,
    far: int,
) -> None:
    """Set segment j: a straight span from ``start`` by the vector ``goes``, and ``rest`` beside it.

    It pulls the bodies ``near`` and ``far`` together.
    """
    row, w = s.segment + j, s.world
    t.length[row, w] = wp.max(_SHORTEST, wp.length(goes) + rest)
    t.start[row, w] = wp.vec3(start)
    t.along[row, w] = wp.vec3(wp.normalize(goes))
    t.near_body[row, w] = near
    t.far_body[row, w] = far


@wp.func
def _set_no_span(t: Tendons, s: Sheath, j: int, length: wp.float64) -> None:
    """Set the length of segment j, which pulls no two bodies together."""
    t.length[s.segment + j, s.world] = wp.max(_SHORTEST, length)
    t.near_body[s.segment + j, s.world] = 0
    t.far_body[s.segment + j, s.world] = 0


@wp.func
def _wrap(
    m: Scene,
    t: Tendons,
    s: Sheath,
    element: int,
    here: wp.vec3d,
    first: wp.vec3d,
    second: wp.vec3d,
    ahead: wp.vec3d,
    arc: int,
    j: int,
) -> tuple[wp.float64, bool]:
    """Fill in guides and inner segments on a geom that is a path's ``element``, from segment j on.

    Points are the site before it, both tangent points, and the site behind it. An inextensible
    tendon has no ``arc``, −1: it does not matter where on it a guide is.

    Returns:
        Length of the arc before the first guide [m], and behind the last; whether the guides are
        where they have not slid to.
    """
    w = s.world
    count = t.arc_guides[s.index]
    geom = m.wrap_objid[element]
    into = wp.transpose(wp.mat33d(m.geom_xmat[w, geom]))
    centre = _place(m, w, m.geom_bodyid[geom], m.geom_pos[w % m.geom_pos.shape[0], geom])
    radius = wp.float64(m.geom_size[w % m.geom_size.shape[0], geom][0])
    p, q = into * (first - centre), into * (second - centre)
    u = into * (first - here)
    v = into * (ahead - second)
    length = wp.float64(0.0)
    turn = wp.float64(0.0)
    if wp.length(q - p) <= wp.float64(1e-6) * radius:
        turn = _angle(u, v)  # inside the geom, or just touching
    else:
        length, turn = _arc(m.wrap_type[element], radius, p, q, u)
    there = wp.float64(0.0)
    back = wp.float64(0.0)
    jumped = bool(False)
    if arc >= 0:
        jumped = not t.touched[arc, w]
        if jumped:
            turn = wp.float64(0.0)  # its guides move to it without friction
        elif _is_flipped(t, arc, w, p, q):
            jumped = True
        else:
            there = _along(p, t.near_tangent[arc, w], u)
            back = _along(q, t.far_tangent[arc, w], v)
        t.trial_touches[arc, w] = True
        t.trial_near[arc, w] = p
        t.trial_far[arc, w] = q
    for k in range(count):
        guide = s.guide + j + k
        t.angle[guide, w] = turn / wp.float64(count)
        t.is_on_arc[guide, w] = True
        if arc >= 0:
            part = (wp.float64(k) + wp.float64(0.5)) / wp.float64(count)
            moved = (wp.float64(1.0) - part) * there + part * back
            source = s.segment + j + k + wp.where(moved > ZERO, 1, 0)
            t.shift[guide, w] = moved / (wp.float64(1.0) + t.before[source, w])
        if k > 0:
            _set_no_span(t, s, j + k, length / wp.float64(count))
    return wp.float64(0.5) * length / wp.float64(count), jumped


@wp.func
def _pass_by(t: Tendons, s: Sheath, arc: int, j: int) -> None:
    """Fill in the guides of a geom that the tendon does not touch, from segment j on."""
    w = s.world
    if arc >= 0:
        t.trial_touches[arc, w] = False
    for k in range(t.arc_guides[s.index]):
        t.angle[s.guide + j + k, w] = wp.float64(0.0)
        if arc >= 0:
            t.shift[s.guide + j + k, w] = wp.float64(0.0)
        t.is_on_arc[s.guide + j + k, w] = True
        _set_no_span(t, s, j + k + 1, ZERO)


@wp.func
def _hand_over(t: Tendons, s: Sheath, j: int) -> None:
    """Move the guides of a geom along the tendon to where they now are."""
    w = s.world
    moved = wp.float64(0.0)
    for k in range(j, j + t.arc_guides[s.index]):
        row = s.segment + k
        moved += t.length[row, w] / (wp.float64(1.0) + t.before[row, w])
        moved -= t.stored[row, w]
        t.shift[s.guide + k, w] = moved


@wp.func
def trace_path(m: Scene, t: Tendons, s: Sheath) -> None:
    """Bring lengths, bends and spans of a sheath's tendon up to date."""
    w = s.world
    tendon = t.tendon[s.index]
    step = t.step[s.index]
    element = int(m.tendon_adr[tendon])
    end = element + m.tendon_num[tendon] - 1
    at = int(m.ten_wrapadr[w, tendon])
    if step < 0:
        end = m.tendon_adr[tendon]
        element = end + m.tendon_num[tendon] - 1
        at += m.ten_wrapnum[w, tendon] - 1
    j = int(0)
    arc = int(t.first_arc[s.index])
    if t.kind[s.index] == INEXTENSIBLE:
        arc = int(-1)
    bends = bool(False)  # whether the site at hand is a guide: guide j − 1
    came = wp.vec3d()  # direction of the last span that has one
    here = _site(m, w, element)
    for _ in range(t.inner_guides[s.index]):
        _set_no_span(t, s, j, ZERO)
        t.angle[s.guide + j, w] = wp.float64(0.0)
        j += 1
    while step * (end - element) > 0:
        if m.wrap_type[element + step] == _PULLEY:  # a branch ends at the site at hand
            j += 1
            element += 2 * step
            at += 2 * step
            here = _site(m, w, element)
            came = wp.vec3d()
            bends = bool(False)
            continue
        near = m.site_bodyid[m.wrap_objid[element]]
        over_site = m.wrap_type[element + step] == _SITE
        behind = element + wp.where(over_site, step, 2 * step)  # the next site
        far = m.site_bodyid[m.wrap_objid[behind]]
        geom = m.wrap_objid[element + step]
        touches = not over_site and m.wrap_obj[w, (at + step) // 2][(at + step) % 2] == geom
        ahead = _site(m, w, behind)
        first = wp.vec3d(ahead)
        if touches:
            first = _tangent(m, w, at + step)
        goes = first - here
        if bends:
            t.angle[s.guide + j - 1, w] = _angle(came, goes)
        if wp.length(goes) > ZERO:
            came = goes
        if over_site:
            _set_span(t, s, j, ZERO, here, goes, near, far)
            at += step
        else:
            count = t.arc_guides[s.index]
            begins = int(j)
            jumped = bool(False)
            if touches:
                drum = m.geom_bodyid[geom]
                second = _tangent(m, w, at + 2 * step)
                half, moved = _wrap(m, t, s, element + step, here, first, second, ahead, arc, j)
                jumped = moved
                _set_span(t, s, j, half, here, goes, near, drum)
                j += count
                left = ahead - second
                _set_span(t, s, j, half, second, left, drum, far)
                if wp.length(left) > ZERO:
                    came = left
                at += 3 * step
            else:
                if arc >= 0:
                    jumped = t.touched[arc, w]
                _pass_by(t, s, arc, j)
                straight = wp.float64(0.5) * wp.length(goes)
                _set_span(t, s, j, -straight, here, goes, near, far)
                j += count
                _set_no_span(t, s, j, straight)
                at += step
            if jumped and t.started[s.index, w]:
                _hand_over(t, s, begins)
            if arc >= 0:
                arc += 1
        element = int(behind)
        here = wp.vec3d(ahead)
        bends = element != end
        if bends:
            bends = m.wrap_type[element + step] != _PULLEY
        if bends:
            j += 1
