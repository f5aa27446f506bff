"""Vectors of three numbers, as tuples that the compiler keeps in registers."""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.arctangent import arctangent
from tendon_mj.typing import FloatArray

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
    """Angle between two directions [rad]; 0 where one of them is none."""
    return arctangent(norm(cross(a, b)), dot(a, b))
