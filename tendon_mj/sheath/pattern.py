"""The flow problem when it is known which guides slide: one scalar equation per sliding run.

Guides that slide in a row tie the tensions of their segments to each other, and the run as a whole
conserves its tendon: one unknown, solved by Newton's method. What comes out says which guides
were wrongly taken to slide or to rest; the next pass corrects them. From the pattern of the step
before this takes one or two passes, each linear in the guides.
"""

from __future__ import annotations

from tendon_mj.sheath.compiled import compiled
from tendon_mj.sheath.segments import held, held_slope, tension_of
from tendon_mj.sheath.sweep import Array, highest, lowest

_NEWTON_STEPS = 30
UNSOLVED = -1


@compiled
def _next(tau: float, slip: float, up: float, down: float, constant: float) -> float:
    """Tension on the output side of a sliding guide."""
    return (tau - constant) / up if slip > 0.0 else down * tau + constant


@compiled
def _run_tension(
    first: int,
    last: int,
    length: Array,
    give: Array,
    offset: Array,
    a: float,
    stored: Array,
    up: Array,
    down: Array,
    constant: Array,
    slip: Array,
    start: float,
) -> float:
    """Tension of segment ``first`` in a run of sliding guides that ends at segment ``last``."""
    total = 0.0
    for k in range(first, last + 1):
        total += stored[k]
    head = start if start > 0.0 else 1e-6
    for _ in range(_NEWTON_STEPS):
        missing, slope, tau, gain = -total, 0.0, head, 1.0
        for k in range(first, last + 1):
            missing += held(length[k], give[k], offset[k], a, tau)
            slope += gain * held_slope(length[k], give[k], offset[k], a, tau)
            if k < last:
                tau = _next(tau, slip[k], up[k], down[k], constant[k])
                gain = gain / up[k] if slip[k] > 0.0 else gain * down[k]
        step = -missing / slope
        head += step
        # the error after a Newton step is about step² times the curvature, which is of order 1
        if step * step <= 1e-17 * head:
            return head
    return -1.0


@compiled
def try_pattern(
    length: Array,
    give: Array,
    offset: Array,
    a: float,
    stored: Array,
    up: Array,
    down: Array,
    constant: Array,
    tension: Array,
    flow: Array,
    slip: Array,
) -> int:
    """Solve with ``slip`` as the pattern, and correct the pattern where the solution denies it.

    Args as in ``sweep``; ``tension`` and ``slip`` hold the guess on entry.

    Returns:
        How many guides changed (0: solved), or UNSOLVED where a tension would not be positive.
    """
    guides = up.shape[0]
    first = 0
    while first <= guides:
        last = first
        while last < guides and slip[last] != 0.0:
            last += 1
        if last == first:
            tension[first] = tension_of(length[first], give[first], offset[first], a, stored[first])
        else:
            tension[first] = _run_tension(
                first, last, length, give, offset, a, stored, up, down, constant, slip, tension[first]
            )
            passed = 0.0
            for k in range(first, last):
                if not tension[k] > 0.0:
                    return UNSOLVED
                passed += held(length[k], give[k], offset[k], a, tension[k]) - stored[k]
                flow[k] = passed
                tension[k + 1] = _next(tension[k], slip[k], up[k], down[k], constant[k])
        if not 0.0 < tension[last] < 1e300:
            return UNSOLVED
        first = last + 1

    changed = 0
    for i in range(guides):
        if slip[i] == 0.0:
            flow[i] = 0.0
            if tension[i] > highest(tension[i + 1], up[i], constant[i]):
                slip[i] = 1.0
                changed += 1
            elif tension[i] < lowest(tension[i + 1], down[i], constant[i]):
                slip[i] = -1.0
                changed += 1
        elif flow[i] * slip[i] < 0.0:
            free = constant[i] == 0.0 and up[i] == 1.0 and down[i] == 1.0
            slip[i] = -slip[i] if free else 0.0
            changed += 0 if free else 1
    return changed
