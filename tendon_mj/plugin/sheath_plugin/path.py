"""The guides of a tendon's path, and its branches at pulleys."""

from __future__ import annotations

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Model
from tendon_mj.plugin.sheath_plugin.fixed_tendon import is_fixed
from tendon_mj.plugin.sheath_plugin.state import state_at, unpack

PULLEY, SITE, SPHERE = 2, 3, 4  # mjtWrap, which has cylinders besides
SHORTEST = 1e-9  # two points on one spot still have a segment between them [m]


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
