"""The tendon's path: segment lengths and bend angles from the points it runs through."""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.engine.arctangent import arctangent
from tendon_mj.sheath.compiled import compiled

_SHORTEST = 1e-9  # two sites on one spot still have a segment between them [m]


@compiled
def _turn(ux: float, uy: float, uz: float, vx: float, vy: float, vz: float) -> float:
    """Angle between two vectors [rad], exact for small and large angles, 0 if one is 0."""
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return arctangent(math.sqrt(cx * cx + cy * cy + cz * cz), ux * vx + uy * vy + uz * vz)


@compiled
def _moved(points: Any, path: Any, k: int) -> bool:
    """Whether the point with coordinates from ``k`` on is not where it was; remembers where."""
    if points[k] == path[k] and points[k + 1] == path[k + 1] and points[k + 2] == path[k + 2]:
        return False
    path[k], path[k + 1], path[k + 2] = points[k], points[k + 1], points[k + 2]
    return True


@compiled
def follow_path(points: Any, path: Any, length: Any, angle: Any, refresh: bool) -> None:
    """Bring lengths and bends up to date with the points; what did not move is not recomputed.

    Where several points lie on one spot the turn counts once, at the last of them.

    Args:
        points: (3(n+2),) where the points are now [m].
        path: (3(n+2),) where they were when lengths and angles were computed; updated.
        length: (n+1,) segment lengths [m]; updated.
        angle: (n,) bends [rad]; updated.
        refresh: compute everything anew.
    """
    ux, uy, uz = 0.0, 0.0, 0.0  # the last segment that has a length
    before = True  # whether what the bend at hand has before it moved
    near = _moved(points, path, 0)
    for j in range(length.shape[0]):
        k = 3 * j
        far = _moved(points, path, k + 3)
        moved = near or far or refresh
        near = far
        vx = points[k + 3] - points[k]
        vy = points[k + 4] - points[k + 1]
        vz = points[k + 5] - points[k + 2]
        if moved:
            length[j] = max(_SHORTEST, math.sqrt(vx * vx + vy * vy + vz * vz))
        if j > 0 and (moved or before):
            angle[j - 1] = _turn(ux, uy, uz, vx, vy, vz)
        # behind a segment without length the bend depends on what lies before it
        before = moved or (before and length[j] == _SHORTEST)
        if vx != 0.0 or vy != 0.0 or vz != 0.0:
            ux, uy, uz = vx, vy, vz
