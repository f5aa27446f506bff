"""One time step of a tendon in its sheath: how much of it flows over each guide.

Guide i holds as long as T_{i+1} e^{−μ_s φ} ≤ T_i ≤ T_{i+1} e^{μ_s φ}; once it moves it slides at
μ_d. A guide that breaks loose within the step therefore drops to μ_d and may take others with it:
rounds are repeated until no guide breaks loose any more. Each round only ever frees guides, so
there are at most 2n + 1.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.sheath.drag import balance_dragged
from tendon_mj.sheath.pattern import try_pattern
from tendon_mj.sheath.sweep import sweep
from tendon_mj.sheath.tables import (
    BACK_DYNAMIC,
    BACK_STATIC,
    CONSTANT,
    DOWN,
    DYNAMIC,
    FLOW,
    SLIP,
    STATIC,
    TENSION,
    UP,
    WAS,
    Table,
)

# Pattern corrections before the sweep, which needs none, takes over: this and one a guide.
_PASSES = 16


@compiled
def _balance(segments: Table, guides: Table, dragged: bool) -> bool:
    """Equilibrium for given holding ratios: the known pattern if it serves, else the sweep."""
    if dragged:
        return balance_dragged(segments, guides)
    for _ in range(_PASSES + guides.shape[1]):
        changed = try_pattern(segments, guides)
        if changed == 0:
            return True
        if changed < 0:
            break
    return sweep(segments, guides)


@compiled
def _loosen(guides: Table) -> bool:
    """Whether a guide broke loose that was at rest; it slides at μ_d from here on."""
    loosened = False
    for i in range(guides.shape[1]):
        if guides[SLIP, i] > 0.0 and guides[UP, i] > guides[DYNAMIC, i]:
            guides[UP, i], loosened = guides[DYNAMIC, i], True
        elif guides[SLIP, i] < 0.0 and guides[DOWN, i] > guides[BACK_DYNAMIC, i]:
            guides[DOWN, i], loosened = guides[BACK_DYNAMIC, i], True
    return loosened


@compiled
def settle(segments: Table, guides: Table, dragged: bool = False) -> bool:
    """Let the tendon flow until every guide either holds or slides by its law.

    Args:
        segments, guides: see ``tables``; the rows TENSION, FLOW and SLIP receive the result.
        dragged: whether the rows DRAG > 0 and PUSH count.

    Returns:
        False where the result is not the solution. The flow is then the best that was found, or 0
        where there is none.
    """
    stiction = False
    for i in range(guides.shape[1]):
        was = guides[WAS, i]
        guides[UP, i] = guides[DYNAMIC, i] if was > 0.0 else guides[STATIC, i]
        guides[DOWN, i] = guides[BACK_DYNAMIC, i] if was < 0.0 else guides[BACK_STATIC, i]
        free = guides[CONSTANT, i] == 0.0 and guides[STATIC, i] == 1.0
        guides[SLIP, i] = 1.0 if free else was
        stiction |= guides[STATIC, i] != guides[DYNAMIC, i]
    solved = False
    for _ in range(1 + 2 * guides.shape[1]):
        solved = _balance(segments, guides, dragged)
        if not (stiction and solved and _loosen(guides)):
            break
    if not math.isfinite(segments[TENSION, segments.shape[1] - 1]):
        for i in range(guides.shape[1]):
            guides[FLOW, i], guides[SLIP, i] = 0.0, guides[WAS, i]
    return solved
