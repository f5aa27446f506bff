"""Solver of one time step: tensions of the segments and flow of tendon over each guide.

Guide i holds as long as T_{i+1} e^{−μ_s φ} ≤ T_i ≤ T_{i+1} e^{μ_s φ}; once it moves it slides at
μ_d. A guide that breaks loose within the step therefore drops to μ_d and may take others with it:
rounds are repeated until no guide breaks loose any more. Each round only ever frees guides, so
there are at most 2n + 1.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math
from typing import Any

import numba
from numba import carray, from_dtype, types
from numba.core import config

from tendon_mj.compilation import apart, by_symbol, compiled
from tendon_mj.sheath.records import GUIDE, ROUNDING, SEGMENT, Guides, Segments
from tendon_mj.sheath.tension_by_slip_pattern import guess_from_motion, try_pattern
from tendon_mj.sheath.tension_by_sweep import sweep
from tendon_mj.sheath.tension_with_drag import balance_dragged

# Pattern corrections before the sweep, which needs none, takes over: this and one a guide.
_PASSES = 16

# The solvers that most steps do without are called by a symbol. A compiled function contains the
# code of those that it calls, and theirs, and is optimised with it: with these two that took a
# third of the time in which the plugins compile.
_SEGMENTS, _GUIDES = types.CPointer(from_dtype(SEGMENT)), types.CPointer(from_dtype(GUIDE))


@by_symbol("tendon_mj.sweep", types.boolean(_SEGMENTS, _GUIDES, numba.intp, types.boolean))
def _sweep(segments: Any, guides: Any, count: int, given: bool) -> bool:
    return sweep(carray(segments, count + 1), carray(guides, count), given)


@by_symbol("tendon_mj.balance_dragged", types.boolean(_SEGMENTS, _GUIDES, numba.intp))
def _balance_dragged(segments: Any, guides: Any, count: int) -> bool:
    return balance_dragged(carray(segments, count + 1), carray(guides, count))


@compiled
def _rare_sweep(segments: Any, guides: Any, given: bool) -> bool:
    return _sweep(segments.ctypes, guides.ctypes, len(guides), given)


@compiled
def _rare_balance_dragged(segments: Any, guides: Any) -> bool:
    return _balance_dragged(segments.ctypes, guides.ctypes, len(guides))


if config.DISABLE_JIT:  # Python has no symbols
    _rare_sweep, _rare_balance_dragged = sweep, balance_dragged


@apart
def _make_sluggish(segments: Segments, guides: Guides) -> bool:
    """Give the guides a drag that takes no more than rounding from any flow.

    It decides where slack tendon goes, which tension-independent friction leaves open. False where
    there is no tendon.
    """
    total = 0.0
    for j in range(len(segments)):
        total += segments[j].stored
    for i in range(len(guides)):
        guides[i].drag, guides[i].momentum = ROUNDING / total, 0.0
    return total > 0.0


@compiled
def _balance(segments: Segments, guides: Guides, dragged: bool, given: bool) -> bool:
    """Equilibrium for given holding ratios: the known pattern if it serves, else the sweep."""
    if not dragged:
        for _ in range(_PASSES + len(guides)):
            changed = try_pattern(segments, guides, given)
            if changed == 0:
                return True
            if changed < 0:
                break
        if _rare_sweep(segments, guides, given):
            return True
        if given or not _make_sluggish(segments, guides):
            return False
    return _rare_balance_dragged(segments, guides)


@compiled
def _release(guides: Guides) -> bool:
    """Whether a guide broke loose that was at rest; it slides at μ_d from here on."""
    released = False
    for i in range(len(guides)):
        guide = guides[i]
        if guide.slip > 0.0 and guide.input_ratio > guide.dynamic_ratio:
            guide.input_ratio, released = guide.dynamic_ratio, True
        elif guide.slip < 0.0 and guide.output_ratio > guide.dynamic_ratio_back:
            guide.output_ratio, released = guide.dynamic_ratio_back, True
    return released


@compiled
def _is_bounded(segments: Segments, guides: Guides) -> bool:
    """Whether every tension has a bound; where one has none it is inf, and nothing flows.

    A stretch was emptied then: there is no solution.
    """
    bounded = True
    for j in range(len(segments)):
        if not math.isfinite(segments[j].tension):
            segments[j].tension, bounded = math.inf, False
    if not bounded:
        for i in range(len(guides)):
            guides[i].flow, guides[i].slip = 0.0, guides[i].previous_slip
    return bounded


@compiled
def solve_flow(
    segments: Segments, guides: Guides, dragged: bool = False, given: bool = False
) -> bool:
    """Solve for tensions and flows such that every guide either holds or slides by its law.

    Args:
        segments, guides: see ``records``; ``tension``, ``flow`` and ``slip`` receive the result.
        dragged: whether ``drag`` > 0 and ``momentum`` count; not where the input tension is given.
        given: whether the tension of the first segment is, which may then have any length.

    Returns:
        False where the result is not the solution. The flow is then the best approximation, or 0
        without any.
    """
    stiction = False
    for i in range(len(guides)):
        guide = guides[i]
        slip = guide.previous_slip
        guide.input_ratio = guide.dynamic_ratio if slip > 0.0 else guide.static_ratio
        guide.output_ratio = guide.dynamic_ratio_back if slip < 0.0 else guide.static_ratio_back
        free = guide.constant_friction == 0.0 and guide.static_ratio == 1.0
        guide.slip = 1.0 if free else slip
        stiction |= guide.static_ratio != guide.dynamic_ratio
    if given:
        guess_from_motion(segments, guides)
    solved = False
    for _ in range(1 + 2 * len(guides)):
        solved = _balance(segments, guides, dragged, given)
        if not (stiction and solved and _release(guides)):
            break
    return _is_bounded(segments, guides) and solved
