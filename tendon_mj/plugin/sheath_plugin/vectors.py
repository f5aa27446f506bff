"""Vectors and angles in space, in compiled code."""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.typing import FloatArray

_NARROW = 0.41421356237309503  # tan(π/8)
_WIDE = 2.414213562373095  # tan(3π/8)
_EIGHTH, _QUARTER, _HALF = 0.7853981633974483, 1.5707963267948966, 3.141592653589793  # of a turn
# their rounding errors
_EIGHTH_REST, _QUARTER_REST, _HALF_REST = (
    3.061616997868383e-17,
    6.123233995736766e-17,
    1.2246467991473532e-16,
)


@compiled
def _series(z: float) -> float:
    """P(z) on 0 ≤ z ≤ tan²(π/8), in parts that the processor computes at the same time."""
    z2 = z * z
    z4 = z2 * z2
    low = (0.3333333333333333 - 0.1999999999999552 * z) + z2 * (
        0.14285714284666542 - 0.11111111015256361 * z
    )
    middle = (0.09090904578123903 - 0.07692183190826087 * z) + z2 * (
        0.06664511447381948 - 0.0585814891280221 * z
    )
    high = (0.0508544973794026 - 0.03923165829558719 * z) + z2 * 0.019176887119062257
    return low + z4 * (middle + z4 * high)


@compiled
def arctangent(y: float, x: float) -> float:
    """Angle of the direction (x, y) with y ≥ 0, from 0 to π [rad]; 0 if both are 0.

    A call of the C library's atan2 for every bend that moves is a seventh of a sheath's cost in a
    step. Of two lengths the greater divides, after a rotation by π/4 where that leaves less:

        atan2(y, x) = π/4 k + atan t,   |t| ≤ tan(π/8)

    and atan t = t − t³ P(t²), with P through the values at the 11 Chebyshev points of that range.
    That is off by 7e-18 of the angle, less than rounding.
    """
    across = abs(x)
    if y <= _NARROW * across:
        top, bottom, base, rest = y, across, 0.0, 0.0
    elif y <= _WIDE * across:
        top, bottom, base, rest = y - across, y + across, _EIGHTH, _EIGHTH_REST
    else:
        top, bottom, base, rest = -across, y, _QUARTER, _QUARTER_REST
    if bottom == 0.0:
        return 0.0
    t = top / bottom
    z = t * t
    angle = base + (t - (t * z * _series(z) - rest))
    return angle if x >= 0.0 else _HALF - (angle - _HALF_REST)


Vector = tuple[float, float, float]


@compiled
def vector(points: FloatArray, k: int) -> Vector:
    """The point number ``k`` of a row of coordinates."""
    return points[3 * k], points[3 * k + 1], points[3 * k + 2]


@compiled
def minus(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def norm(a: Vector) -> float:
    """|a|."""
    return math.sqrt(dot(a, a))


@compiled
def into(frame: FloatArray, v: Vector) -> Vector:
    """A vector in the coordinates of a frame."""
    return (
        frame[0] * v[0] + frame[3] * v[1] + frame[6] * v[2],
        frame[1] * v[0] + frame[4] * v[1] + frame[7] * v[2],
        frame[2] * v[0] + frame[5] * v[1] + frame[8] * v[2],
    )


@compiled
def angle_between(a: Vector, b: Vector) -> float:
    """Angle between two directions [rad]; 0 if one of them is none."""
    return arctangent(norm(cross(a, b)), dot(a, b))
