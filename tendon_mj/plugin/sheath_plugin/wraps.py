"""The path of a tendon that wraps around geoms, branches at pulleys, or is pulled at its last site.

MuJoCo gives the points of the path. A site within it bends the tendon and is a guide. A geom that
the tendon touches turns it by φ along an arc of length L. In the frame of the geom the arc begins
in the direction u at the point r₁ from its centre or axis, and ends at r₂; with θ the angle from r₁
to r₂ in the sense of u,

    sphere     L = r θ,                φ = θ
    cylinder   L = √((r θ)² + Δz²),    φ = θ · r θ / L        (a helix)

Its n guides share the arc: they sit at (k + ½)/n of it. A geom that the tendon does not touch keeps
its guides, in the middle of the straight line, where they turn nothing.

The path is followed from the input end on. If that is its last site, elements and points come in
the reverse of their order: segments, guides and arcs are then those of the tendon drawn the other
way round.

If a wrap comes, goes or changes sides its guides move along the tendon without friction, and
each stretch keeps its strain. Tendon rubs on the drum, not on the place where it leaves the drum. A
tangent point that moves along the drum by δ takes tendon from one side to the other without any
slip, δ/(1 + ε) of it: that is the guide's ``shift``.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.sheath_plugin.path import PULLEY, SHORTEST, SITE, SPHERE
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.plugin.sheath_plugin.vectors import (
    Vector,
    angle_between,
    arctangent,
    cross,
    dot,
    into,
    minus,
    norm,
    vector,
)
from tendon_mj.sheath import Arc, Arcs, Guides, Segments
from tendon_mj.typing import FloatArray

_WHOLE = 6.283185307179586
_ROUNDED = 1e-6  # a turn that is short of a whole one by less is none [rad]


@compiled
def _turn_in_sense(y: float, x: float) -> float:
    """Angle of the direction (x, y) from 0 to 2π [rad]."""
    if y >= 0.0:
        return arctangent(y, x)
    turn = _WHOLE - arctangent(-y, x)
    return turn if turn < _WHOLE - _ROUNDED else 0.0


@compiled
def _arc(kind: int, radius: float, p: Vector, q: Vector, u: Vector) -> tuple[float, float]:
    """Length [m] and turn [rad] of an arc from p to q that begins in the direction u, locally."""
    if kind == SPHERE:
        inward = dot(u, p) / dot(p, p)
        along = (u[0] - inward * p[0], u[1] - inward * p[1], u[2] - inward * p[2])
        turn = _turn_in_sense(dot(q, along) * norm(p), dot(q, p) * norm(along))
        return radius * turn, turn
    sense = 1.0 if p[0] * u[1] - p[1] * u[0] >= 0.0 else -1.0
    turn = _turn_in_sense(sense * (p[0] * q[1] - p[1] * q[0]), p[0] * q[0] + p[1] * q[1])
    around, rise = radius * turn, q[2] - p[2]
    length = math.sqrt(around * around + rise * rise)
    return length, turn * around / length if length > 0.0 else 0.0


_ONE_POINT = 1e-9  # distance of two tangent points over the radius at which they are one


@compiled
def _shift(now: Vector, before: Vector, u: Vector) -> float:
    """Way of a tangent point along the drum in the direction u [m]; positive to the output."""
    return dot(minus(now, before), u) / max(SHORTEST, norm(u))


@compiled
def _is_flipped(arc: Arc, p: Vector, q: Vector) -> bool:
    """Return whether the tendon changed sides, so that an arc from p to q turns the other way."""
    before, behind = (arc.x1, arc.y1, arc.z1), (arc.x2, arc.y2, arc.z2)
    is_short = dot(p, q) > 0.0 and dot(before, behind) > 0.0  # of a long one it is not known
    return is_short and dot(cross(p, q), cross(before, behind)) < 0.0


@compiled
def _set_span(
    segments: Segments, j: int, at: int, step: int, near: int, far: int, divisor: float
) -> None:
    """Store the straight span of segment j, from point ``at`` of the path to ``at`` + ``step``."""
    segment = segments[j]
    segment.divisor = divisor
    if step > 0:
        segment.point, segment.near_body, segment.far_body = at, near, far
    else:
        segment.point, segment.near_body, segment.far_body = at - 1, far, near


@compiled
def _store(path: FloatArray, k: int, points: FloatArray, at: int) -> bool:
    """Keep a point of the path; return whether it has moved since the last call."""
    point = vector(points, at)
    if vector(path, k) == point:
        return False
    path[3 * k], path[3 * k + 1], path[3 * k + 2] = point
    return True


@compiled
def _contact(
    m: Model, d: Data, element: int, before: Vector, first: Vector, second: Vector, behind: Vector
) -> tuple[float, float, Vector, Vector, Vector, Vector]:
    """Arc on a geom between two tangent points, and the spans before and behind it.

    Returns:
        Length [m] and turn [rad] of the arc; in the frame of the geom, the tangent points and the
        directions in which the tendon comes and goes.
    """
    geom = m.wrap_objid[element]
    frame, centre = d.geom_xmat[geom], vector(d.geom_xpos[geom], 0)
    radius = m.geom_size[geom, 0]
    p, q = into(frame, minus(first, centre)), into(frame, minus(second, centre))
    u, v = into(frame, before), into(frame, behind)
    if norm(minus(q, p)) <= _ONE_POINT * radius:  # inside the geom, or just touching
        return 0.0, angle_between(before, behind), p, q, u, v
    length, turn = _arc(m.wrap_type[element], radius, p, q, u)
    return length, turn, p, q, u, v


@compiled
def _hand_over(state: State, segments: Segments, guides: Guides, j: int, count: int) -> None:
    """Move guides ``j`` and the following along the tendon to where they now are."""
    laid = moved = 0.0
    if state.driven == 0.0:
        laid = state.laid_pretension / state.law.axial_stiffness  # where the mounts are at rest
    for k in range(j, j + count):
        segment = segments[k]
        tau = segment.previous_tension
        held = (segment.length - segment.support_compliance * (tau - laid)) / (1.0 + tau)
        moved += held - segment.stored
        guides[k].shift = moved


@compiled
def _over_geom(
    m: Model,
    d: Data,
    element: int,
    points: FloatArray,
    at: int,
    step: int,
    arc: Arc,
    state: State,
    segments: Segments,
    guides: Guides,
    path: FloatArray,
    j: int,
    divisor: float,
    stage: bool,
) -> tuple[Vector, int]:
    """Fill in the guides of a geom, and the segments around them, from segment j on.

    Returns:
        Direction in which the tendon goes on, and the points that it has passed.
    """
    bodies, objects = m.site_bodyid, m.wrap_objid
    geom, count = objects[element], int(state.arc_guides)
    near = bodies[objects[element - step]]
    far = bodies[objects[element + step]]
    start = d.ten_wrapadr[int(state.tendon)]
    goes = minus(vector(points, at + step), vector(points, at))
    behind, passed = goes, 1
    if d.wrap_obj.flat[at + step] == geom:
        drum, passed = m.geom_bodyid[geom], 3
        first, second = vector(points, at + step), vector(points, at + 2 * step)
        behind = minus(vector(points, at + 3 * step), second)
        length, turn, p, q, u, v = _contact(m, d, element, goes, first, second, behind)
        there = back = 0.0
        jumped = arc.touches == 0.0 or _is_flipped(arc, p, q)
        if not jumped:
            there = _shift(p, (arc.x1, arc.y1, arc.z1), u)
            back = _shift(q, (arc.x2, arc.y2, arc.z2), v)
        elif arc.touches == 0.0 and state.finished != 0.0 and state.inextensible == 0.0:
            turn = 0.0  # its guides move to it without friction
        if not stage:
            arc.trial_touches = 1.0
            arc.trial_x1, arc.trial_y1, arc.trial_z1 = p
            arc.trial_x2, arc.trial_y2, arc.trial_z2 = q
        for k in range(count):
            guide, part = guides[j + k], (k + 0.5) / count
            guide.is_on_arc, guide.angle = 1.0, turn / count
            moved = (1.0 - part) * there + part * back
            source = segments[j + k + 1] if moved > 0.0 else segments[j + k]
            guide.shift = moved / (1.0 + source.previous_tension)
            if k > 0:
                segments[j + k].length = max(SHORTEST, length / count)
                segments[j + k].point = -1.0
            _store(path, j + k + 1, points, at + (step if 2 * k < count else 2 * step))
        half = 0.5 * length / count
        segments[j].length = max(SHORTEST, norm(goes) + half)
        _set_span(segments, j, at - start, step, near, drum, divisor)
        segments[j + count].length = max(SHORTEST, norm(behind) + half)
        _set_span(segments, j + count, at - start + 2 * step, step, drum, far, divisor)
    else:
        jumped = arc.touches != 0.0
        if not stage:
            arc.trial_touches = 0.0
        for k in range(j, j + count):
            guides[k].angle, guides[k].shift, guides[k].is_on_arc = 0.0, 0.0, 1.0
            segments[k + 1].point, segments[k + 1].length = -1.0, SHORTEST
            _store(path, k + 1, points, at)
        half = 0.5 * norm(goes)
        segments[j].length = segments[j + count].length = max(SHORTEST, half)
        _set_span(segments, j, at - start, step, near, far, divisor)
        segments[j + count].divisor = divisor
    if jumped and state.started != 0.0:
        _hand_over(state, segments, guides, j, count)
    return behind, passed


@compiled
def trace_path(
    m: Model,
    d: Data,
    state: State,
    segments: Segments,
    guides: Guides,
    arcs: Arcs,
    path: FloatArray,
    stage: bool,
) -> None:
    """Lengths, bends and spans of a tendon on any path, and the points of its guides.

    ``path`` receives the coordinates of each guide and end [m]; between sites that have not moved
    since the last call lengths and bends are as they were. ``stage``: this is an inner stage of the
    integrator, which must leave no trace.
    """
    tendon = int(state.tendon)
    step = 1 if state.input_at_last == 0.0 else -1
    element = m.tendon_adr[tendon]
    end = element + m.tendon_num[tendon] - 1
    kinds, objects = m.wrap_type, m.wrap_objid
    bodies = m.site_bodyid
    start = d.ten_wrapadr[tendon]
    at = start
    if step < 0:
        element, end = end, element
        at = start + d.ten_wrapnum[tendon] - 1
    points = d.wrap_xpos.flat
    j, divisor, arc = 0, 1.0, 0
    bends = False  # whether the site at hand is a guide: guide j − 1
    came = (0.0, 0.0, 0.0)  # direction of the last span of the branch that has one
    fresh = state.started == 0.0
    here = _store(path, 0, points, at) or fresh  # whether the point at hand has moved
    turned = True  # whether the direction may have changed in which the tendon comes to it
    for _ in range(int(state.inner_guides)):
        segments[j].length, segments[j].point = SHORTEST, -1.0
        segments[j].divisor = divisor
        guides[j].angle = 0.0
        j += 1
        here = _store(path, j, points, at) or fresh
    while step * (end - element) > 0:
        kind = kinds[element + step]
        if kind == PULLEY:
            # the site at hand ended its branch; the next branch begins at the site that follows
            # (a path with branches is followed as it is drawn, see `compiled_checks`)
            divisor = m.wrap_prm[element + step]
            guides[j].angle = 0.0
            j += 1
            element += 2 * step
            at += 2 * step
            came, bends = (0.0, 0.0, 0.0), False
            here, turned = _store(path, j, points, at) or fresh, True
            continue
        goes = minus(vector(points, at + step), vector(points, at))
        ahead = kind != SITE or _store(path, j + 1, points, at + step) or fresh
        moved = here or ahead
        if bends and (moved or turned):
            guides[j - 1].angle = angle_between(came, goes)
        is_spot = goes == (0.0, 0.0, 0.0)
        came, turned = came if is_spot else goes, moved or (turned and is_spot)
        if kind == SITE:
            near = bodies[objects[element]]
            far = bodies[objects[element + step]]
            if moved:
                segments[j].length = max(SHORTEST, norm(goes))
            _set_span(segments, j, at - start, step, near, far, divisor)
            element += step
            at += step
            here = ahead
        else:
            behind, passed = _over_geom(
                m,
                d,
                element + step,
                points,
                at,
                step,
                arcs[arc],
                state,
                segments,
                guides,
                path,
                j,
                divisor,
                stage,
            )
            came = behind if behind != (0.0, 0.0, 0.0) else came
            j += int(state.arc_guides)
            at += passed * step
            element += 2 * step
            arc += 1
            here, turned = _store(path, j + 1, points, at) or fresh, True
        bends = element != end and kinds[element + step] != PULLEY
        if bends:
            j += 1
