"""The flow problem where sliding itself takes tension: viscous friction and the tendon's mass.

The guide's law then holds with τ_i − b − D f in the place of what it held before,

    slides to the input   τ_i = R_in τ_{i+1} + C + D f + b        f > 0
    slides to the output  τ_{i+1} = R_out τ_i + C − D f − b       f < 0

and rests where both hold as ≥ with f = 0; R_in is ``input_ratio``, R_out ``output_ratio``. The
flows are solved for with the slip of each guide as given (``flow_by_newton``), which is corrected
as long as the solution contradicts it.

These corrections may cycle. With F⁺ and F⁻ for what the two laws lack, right side minus left in the
first and left minus right in the second, the flows are the root of max(F⁻, min(F⁺, f)), and flow
over a guide only ever makes its neighbours flow more. So slip to the input is corrected alone until
it settles, then that to the output once, and so on: policy iteration for two obstacles (Bokanowski,
Maroso and Zidani, SIAM J. Numer. Anal. 47(4), 3001–3026, 2009).

They begin with the flows without drag, which are next to the solution where drag is little, or else
at rest. A segment that the solution all but empties is on its tangent at first: those begin later
then.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

import numpy as np

from tendon_mj.compilation import apart, compiled
from tendon_mj.sheath.flow_by_newton import (
    TOLERANCE,
    law,
    solve_pattern,
    spare,
    stored_after,
    tension_at,
)
from tendon_mj.sheath.records import Guides, Segments
from tendon_mj.sheath.tension_by_slip_pattern import is_frictionless
from tendon_mj.sheath.tension_by_sweep import sweep

_PASSES = 16  # pattern corrections, and one a guide
_LEAST = 1e-2  # part of a segment's length, held by which its tension goes on along the tangent
_TANGENTS = 11  # down to 1e-12, each a tenth of the one before


@compiled
def _is_beyond(
    guides: Guides, i: int, slip: float, left: float, right: float, tolerance: float
) -> bool:
    """Whether the tensions beside guide i, which rests, drive it to ``slip``."""
    p, q, c = law(guides, i, slip)
    return slip * (p * left - q * right - c) > tolerance * (p + q)


@compiled
def _yield(segments: Segments, guides: Guides, i: int) -> float:
    """Flow over guide i per unit τ that drives it while its neighbours rest, where taut [m]."""
    near, beyond = segments[i].length, segments[i + 1].length
    return 1.0 / (guides[i].drag + 1.0 / near + 1.0 / beyond)


@compiled
def _correct(segments: Segments, guides: Guides, side: float, tolerance: float) -> int:
    """Count and correct the guides whose slip the solution denies by more than a tolerance, in τ.

    With ``side`` +1 or −1 only between rest and sliding to that side; with 0 between all.
    """
    changed = 0
    for i in range(len(guides)):
        left, right = segments[i].tension, segments[i + 1].tension
        slip = guides[i].slip
        if slip == 0.0:
            if side >= 0.0 and _is_beyond(guides, i, 1.0, left, right, tolerance):
                guides[i].slip = 1.0
                changed += 1
            elif side <= 0.0 and _is_beyond(guides, i, -1.0, left, right, tolerance):
                guides[i].slip = -1.0
                changed += 1
        elif guides[i].flow * slip < 0.0:
            if is_frictionless(guides[i]):
                guides[i].slip = -slip
            elif abs(guides[i].flow) < tolerance * _yield(segments, guides, i):
                guides[i].flow = 0.0
            elif slip * side >= 0.0:
                guides[i].slip = 0.0
                changed += 1
    return changed


@compiled
def _hold_tendon(segments: Segments, guides: Guides, least: float) -> bool:
    """Whether the flows leave in every segment more than the part ``least`` of its length."""
    for j in range(len(segments)):
        left = spare(segments, j, stored_after(segments, guides, j))
        if not left > least * segments[j].length:
            return False
    return True


@compiled
def _tolerance(guides: Guides, done: int) -> float:
    """Of a correction [strain], when so many were done: rounding, by which they may go in circles.

    It is doubled with each that is more than there are guides.
    """
    return TOLERANCE * 2.0 ** max(0, done - len(guides) - _PASSES // 2)


@apart
def _follow_pattern(segments: Segments, guides: Guides, side: float, least: float) -> bool:
    """Solve, and correct the slip to ``side``, until nothing is left to correct."""
    for k in range(_PASSES + len(guides)):
        if not solve_pattern(segments, guides, least):
            return False
        if _correct(segments, guides, side, _tolerance(guides, k)) == 0:
            return True
    return False


@apart
def _follow_in_turn(segments: Segments, guides: Guides, least: float) -> bool:
    """Let slip to the input settle after each correction of slip to the output."""
    for k in range(_PASSES + len(guides)):
        if not _follow_pattern(segments, guides, 1.0, least):
            return False
        if _correct(segments, guides, -1.0, _tolerance(guides, k)) == 0:
            return True
    return False


@apart
def _solve_in_turn(segments: Segments, guides: Guides) -> bool:
    """In turn, and with tangents that begin later where the solution nearly empties a segment."""
    least = _LEAST
    for _ in range(_TANGENTS):
        if not _follow_in_turn(segments, guides, least):
            return False
        if _hold_tendon(segments, guides, least):
            return True
        least *= 0.1
    return False


@apart
def balance_dragged(segments: Segments, guides: Guides) -> bool:
    """Equilibrium for given holding ratios, DRAG > 0 at every guide.

    Returns:
        False where no solution was found. The flows are then the last that were tried, or 0 where
        those would empty a segment; the tension of one that is empty is infinite.
    """
    for i in range(len(guides)):
        guides[i].flow = 0.0
    if _follow_pattern(segments, guides, 0.0, _LEAST) and _hold_tendon(segments, guides, _LEAST):
        return True
    if sweep(segments, guides) and _solve_in_turn(segments, guides):
        return True
    for i in range(len(guides)):
        guides[i].flow, guides[i].slip = 0.0, 0.0
    if _solve_in_turn(segments, guides):
        return True
    if not _hold_tendon(segments, guides, 0.0):
        for i in range(len(guides)):
            guides[i].flow = 0.0
    for j in range(len(segments)):
        stored = stored_after(segments, guides, j)
        is_empty = not spare(segments, j, stored) > 0.0
        segments[j].tension = np.inf if is_empty else tension_at(segments, j, stored, 0.0)[0]
    return False
