"""Length and turn of a tendon's arc on a sphere or cylinder.

In the frame of the geom the arc begins in the direction u at the point r₁ from its centre or axis,
and ends at r₂; with θ the angle from r₁ to r₂ in the sense of u,

    sphere     L = r θ,                φ = θ
    cylinder   L = √((r θ)² + Δz²),    φ = θ · r θ / L        (a helix)
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.arctangent import arctangent
from tendon_mj.plugin.abi.vectors import Vector, dot, norm

PULLEY, SITE, SPHERE, CYLINDER = 2, 3, 4, 5  # mjtWrap
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
def arc_of(kind: int, radius: float, p: Vector, q: Vector, u: Vector) -> tuple[float, float]:
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
