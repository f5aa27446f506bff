"""The flow problem when it is known which guides slide: one scalar equation per sliding run.

Guides that slide in a row tie the tensions of their segments to each other, and the run as a whole
conserves its tendon: one unknown, solved by Halley's method. What comes out says which guides
were wrongly taken to slide or to rest; the next pass corrects them. From the pattern of the step
before this takes one or two passes, each linear in the guides.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.sheath.segments import held, tension_of
from tendon_mj.sheath.sweep import highest, lowest
from tendon_mj.sheath.tables import (
    CONSTANT,
    DOWN,
    FLOW,
    LENGTH,
    ROUNDING,
    SLIP,
    STORED,
    TENSION,
    UP,
    Table,
)

_STEPS = 30
_VERGE = 8 * ROUNDING
UNSOLVED = -1


@compiled
def _solve_run(segments: Table, guides: Table, first: int, last: int) -> bool:
    """Tensions and flows of a run of sliding guides, from segment ``first`` to segment ``last``."""
    head = segments[TENSION, first]
    if not head > 0.0:
        head = 1e-6
    for _ in range(_STEPS):
        missing, slope, curvature, tau, gain = 0.0, 0.0, 0.0, head, 1.0
        for k in range(first, last + 1):
            holds, falls, curves = held(segments, k, tau)
            missing += holds - segments[STORED, k]
            slope += gain * falls
            curvature += gain * gain * curves
            if k < last:
                if guides[SLIP, k] > 0.0:
                    ratio = 1.0 / guides[UP, k]
                    tau = (tau - guides[CONSTANT, k]) * ratio
                else:
                    ratio = guides[DOWN, k]
                    tau = ratio * tau + guides[CONSTANT, k]
                gain *= ratio
        step = -missing / slope
        step /= 1.0 + 0.5 * step * curvature / slope
        head += step
        if abs(step * step * step) <= 1e-17:  # of this order is what Halley's method leaves
            return _finish_run(segments, guides, first, last, head)
    return False


@compiled
def _finish_run(segments: Table, guides: Table, first: int, last: int, tau: float) -> bool:
    """Tensions and flows of the run once the tension of its first segment is known."""
    passed = 0.0
    for k in range(first, last + 1):
        if not tau > 0.0:
            return False
        segments[TENSION, k] = tau
        if k < last:
            passed += held(segments, k, tau)[0] - segments[STORED, k]
            guides[FLOW, k] = passed
            if guides[SLIP, k] > 0.0:
                tau = (tau - guides[CONSTANT, k]) * (1.0 / guides[UP, k])
            else:
                tau = guides[DOWN, k] * tau + guides[CONSTANT, k]
    return True


@compiled
def _correct(segments: Table, guides: Table) -> int:
    """Count and correct the guides whose slip the solution denies by more than rounding.

    A tendon at rest on the verge of sliding would otherwise change its mind at every step.
    """
    changed = 0
    for i in range(guides.shape[1]):
        if guides[SLIP, i] == 0.0:
            guides[FLOW, i] = 0.0
            left, right = segments[TENSION, i], segments[TENSION, i + 1]
            if left > highest(guides, i, right) + _VERGE:
                guides[SLIP, i] = 1.0
                changed += 1
            elif left < lowest(guides, i, right) - _VERGE:
                guides[SLIP, i] = -1.0
                changed += 1
        elif guides[FLOW, i] * guides[SLIP, i] < 0.0:
            if guides[CONSTANT, i] == 0.0 and guides[UP, i] == 1.0 and guides[DOWN, i] == 1.0:
                guides[SLIP, i] = -guides[SLIP, i]  # nothing rubs: either direction will do
            elif abs(guides[FLOW, i]) < _VERGE * segments[LENGTH, i]:
                guides[FLOW, i] = 0.0
            else:
                guides[SLIP, i] = 0.0
                changed += 1
    return changed


@compiled
def try_pattern(segments: Table, guides: Table) -> int:
    """Solve with the guides' slip as the pattern, and correct it where the solution denies it.

    Returns:
        How many guides changed (0: solved), or UNSOLVED where a tension would not be positive.
    """
    last_guide = guides.shape[1]
    first = 0
    while first <= last_guide:
        last = first
        while last < last_guide and guides[SLIP, last] != 0.0:
            last += 1
        if last == first:
            segments[TENSION, first] = tension_of(segments, first)
        elif not _solve_run(segments, guides, first, last):
            return UNSOLVED
        if not 0.0 < segments[TENSION, last] < 1e300:
            return UNSOLVED
        first = last + 1
    return _correct(segments, guides)
