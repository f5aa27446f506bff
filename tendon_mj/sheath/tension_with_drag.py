"""The flow problem where sliding itself takes tension: viscous friction and the tendon's mass.

The guide's law then holds with τ_i − b − D f in the place of τ_i,

    slides to the input   τ_i = R_in τ_{i+1} + C + D f + b        f > 0
    slides to the output  τ_{i+1} = R_out τ_i + C − D f − b       f < 0

and rests where both hold as ≥ with f = 0; R_in is ``input_ratio``, R_out ``output_ratio``.

**Flows for a given slip.** A guide that slides obeys p τ_i − q τ_{i+1} = c + D f: its equation has
its own flow and its two neighbours', so Newton's method solves a tridiagonal system. Full steps may
alternate between slack and taut. Each τ = max(0, τ̂) makes its guide's equation convex on the right
side, where it pulls from, and concave on the left. So which left sides are slack is held until
Newton's method has settled on which right sides are, then corrected, and so on. A pattern of slip
may leave a segment less than no tendon. Its tension goes on along a tangent there, so that every
pattern has a solution.

**The slip** is corrected as long as the solution contradicts it. These corrections may cycle. With
F⁺ and F⁻ for what the two laws lack, right side minus left in the first and left minus right in the
second, the flows are the root of max(F⁻, min(F⁺, f)), and flow over a guide only ever makes its
neighbours flow more. So slip to the input is corrected alone until it settles, then that to the
output once, and so on: policy iteration for two obstacles (Bokanowski, Maroso and Zidani, SIAM J.
Numer. Anal. 47(4), 3001–3026, 2009).

They begin with the flows without drag, which are next to the solution where drag is little, or else
at rest. A segment that the solution all but empties is on its tangent at first: those begin later
then.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tendon_mj.native import Array, External, apart, compiled
from tendon_mj.sheath.records import ROUNDING, Guides, Segments
from tendon_mj.sheath.tension_by_breakpoints import TOLERANCE, balance, lies_slack
from tendon_mj.sheath.tension_by_slip_pattern import is_frictionless
from tendon_mj.typing import FloatArray

_STEPS = 40  # of Newton's method, of which a taut tendon needs about 4
_SHORT = 1e-8  # step [strain] that leaves rounding, its square, if none becomes slack or taut
_FREE, _SLACK, _TAUT = -1.0, 0.0, 1.0  # a left side: as its tension is, or held slack or taut
_malloc = External("malloc", "ptr(i64)")
_free = External("free", "void(ptr)")
_numbers: Callable[[int, int], FloatArray] = Array("float64")


@compiled
def spare(segments: Segments, j: int, stored: float) -> float:
    """Unstretched length that segment j may lose when it holds ``stored``, s + g/a [m].

    An elastic support shortens the path as the tension rises, by more than the segment's own length
    where it comes to that.
    """
    return stored + segments[j].support_compliance / segments[j].strain_slope


@compiled
def _pull(segments: Segments, j: int, stored: float, least: float) -> tuple[float, float]:
    """τ̂ of segment j when it holds ``stored``, below 0 if it is slack, and dτ̂/ds < 0.

    If less is left of it than the part ``least`` of its length, τ̂ goes on along its tangent.
    """
    stretch = 1.0 + segments[j].strain_offset
    lacking = max(least * segments[j].length - spare(segments, j, stored), 0.0)
    stored += lacking
    softness = segments[j].strain_slope * stored + segments[j].support_compliance
    tau = (segments[j].length - stored * stretch) / softness
    slope = -(stretch + segments[j].strain_slope * tau) / softness
    return tau - slope * lacking, slope


@compiled
def tension_at(segments: Segments, j: int, stored: float, least: float) -> tuple[float, float]:
    """τ of segment j when it holds ``stored``, and dτ/ds ≤ 0; 0 if slack."""
    tau, slope = _pull(segments, j, stored, least)
    return (tau, slope) if tau > 0.0 else (0.0, 0.0)


@compiled
def stored_after(segments: Segments, guides: Guides, j: int) -> float:
    """Unstretched length of segment j once the flows at hand have passed [m]."""
    stored = segments[j].stored
    if j < len(guides):
        stored += guides[j].flow
    if j > 0:
        stored -= guides[j - 1].flow
    return stored


@compiled
def law(guides: Guides, i: int, slip: float) -> tuple[float, float, float]:
    """Weights p, q and constant c of p τ_i − q τ_{i+1} = c + D f, the law of a sliding guide."""
    if slip > 0.0:
        return 1.0, guides[i].input_ratio, guides[i].constant_friction + guides[i].momentum
    return guides[i].output_ratio, 1.0, guides[i].momentum - guides[i].constant_friction


@compiled
def _left_side(
    segments: Segments, guides: Guides, j: int, least: float, held: float
) -> tuple[float, float]:
    """τ of segment j as the guide behind it feels it, and dτ/ds, where it is ``held`` or not."""
    if held == _SLACK:
        return 0.0, 0.0
    tau, slope = _pull(segments, j, stored_after(segments, guides, j), least)
    return (tau, slope) if held == _TAUT or tau > 0.0 else (0.0, 0.0)


@compiled
def _newton_step(
    segments: Segments,
    guides: Guides,
    steps: FloatArray,
    ratios: FloatArray,
    held: FloatArray,
    least: float,
) -> tuple[float, bool]:
    """Newton's step of all sliding guides: how far it goes [strain], and whether all laws are met.

    They are met where they lack rounding alone. What is left of a segment is known to the rounding
    of the flows beside it, by which no step goes. The segments receive their tensions.
    """
    n, met = len(guides), True
    segments[0].tension = tension_at(segments, 0, stored_after(segments, guides, 0), least)[0]
    # of the guide before: right-hand side after forward elimination, 1 − ratio
    before, loose = 0.0, 1.0
    for i in range(n):
        left, left_slope = _left_side(segments, guides, i, least, held[i])
        right, right_slope = tension_at(
            segments, i + 1, stored_after(segments, guides, i + 1), least
        )
        segments[i + 1].tension = right
        if guides[i].slip == 0.0:
            steps[i], ratios[i], loose = 0.0, 0.0, 1.0
        else:
            p, q, c = law(guides, i, guides[i].slip)
            drag = guides[i].drag
            missing = p * left - q * right - c - drag * guides[i].flow
            rounding = p * (1.0 / segments[i].strain_slope + abs(left))
            rounding = ROUNDING * (rounding + q * (1.0 / segments[i + 1].strain_slope + right))
            met &= abs(missing) <= 8.0 * rounding
            if abs(missing) <= rounding:
                missing = 0.0
            lower, upper = -p * left_slope, -q * right_slope
            # what the row exceeds its neighbours by; a difference of pivots would round it away
            excess = drag + lower * loose
            pivot = excess + upper
            steps[i], ratios[i] = (missing + lower * before) / pivot, upper / pivot
            loose = excess / pivot
        before = steps[i]
    for i in range(n - 2, -1, -1):
        steps[i] += ratios[i] * steps[i + 1]
    return _most_strain(segments, guides, steps, least), met


@compiled
def _most_strain(segments: Segments, guides: Guides, steps: FloatArray, least: float) -> float:
    """Largest strain by which a step changes a segment, beyond the rounding of its flows."""
    n, most = len(guides), 0.0
    for j in range(n + 1):
        change, flows = 0.0, 0.0
        if j < n:
            change, flows = steps[j], abs(guides[j].flow)
        if j > 0:
            change, flows = change - steps[j - 1], flows + abs(guides[j - 1].flow)
        left = spare(segments, j, stored_after(segments, guides, j))
        change = max(0.0, abs(change) - 2.0 * ROUNDING * flows)
        moves = change / max(left, least * segments[j].length)
        if not moves <= most:  # nor if it is not a number
            most = moves
    return most


@compiled
def _pass(guides: Guides, steps: FloatArray, share: float) -> None:
    for i in range(len(guides)):
        guides[i].flow += share * steps[i]


@compiled
def _set_tensions(segments: Segments, guides: Guides, least: float) -> bool:
    """Set the tensions that belong to the flows; whether the same segments are slack as before."""
    same = True
    for j in range(len(segments)):
        tau, _ = tension_at(segments, j, stored_after(segments, guides, j), least)
        same &= (tau > 0.0) == (segments[j].tension > 0.0)
        segments[j].tension = tau
    return same


@compiled
def _hold(segments: Segments, guides: Guides, held: FloatArray, least: float) -> bool:
    """Hold slack what the flows leave slack, and taut the rest; whether that was held before.

    What is slack or taut by no more than rounding stays as it was.
    """
    same = True
    for j in range(len(segments)):
        tau, _ = _pull(segments, j, stored_after(segments, guides, j), least)
        now = _TAUT if tau > 0.0 else _SLACK
        if held[j] == _FREE or (held[j] != now and segments[j].strain_slope * abs(tau) > TOLERANCE):
            held[j], same = now, False
    return same


@compiled
def solve_pattern(segments: Segments, guides: Guides, least: float) -> bool:
    """Flows and tensions for the guides' slip as it is, from the flows at hand.

    By full steps or, if those go to and fro, from rest and with what is slack held.
    """
    work = _malloc(8 * (4 * len(guides) + 1))
    solved = work != 0 and _solve_in(segments, guides, least, work)
    _free(work)
    return solved


@compiled
def _solve_in(segments: Segments, guides: Guides, least: float, work: int) -> bool:
    """As ``solve_pattern``, with work space for 4 n + 1 numbers."""
    n = len(guides)
    steps, ratios = _numbers(work, n), _numbers(work + 8 * n, n)
    first, held = _numbers(work + 16 * n, n), _numbers(work + 24 * n, n + 1)
    held[:] = _FREE
    for i in range(n):
        if guides[i].slip == 0.0:
            guides[i].flow = 0.0
        first[i] = guides[i].flow
    for k in range(2 * _STEPS + 8 * n):
        if k == _STEPS:
            for i in range(n):
                guides[i].flow = first[i]
            _hold(segments, guides, held, least)
        moves, met = _newton_step(segments, guides, steps, ratios, held, least)
        # little drag makes a long step of rounding where the tendon is slack
        same = moves == 0.0 or (met and moves > _SHORT)
        if not same:
            if not math.isfinite(moves):
                return False
            _pass(guides, steps, 1.0)
            same = _set_tensions(segments, guides, least)
            if met and not same:  # the step counted as slack what it makes taut
                _pass(guides, steps, -1.0)
                _set_tensions(segments, guides, least)
                same = True
        if same and k >= _STEPS:
            same = _hold(segments, guides, held, least)
        if same and (met or moves <= _SHORT):
            return True
    return False


_PASSES = 16  # pattern corrections, and one a guide
_LEAST = 1e-2  # part of a segment's length, held by which its tension goes on along the tangent
_TANGENTS = 11  # down to 1e-12, each a tenth of the one before


@compiled
def _is_beyond(
    guides: Guides, i: int, slip: float, left: float, right: float, tolerance: float
) -> bool:
    """Return whether the tensions beside guide i, which rests, drive it to ``slip``."""
    p, q, c = law(guides, i, slip)
    return slip * (p * left - q * right - c) > tolerance * (p + q)


@compiled
def _yield(segments: Segments, guides: Guides, i: int) -> float:
    """Flow over guide i per unit τ that drives it while its neighbours rest, where taut [m]."""
    near = segments[i].strain_slope * segments[i].length
    beyond = segments[i + 1].strain_slope * segments[i + 1].length
    return 1.0 / (guides[i].drag + 1.0 / near + 1.0 / beyond)


@compiled
def _correct(segments: Segments, guides: Guides, side: float, tolerance: float) -> int:
    """Count and correct guides whose slip the solution denies by more than a tolerance [strain].

    With ``side`` +1 or −1 only between rest and sliding to that side; with 0 between all.
    """
    changed = 0
    for i in range(len(guides)):
        left, right = segments[i].tension, segments[i + 1].tension
        slip = guides[i].slip
        within = tolerance / min(segments[i].strain_slope, segments[i + 1].strain_slope)
        if slip == 0.0:
            if side >= 0.0 and _is_beyond(guides, i, 1.0, left, right, within):
                guides[i].slip = 1.0
                changed += 1
            elif side <= 0.0 and _is_beyond(guides, i, -1.0, left, right, within):
                guides[i].slip = -1.0
                changed += 1
        elif guides[i].flow * slip < 0.0:
            if is_frictionless(guides[i]):
                guides[i].slip = -slip
            elif abs(guides[i].flow) < within * _yield(segments, guides, i):
                guides[i].flow = 0.0
            elif slip * side >= 0.0:
                guides[i].slip = 0.0
                changed += 1
    return changed


@compiled
def _hold_tendon(segments: Segments, guides: Guides, least: float) -> bool:
    """Return whether the flows leave every segment more than the part ``least`` of its length."""
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
        False if no solution was found. The flows are then the last that were tried, or 0 if
        those would empty a segment; the tension of one that is empty is infinite.
    """
    for i in range(len(guides)):
        guides[i].flow = 0.0
    if _follow_pattern(segments, guides, 0.0, _LEAST) and _hold_tendon(segments, guides, _LEAST):
        return True
    undragged = lies_slack(segments, guides) or balance(segments, guides, False)
    if undragged and _solve_in_turn(segments, guides):
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
