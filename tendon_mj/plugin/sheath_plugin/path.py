"""The path of a tendon: vectors and angles, its guides, branches at pulleys."""

from __future__ import annotations

import math

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Model
from tendon_mj.plugin.sheath_plugin.fixed_tendon import is_fixed
from tendon_mj.plugin.sheath_plugin.state import state_at, unpack
from tendon_mj.typing import FloatArray

PULLEY, SITE, SPHERE = 2, 3, 4  # mjtWrap, which has cylinders besides
SHORTEST = 1e-9  # two points on one spot still have a segment between them [m]

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


@compiled
def count_wraps(m: Model, tendon: int) -> tuple[int, int]:
    """How many geoms and how many pulleys a tendon has on its path."""
    first = m.tendon_adr[tendon]
    geoms = pulleys = 0
    for element in range(first, first + m.tendon_num[tendon]):
        kind = m.wrap_type[element]
        pulleys += kind == PULLEY
        geoms += kind >= SPHERE
    return geoms, pulleys


@compiled
def count_guides(
    m: Model, tendon: int, arc_guides: float, inner_guides: float
) -> tuple[float, int, int]:
    """How many guides a tendon's path has, and how many geoms and pulleys are on it."""
    arcs, pulleys = count_wraps(m, tendon)
    sites = 0  # within branches
    if not is_fixed(m, tendon):
        sites = m.tendon_num[tendon] - arcs - pulleys - 2 * (1 + pulleys)
    return inner_guides + sites + arcs * arc_guides + pulleys, arcs, pulleys


NOT_GIVEN = -1  # a count


@compiled
def capacity(m: Model, guides: int, arc_guides: int, inner_guides: int) -> tuple[int, int]:
    """Guides and arcs to allocate memory for, by counts that may be `NOT_GIVEN`.

    MuJoCo asks before the model has the paths of its tendons, so without ``guides`` all points of
    the model that other tendons need not have are counted.
    """
    points = max(0, m.nwrap - m.ntendon - 1)
    if guides != NOT_GIVEN:
        return guides, guides // arc_guides if arc_guides != NOT_GIVEN else 0
    return points * max(1, arc_guides) + inner_guides, points


@apart
def mark_branches(m: Model, address: int) -> None:
    """Mark the ends of branches, the divisor of each segment, and which branch feeds which.

    A branch that begins at the site where an earlier one ended is fed by that.
    """
    state = state_at(address)
    segments, guides, _ = unpack(address)
    kinds = m.wrap_type
    first = m.tendon_adr[int(state.tendon)]
    count = m.tendon_num[int(state.tendon)]
    count = count if state.fixed == 0.0 else 0
    for j in range(len(segments)):
        segments[j].divisor, segments[j].point = 1.0, -1.0
    for i in range(len(guides)):
        guides[i].is_pulley, guides[i].fed_by = 0.0, -1.0
    j, divisor = int(state.inner_guides), 1.0
    for element in range(first, first + count):
        kind = kinds[element]
        if kind == PULLEY:
            divisor = m.wrap_prm[element]
            guides[j].is_pulley = 1.0
            guides[j].fed_by = _fed_by(m, address, element + 1)
            j += 1
        elif kind != SITE:
            for _ in range(int(state.arc_guides)):
                segments[j].divisor = divisor
                j += 1
        elif element > first and kinds[element - 1] != PULLEY:
            last = element == first + count - 1 or kinds[element + 1] == PULLEY
            segments[j].divisor = divisor
            if not last:
                j += 1
    segments[len(guides)].divisor = divisor


@apart
def _fed_by(m: Model, address: int, begins: int) -> int:
    """Last segment of the branch that ends at the site ``begins`` of another, −1 without one."""
    state = state_at(address)
    kinds, objects = m.wrap_type, m.wrap_objid
    element = m.tendon_adr[int(state.tendon)]
    site, j = objects[begins], int(state.inner_guides)
    last = -1
    while element < begins - 1:
        kind = kinds[element]
        ends = kind == SITE and kinds[element + 1] == PULLEY
        if ends and last < 0 and objects[element] == site:
            last = j
        if kind == PULLEY:
            j += 1
            element += 1  # the site that begins a branch is not a guide
        elif kind != SITE:
            j += int(state.arc_guides)
        elif element > m.tendon_adr[int(state.tendon)] and not ends:
            j += 1
        element += 1
    return last
