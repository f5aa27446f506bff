"""The flow problem of the whole tendon, in a number of operations that the guides bound.

Cut the tendon behind segment j. G_j(τ) is the length that segments 0 to j lack when segment j has
tension τ. It falls with τ, and its root τ*_j is the tension that the segment would take alone. Guide
j − 1 keeps the tension before it between ``lowest`` and ``highest`` of the one behind it, so that

    G_j(τ) = h_j(τ) − s_j + G_{j−1}(clip(τ*_{j−1}, lowest(τ), highest(τ)))

with the length h_j(τ) that segment j holds and s_j that it has. A walk forward finds every τ*_j, a
walk back the tensions, τ_j = clip(τ*_j, lowest(τ_{j+1}), highest(τ_{j+1})).

**Breakpoints.** With the tangent of h_j in its place G_j is piecewise linear. Its breakpoints lie on
two stacks, those left and those right of its root. Past a guide all on the left move from p to
(p − C)/R_in and all on the right to R_out p + C, and a flat piece comes between: one affine map for
each stack, applied when a breakpoint is looked at. Adding a tangent moves none. The new root is
sought from the flat piece outwards; each breakpoint that it passes changes stacks.

**Bounds.** No tension is below 0, where a segment holds any length above its own, nor outside what
the guides allow from a given input tension. A root at such a bound, or at the tension from which
slack tendon is drawn, lies on a jump of G_j: it is a breakpoint with a jump.

**Tangents** to a convex function lie below it, so that after the first round no tension is too high;
they rise from round to round to the solution, by Newton's method, at last quadratically.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from tendon_mj.native import Array, External, apart, compiled
from tendon_mj.sheath.records import ROUNDING, Guides, Segments, record_type
from tendon_mj.sheath.segment_law import held

_ROUNDS = 64  # of which a tendon under strains below 1 needs at most 5
_SETTLED = 1e-8  # change of a tension in a round that leaves an error of its square
_TOUCHING = 1e-12  # relative distance at which a tension counts as being at its bound
TOLERANCE = 8 * ROUNDING  # beyond a bound, within which a guide rests: it would chatter otherwise
_malloc = External("malloc", "ptr(i64)")
_free = External("free", "void(ptr)")


@compiled
def highest(guides: Guides, i: int, right: float) -> float:
    """Largest τ that guide i holds on its input side against ``right``."""
    return guides[i].input_ratio * right + guides[i].constant_friction


@compiled
def lowest(guides: Guides, i: int, right: float) -> float:
    """Smallest τ that guide i holds on its input side against ``right``."""
    constant = guides[i].constant_friction
    # the rounding of a difference must not make a slack segment taut
    if right > constant * (1.0 + _TOUCHING):
        return (right - constant) / guides[i].output_ratio
    return 0.0


class Breakpoint:
    """A point at which the slope of G_j changes, as its stack holds it: before the stack's map."""

    place: float  # τ [-]
    bend: float  # slope beyond it, seen from the root, less slope before it [m]
    jump: float  # of G_j from before it to beyond it [m]


BREAKPOINT = record_type(Breakpoint)
_SIZE = BREAKPOINT.itemsize
_breakpoints_at: Callable[[int, int], Any] = Array(BREAKPOINT)


@compiled
def _push(stack: Any, count: int, place: float, bend: float, jump: float) -> int:
    """Put a breakpoint on a stack; how many are there then."""
    stack[count].place, stack[count].bend, stack[count].jump = place, bend, jump
    return count + 1


@compiled
def _seek(
    side: float,
    bound: float,
    at: float,
    lacks: float,
    slope: float,
    near: tuple[Any, int, float, float],
    far: tuple[Any, int, float, float],
) -> tuple[float, float, float, float, float, int, int]:
    """Root of G_j on the left (``side`` −1) or the right (+1) of τ ``at``, but not past ``bound``.

    ``lacks`` and ``slope`` are G_j and its slope at ``at``. The stacks ``near`` (on that side) and
    ``far`` are breakpoints, their number, and scale and shift of their map.

    Returns:
        The root, the slope before it and beyond it, seen from ``at``, G_j there where it lies on a
        jump and 0 elsewhere, and how many breakpoints are on either stack.
    """
    stack, count, scale, shift = near
    other, moved, other_scale, other_shift = far
    while True:
        root = at - lacks / slope
        place, bend, jump = bound, 0.0, -side * math.inf
        if count > 0:
            inner = scale * stack[count - 1].place + shift
            if side * (inner - bound) < 0.0:
                count -= 1
                place, bend, jump = inner, stack[count].bend / scale, stack[count].jump
        if side * (root - place) < 0.0:
            if place != bound:
                count += 1
            return root, slope, slope, 0.0, 0.0, count, moved
        lacks += slope * (place - at)
        if not side * (lacks + jump) > 0.0:
            return place, slope, slope + bend, lacks, lacks + jump, count, moved
        moved = _push(
            other, moved, (place - other_shift) / other_scale, -bend * other_scale, -jump
        )
        at, lacks, slope = place, lacks + jump, slope + bend


@compiled
def _walk_forward(
    segments: Segments, guides: Guides, given: bool, left: Any, right: Any
) -> None:
    """τ*_j of every segment, with the tangents at its tension; two stacks are the work space."""
    lefts, rights, begin = 0, 0, 0
    left_scale, left_shift, right_scale, right_shift = 1.0, 0.0, 1.0, 0.0
    least, most = 0.0, math.inf
    low, high = least, most
    root, slope_left, slope_right, jump_left, jump_right = 0.0, 0.0, 0.0, 0.0, 0.0
    if given:
        begin, least, most, root = 1, segments[0].tension, segments[0].tension, segments[0].tension
        segments[0].prefix_tension = root
    for j in range(begin, len(segments)):
        if j > 0:
            ratio, back = guides[j - 1].input_ratio, guides[j - 1].output_ratio
            constant = guides[j - 1].constant_friction
            left_scale, left_shift = left_scale / ratio, (left_shift - constant) / ratio
            right_scale, right_shift = right_scale * back, right_shift * back + constant
            least, most = max(0.0, least - constant) / ratio, most * back + constant
            low, high = (root - constant) / ratio, root * back + constant
            if low > least:
                place = (low - left_shift) / left_scale
                lefts = _push(left, lefts, place, slope_left * ratio * left_scale, jump_left)
            else:
                low, lefts = least, 0
            if high < most:
                place = (high - right_shift) / right_scale
                rights = _push(right, rights, place, slope_right / back * right_scale, jump_right)
            else:
                high, rights = most, 0
        tau = segments[j].tension
        holds, slope, _ = held(segments, j, tau)
        lacks = holds - segments[j].stored
        root = tau - lacks / slope
        slope_left = slope_right = slope
        jump_left = jump_right = 0.0
        near, far = (left, lefts, left_scale, left_shift), (right, rights, right_scale, right_shift)
        if root < low:
            lacks += slope * (low - tau)
            root, slope_right, slope_left, jump_right, jump_left, lefts, rights = _seek(
                -1.0, least, low, lacks, slope, near, far
            )
        elif root > high:
            lacks += slope * (high - tau)
            root, slope_left, slope_right, jump_left, jump_right, rights, lefts = _seek(
                1.0, most, high, lacks, slope, far, near
            )
        segments[j].prefix_tension = root


@compiled
def _walk_back(segments: Segments, guides: Guides, given: bool) -> float:
    """Tensions and slip that follow from the τ*_j; the largest change of a segment's tension."""
    most = 0.0
    for j in range(len(segments) - 1, -1, -1):
        tau = segments[j].prefix_tension
        if j < len(guides):
            right = segments[j + 1].tension
            low, high = lowest(guides, j, right), highest(guides, j, right)
            guides[j].slip = 0.0
            if tau > high + TOLERANCE * high:
                tau, guides[j].slip = high, 1.0
            elif tau < low - TOLERANCE * low:
                tau, guides[j].slip = low, -1.0
        if j == 0 and given:
            break
        change = abs(tau - segments[j].tension)
        if not change <= most:  # nor where it is not a number
            most = change
        segments[j].tension = tau
    return most


@compiled
def _drawn(segments: Segments, guides: Guides, i: int, first: int) -> float:
    """What the run of sliding guides that ends with guide i lacks before it [m]."""
    total = 0.0
    for k in range(i, first - 1, -1):
        total += held(segments, k, segments[k].tension)[0] - segments[k].stored
        if k == 0 or guides[k - 1].slip == 0.0:
            break
    return total


@compiled
def _slip_at_bound(segments: Segments, guides: Guides, i: int, passed: float) -> float:
    """Direction in which guide i lets ``passed`` through; 0 where its tensions do not.

    Its own τ* is at the bound where the flow is the part of a jump.
    """
    left, right = segments[i].tension, segments[i + 1].tension
    if passed > 0.0 and left >= highest(guides, i, right) * (1.0 - _TOUCHING):
        return 1.0
    if passed < 0.0 and left <= lowest(guides, i, right) * (1.0 + _TOUCHING):
        return -1.0
    return 0.0


@compiled
def _set_flows(segments: Segments, guides: Guides, given: bool) -> bool:
    """Flows over the guides; whether every segment has the length of its tension.

    A slack one keeps what it has unless a neighbour needs it, and may have more.
    """
    first = 1 if given else 0
    beyond, rounded, solved = 0.0, 0.0, True
    for j in range(len(segments)):
        rounded += TOLERANCE * abs(segments[j].stored)
    for j in range(len(segments) - 1, first - 1, -1):
        slip = guides[j - 1].slip if j > 0 else 0.0
        tau = segments[j].tension
        holds, slope, _ = held(segments, j, tau)
        passed = segments[j].stored + beyond - holds
        if tau == 0.0 and slip > 0.0:
            passed = _drawn(segments, guides, j - 1, first)
        elif tau == 0.0:
            passed = min(0.0, passed)
        tolerance = rounded - TOLERANCE * slope + TOLERANCE * abs(beyond)
        if slip == 0.0 and j > 0 and abs(passed) > tolerance:
            slip = _slip_at_bound(segments, guides, j - 1, passed)
        if passed * slip <= 0.0:
            solved &= abs(passed) <= tolerance
            passed = slip = 0.0
        if j > 0:
            guides[j - 1].flow, guides[j - 1].slip = passed, slip
        beyond = passed
    return solved


@compiled
def _lie_slack(segments: Segments, guides: Guides) -> bool:
    """Spread a tendon longer than its path evenly along it; return False for a taut one."""
    path, total = 0.0, 0.0
    for k in range(len(segments)):
        path += segments[k].length / (1.0 + segments[k].strain_offset)
        total += segments[k].stored
    if total < path:
        return False
    passed = 0.0
    segments[len(segments) - 1].tension = 0.0
    for k in range(len(guides)):
        share = segments[k].length / (1.0 + segments[k].strain_offset) / path
        passed += share * total - segments[k].stored
        segments[k].tension, guides[k].flow, guides[k].slip = 0.0, passed, np.sign(passed)
    return True


@apart
def balance(segments: Segments, guides: Guides, given: bool) -> bool:
    """Tensions, flows and slip for given holding ratios.

    Args:
        segments, guides: see ``records``; the tangents begin at ``tension``.
        given: whether the tension of the first segment is, which may then have any length.

    Returns:
        False without a solution: no tendon is left between the ends.
    """
    if not given and _lie_slack(segments, guides):
        return True
    most = 2 * len(guides)
    work = _malloc(2 * most * _SIZE)
    left = _breakpoints_at(work, most)
    right = _breakpoints_at(work + most * _SIZE, most)
    settled = False
    for _ in range(_ROUNDS):
        _walk_forward(segments, guides, given, left, right)
        settled = _walk_back(segments, guides, given) <= _SETTLED
        if settled:
            break
    _free(work)
    return settled and _set_flows(segments, guides, given)
