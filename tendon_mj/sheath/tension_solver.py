"""Solver of one time step: tensions of the segments and flow of tendon over each guide.

Guide i holds as long as T_{i+1} e^{−μ_s φ} ≤ T_i ≤ T_{i+1} e^{μ_s φ}; once it moves it slides at
μ_d. A guide that breaks loose within the step therefore drops to μ_d and may take others with it:
rounds are repeated until no guide breaks loose any more. Each round only ever frees guides, so
there are at most 2n + 1.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.native import Array, compiled, entry
from tendon_mj.sheath.records import GUIDE, SEGMENT, Guides, Segments
from tendon_mj.sheath.tension_by_breakpoints import balance, find_slip, lies_slack
from tendon_mj.sheath.tension_by_slip_pattern import follow_pattern, guess_from_motion
from tendon_mj.sheath.tension_with_drag import balance_dragged

_NEAR = 1e-3  # error of a tension over the largest, with which the slip is as a rule right


@compiled
def _balance(segments: Segments, guides: Guides, given: bool) -> bool:
    """Equilibrium for given holding ratios, without drag.

    The slip of the last step is tried first. If it has changed, breakpoints find it, and
    followed again it gives the tensions to the last digit. That it does not if tendon lies
    slack.
    """
    if follow_pattern(segments, guides, given):
        return True
    if not given and lies_slack(segments, guides):
        return True
    if not find_slip(segments, guides, given, _NEAR):
        return False
    if follow_pattern(segments, guides, given):
        return True
    return balance(segments, guides, given)


@compiled
def _release(guides: Guides) -> bool:
    """Return whether a guide broke loose that was at rest; it slides at μ_d from here on."""
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
    """Return whether every tension has a bound; if one has none it is inf, and nothing flows.

    A stretch was emptied then, so that there is no solution, or the rounds did not settle.
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
        dragged: whether ``drag`` > 0 and ``momentum`` count; not if the input tension is given.
        given: whether the tension of the first segment is, which may then have any length.

    Returns:
        False if the result is not the solution. The flow is then the best approximation, or 0
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
        solved = balance_dragged(segments, guides) if dragged else _balance(segments, guides, given)
        if not (stiction and solved and _release(guides)):
            break
    return _is_bounded(segments, guides) and solved


_segments_at, _guides_at = Array(SEGMENT), Array(GUIDE)


@entry("tendon_mj_solve_flow", "bool(ptr, ptr, i64, bool, bool)")
def _solve_flow_at(segments: int, guides: int, n: int, dragged: bool, given: bool) -> bool:
    """``solve_flow`` of records at two addresses."""
    return solve_flow(_segments_at(segments, n + 1), _guides_at(guides, n), dragged, given)
