"""The path of a tendon over sites alone: segment lengths and bends from its points."""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.arctangent import arctangent
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import integer, pointer
from tendon_mj.sheath import Guides, Segments
from tendon_mj.typing import FloatArray

_SHORTEST = 1e-9  # two sites on one spot still have a segment between them [m]


@compiled
def _bend(a: FloatArray, i: int) -> float:
    """Angle by which the path turns at point ``i`` [rad], exact for small and large angles.

    Where several points lie on one spot the turn counts once, at the last of them.
    """
    vx, vy, vz = a[3 * i + 3] - a[3 * i], a[3 * i + 4] - a[3 * i + 1], a[3 * i + 5] - a[3 * i + 2]
    if vx == 0.0 and vy == 0.0 and vz == 0.0:
        return 0.0
    ux, uy, uz = 0.0, 0.0, 0.0
    k = i
    while k > 0 and ux == 0.0 and uy == 0.0 and uz == 0.0:
        k -= 1
        ux, uy, uz = a[3 * i] - a[3 * k], a[3 * i + 1] - a[3 * k + 1], a[3 * i + 2] - a[3 * k + 2]
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return arctangent(math.sqrt(cx * cx + cy * cy + cz * cz), ux * vx + uy * vy + uz * vz)


@compiled
def _moved(points: FloatArray, path: FloatArray, i: int) -> bool:
    """Whether point ``i`` is not where it was; ``path`` is updated."""
    k = 3 * i
    if points[k] == path[k] and points[k + 1] == path[k + 1] and points[k + 2] == path[k + 2]:
        return False
    path[k], path[k + 1], path[k + 2] = points[k], points[k + 1], points[k + 2]
    return True


@compiled
def update_path(
    points: FloatArray, path: FloatArray, segments: Segments, guides: Guides, refresh: bool
) -> None:
    """Bring lengths and bends up to date with the points; what did not move is not recomputed.

    Args:
        points: where the n+2 points are now, coordinates in a row [m].
        path: where they were when lengths and angles were computed; updated.
        segments, guides: their lengths and angles are updated.
        refresh: compute everything anew.
    """
    near = _moved(points, path, 0) or refresh
    before = True  # whether the segment before the point at hand moved
    for j in range(len(segments)):
        far = _moved(points, path, j + 1) or refresh
        moved = near or far
        near = far
        if moved:
            dx = points[3 * j + 3] - points[3 * j]
            dy = points[3 * j + 4] - points[3 * j + 1]
            dz = points[3 * j + 5] - points[3 * j + 2]
            segments[j].length = max(_SHORTEST, math.sqrt(dx * dx + dy * dy + dz * dz))
        if j > 0 and (moved or before):
            guides[j - 1].angle = _bend(points, j)
        # behind a segment without length the bend depends on what lies before it
        before = moved or (before and segments[j].length == _SHORTEST)


@compiled
def update_spans(layout: Layout, m: int, tendon: int, segments: Segments) -> None:
    """Note which bodies each segment pulls together."""
    first = integer(pointer(m + layout.m_tendon_adr), tendon)
    sites, bodies = pointer(m + layout.m_wrap_objid), pointer(m + layout.m_site_bodyid)
    for j in range(len(segments)):
        segment = segments[j]
        segment.point, segment.divisor = j, 1.0
        segment.near_body = integer(bodies, integer(sites, first + j))
        segment.far_body = integer(bodies, integer(sites, first + j + 1))
