"""The branches of a tendon that pulleys divide, and the geoms on its path."""

from __future__ import annotations

from tendon_mj.compilation import apart, compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import double, integer, pointer
from tendon_mj.plugin.sheath_plugin.path.arc import PULLEY, SITE
from tendon_mj.plugin.sheath_plugin.state import state_at, unpack


@compiled
def count_wraps(layout: Layout, m: int, tendon: int) -> tuple[int, int]:
    """How many geoms and how many pulleys a tendon has on its path."""
    kinds = pointer(m + layout.m_wrap_type)
    first = integer(pointer(m + layout.m_tendon_adr), tendon)
    geoms = pulleys = 0
    for element in range(first, first + integer(pointer(m + layout.m_tendon_num), tendon)):
        kind = integer(kinds, element)
        pulleys += kind == PULLEY
        geoms += kind not in (PULLEY, SITE)
    return geoms, pulleys


@apart
def mark_branches(layout: Layout, m: int, address: int) -> None:
    """Mark the ends of branches, the divisor of each segment, and which branch feeds which.

    A branch that begins at the site where an earlier one ended is fed by that.
    """
    state = state_at(address)
    segments, guides, _ = unpack(address)
    kinds = pointer(m + layout.m_wrap_type)
    first = integer(pointer(m + layout.m_tendon_adr), int(state.tendon))
    count = integer(pointer(m + layout.m_tendon_num), int(state.tendon))
    for j in range(len(segments)):
        segments[j].divisor, segments[j].point = 1.0, -1.0
    for i in range(len(guides)):
        guides[i].is_pulley, guides[i].fed_by = 0.0, -1.0
    j, divisor = int(state.inner_guides), 1.0
    for element in range(first, first + count):
        kind = integer(kinds, element)
        if kind == PULLEY:
            divisor = double(pointer(m + layout.m_wrap_prm), element)
            guides[j].is_pulley = 1.0
            guides[j].fed_by = _fed_by(layout, m, address, element + 1)
            j += 1
        elif kind != SITE:
            for _ in range(int(state.arc_guides)):
                segments[j].divisor = divisor
                j += 1
        elif element > first and integer(kinds, element - 1) != PULLEY:
            last = element == first + count - 1 or integer(kinds, element + 1) == PULLEY
            segments[j].divisor = divisor
            if not last:
                j += 1
    segments[len(guides)].divisor = divisor


@apart
def _fed_by(layout: Layout, m: int, address: int, begins: int) -> int:
    """Last segment of the branch that ends at the site where another begins, −1 without one.

    Args:
        layout, m: where things are, `mjModel`.
        address: of the sheath's state.
        begins: element of the path with which the branch begins.
    """
    state = state_at(address)
    kinds, objects = pointer(m + layout.m_wrap_type), pointer(m + layout.m_wrap_objid)
    element = integer(pointer(m + layout.m_tendon_adr), int(state.tendon))
    site, j = integer(objects, begins), int(state.inner_guides)
    found = -1
    while element < begins - 1:
        kind = integer(kinds, element)
        ends = kind == SITE and integer(kinds, element + 1) == PULLEY
        if ends and found < 0 and integer(objects, element) == site:
            found = j
        if kind == PULLEY:
            j += 1
            element += 1  # the site that begins a branch is no guide
        elif kind != SITE:
            j += int(state.arc_guides)
        elif element > integer(pointer(m + layout.m_tendon_adr), int(state.tendon)) and not ends:
            j += 1
        element += 1
    return found
