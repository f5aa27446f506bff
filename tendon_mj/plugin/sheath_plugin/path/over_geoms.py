"""The path of a tendon that wraps around geoms, branches at pulleys, or is pulled at its last site.

MuJoCo gives the points of the path. A site within it bends the tendon and is a guide. A geom that
the tendon touches turns it by φ along an arc of length L, which its n guides share: they sit at
(k + ½)/n of the arc. A geom that the tendon does not touch keeps its guides, in the middle of the
straight line, where they turn nothing.

The path is followed from the input end on. Where that is its last site, elements and points come in
the reverse of their order: segments, guides and arcs are then those of the tendon drawn the other
way round.

Where a wrap comes, goes or changes sides its guides move along the tendon without friction, and
each stretch keeps its strain.

Tendon rubs on the drum, not on the place where it leaves the drum. A tangent point that moves along
the drum by δ takes tendon from one side to the other without any slip, δ/(1 + ε) of it: that is the
guide's ``shift``.
"""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import coordinates, double, integer, pointer
from tendon_mj.plugin.abi.vectors import (
    Vector,
    angle_between,
    cross,
    dot,
    into,
    minus,
    norm,
    vector,
)
from tendon_mj.plugin.sheath_plugin.path.arc import PULLEY, SITE, arc_of
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.sheath import Arc, Arcs, Guides, Segments
from tendon_mj.typing import FloatArray

_SHORTEST = 1e-9  # [m]
_ONE_POINT = 1e-9  # distance of two tangent points over the radius at which they are one


@compiled
def _shift(now: Vector, before: Vector, u: Vector) -> float:
    """Way of a tangent point along the drum in the direction u [m]; positive to the output."""
    return dot(minus(now, before), u) / max(_SHORTEST, norm(u))


@compiled
def _is_flipped(arc: Arc, p: Vector, q: Vector) -> bool:
    """Whether the tendon has changed sides, so that an arc from p to q turns the other way."""
    before, behind = (arc.x1, arc.y1, arc.z1), (arc.x2, arc.y2, arc.z2)
    is_short = dot(p, q) > 0.0 and dot(before, behind) > 0.0  # of a long one it is not known
    return is_short and dot(cross(p, q), cross(before, behind)) < 0.0


@compiled
def _span(
    segments: Segments, j: int, at: int, step: int, near: int, far: int, divisor: float
) -> None:
    """Note the straight span of segment j, from point ``at`` of the path to ``at`` + ``step``."""
    segment = segments[j]
    segment.divisor = divisor
    if step > 0:
        segment.point, segment.near_body, segment.far_body = at, near, far
    else:
        segment.point, segment.near_body, segment.far_body = at - 1, far, near


@compiled
def _wrap(
    layout: Layout,
    m: int,
    d: int,
    geom: int,
    kind: int,
    points: FloatArray,
    at: int,
    step: int,
    arc: Arc,
    state: State,
    segments: Segments,
    guides: Guides,
    j: int,
    stage: bool,
) -> tuple[float, bool]:
    """Fill in the guides and segments on a geom that the tendon touches, from segment j on.

    Returns:
        Length of the arc before the first guide [m], and behind the last; whether the guides are
        where they have not slid to.
    """
    frame = coordinates(pointer(d + layout.d_geom_xmat) + 72 * geom)
    centre = vector(coordinates(pointer(d + layout.d_geom_xpos) + 24 * geom), 0)
    radius = double(pointer(m + layout.m_geom_size), 3 * geom)
    first, second = vector(points, at + step), vector(points, at + 2 * step)
    before = minus(first, vector(points, at))
    behind = minus(vector(points, at + 3 * step), second)
    length = turn = 0.0
    p, q = into(frame, minus(first, centre)), into(frame, minus(second, centre))
    u, v = into(frame, before), into(frame, behind)
    if norm(minus(q, p)) <= _ONE_POINT * radius:
        turn = angle_between(before, behind)  # inside the geom, or just touching
    else:
        length, turn = arc_of(kind, radius, p, q, u)
    count = int(state.arc_guides)
    there = back = 0.0
    jumped = arc.touches == 0.0 or _is_flipped(arc, p, q)
    if not jumped:
        there = _shift(p, (arc.x1, arc.y1, arc.z1), u)
        back = _shift(q, (arc.x2, arc.y2, arc.z2), v)
    elif arc.touches == 0.0:
        turn = 0.0  # its guides move to it without friction
    if not stage:
        arc.trial_touches = 1.0
        arc.trial_x1, arc.trial_y1, arc.trial_z1 = p
        arc.trial_x2, arc.trial_y2, arc.trial_z2 = q
    for k in range(count):
        guide = guides[j + k]
        guide.is_on_arc = 1.0
        guide.angle = turn / count
        part = (k + 0.5) / count
        moved = (1.0 - part) * there + part * back
        source = segments[j + k + 1] if moved > 0.0 else segments[j + k]
        guide.shift = moved / (1.0 + source.previous_tension)
        if k > 0:
            segments[j + k].length = max(_SHORTEST, length / count)
            segments[j + k].point = -1.0
    return 0.5 * length / count, jumped


@compiled
def _pass_by(
    state: State, segments: Segments, guides: Guides, j: int, arc: Arc, stage: bool
) -> None:
    """Fill in the guides of a geom that the tendon does not touch, from segment j on."""
    if not stage:
        arc.trial_touches = 0.0
    for k in range(int(state.arc_guides)):
        guides[j + k].angle, guides[j + k].shift, guides[j + k].is_on_arc = 0.0, 0.0, 1.0
        segments[j + k + 1].point = -1.0
        segments[j + k + 1].length = _SHORTEST


@compiled
def _hand_over(segments: Segments, guides: Guides, j: int, count: int) -> None:
    """Move guides ``j`` and the following along the tendon to where they now are."""
    moved = 0.0
    for k in range(j, j + count):
        segment = segments[k]
        tau = segment.previous_tension
        held = (segment.length - segment.support_compliance * tau) / (1.0 + tau)
        moved += held - segment.stored
        guides[k].shift = moved


@compiled
def trace_path(
    layout: Layout,
    m: int,
    d: int,
    state: State,
    segments: Segments,
    guides: Guides,
    arcs: Arcs,
    path: FloatArray,
    stage: bool,
) -> None:
    """Lengths, bends and spans of a tendon on any path, and the points of its guides.

    Args:
        layout, m, d: where things are, `mjModel`, `mjData`.
        state, segments, guides, arcs: of the sheath.
        path: receives a point for each guide and end, coordinates in a row [m].
        stage: whether this is an inner stage of the integrator, which must leave no trace.
    """
    tendon = int(state.tendon)
    step = 1 if state.input_at_last == 0.0 else -1
    element = integer(pointer(m + layout.m_tendon_adr), tendon)
    end = element + integer(pointer(m + layout.m_tendon_num), tendon) - 1
    kinds, objects = pointer(m + layout.m_wrap_type), pointer(m + layout.m_wrap_objid)
    bodies, of_geoms = pointer(m + layout.m_site_bodyid), pointer(m + layout.m_geom_bodyid)
    start = integer(pointer(d + layout.d_ten_wrapadr), tendon)
    at = start
    if step < 0:
        element, end = end, element
        at = start + integer(pointer(d + layout.d_ten_wrapnum), tendon) - 1
    touched = pointer(d + layout.d_wrap_obj)
    points = coordinates(pointer(d + layout.d_wrap_xpos))
    j, divisor, arc = 0, 1.0, 0
    bends = False  # whether the site at hand is a guide: guide j − 1
    came = (0.0, 0.0, 0.0)  # direction of the last span of the branch that has one
    _note(path, 0, points, at)
    for _ in range(int(state.inner_guides)):
        segments[j].length, segments[j].point = _SHORTEST, -1.0
        segments[j].divisor = divisor
        guides[j].angle = 0.0
        j += 1
        _note(path, j, points, at)
    while step * (end - element) > 0:
        kind = integer(kinds, element + step)
        near = integer(bodies, integer(objects, element))
        if kind == PULLEY:
            # the site at hand ended its branch; the next branch begins at the site that follows
            # (a path with branches is followed as it is drawn, see `checks`)
            divisor = double(pointer(m + layout.m_wrap_prm), element + step)
            guides[j].angle = 0.0
            j += 1
            element += 2 * step
            at += 2 * step
            came, bends = (0.0, 0.0, 0.0), False
            _note(path, j, points, at)
            continue
        goes = minus(vector(points, at + step), vector(points, at))
        if bends:
            guides[j - 1].angle = angle_between(came, goes)
        came = goes if goes != (0.0, 0.0, 0.0) else came
        if kind == SITE:
            far = integer(bodies, integer(objects, element + step))
            segments[j].length = max(_SHORTEST, norm(goes))
            _span(segments, j, at - start, step, near, far, divisor)
            element += step
            at += step
        else:
            geom, count, begins = integer(objects, element + step), int(state.arc_guides), j
            far = integer(bodies, integer(objects, element + 2 * step))
            if integer(touched, at + step) == geom:
                drum = integer(of_geoms, geom)
                half, jumped = _wrap(
                    layout,
                    m,
                    d,
                    geom,
                    kind,
                    points,
                    at,
                    step,
                    arcs[arc],
                    state,
                    segments,
                    guides,
                    j,
                    stage,
                )
                for k in range(count):
                    _note(path, j + k + 1, points, at + (step if 2 * k < count else 2 * step))
                segments[j].length = max(_SHORTEST, norm(goes) + half)
                _span(segments, j, at - start, step, near, drum, divisor)
                j += count
                left = minus(vector(points, at + 3 * step), vector(points, at + 2 * step))
                segments[j].length = max(_SHORTEST, norm(left) + half)
                _span(segments, j, at - start + 2 * step, step, drum, far, divisor)
                came = left if left != (0.0, 0.0, 0.0) else came
                at += 3 * step
            else:
                jumped = arcs[arc].touches != 0.0
                _pass_by(state, segments, guides, j, arcs[arc], stage)
                for k in range(count):
                    _note(path, j + k + 1, points, at)
                half = 0.5 * norm(goes)
                segments[j].length = max(_SHORTEST, half)
                _span(segments, j, at - start, step, near, far, divisor)
                j += count
                segments[j].length = max(_SHORTEST, half)
                segments[j].divisor = divisor
                at += step
            if jumped and state.started != 0.0:
                _hand_over(segments, guides, begins, count)
            arc += 1
            element += 2 * step
        _note(path, j + 1, points, at)
        bends = element != end and integer(kinds, element + step) != PULLEY
        if bends:
            j += 1


@compiled
def _note(path: FloatArray, k: int, points: FloatArray, at: int) -> None:
    """Keep a point of the path for those who look at it."""
    path[3 * k], path[3 * k + 1], path[3 * k + 2] = vector(points, at)
