"""The flow problem of a whole tendon, in a number of operations that its guides bound.

Cut the tendon behind segment j: G_j(τ) is the length that segments 0 to j lack when segment j has
tension τ. It falls with τ, and its root τ*_j is the tension that segment j would take alone. Guide
j − 1 keeps the tension before it between two bounds, `lowest` and `highest`, so that

    G_j(τ) = h_j(τ) − s_j + G_{j−1}(clip(τ*_{j−1}, lowest(τ), highest(τ)))

where h_j(τ) is the length that segment j holds and s_j what it has stored. A walk forward finds
every τ*_j; a walk back the tensions, τ_j = clip(τ*_j, lowest(τ_{j+1}), highest(τ_{j+1})).

**Breakpoints.** With tangents in place of the h_j, G_j is piecewise linear. Two stacks hold its
breakpoints, those left and those right of the root. Behind a guide those on the left move from p to
(p − C)/R_in, those on the right to R_out p + C, and a flat piece comes between. This is one map for
all of a stack, applied when a breakpoint is looked at. A tangent moves none. The next root is
searched for from the flat piece outwards; breakpoints that the search passes change stacks.

**Jumps.** No tension is below 0, where a segment may hold any length above its own, nor outside
what the guides allow for a given input tension. A root at such a bound lies on a jump of G_j, and
so does one at the tension that draws slack tendon over a guide.

**Rounds.** Tangents to a convex function lie below it. So no tension is too high after the first
round, and from round to round they rise to the solution, as those of Newton's method.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from tendon_mj.native import Array, External, apart, compiled
from tendon_mj.sheath.records import ROUNDING, Guides, Segments, record_type
from tendon_mj.sheath.segment_law import held
from tendon_mj.typing import FloatArray

_ROUNDS = 64  # of which strains below 1 need about 4; each at least doubles a strain that is above
_FARTHEST = 16.0  # scale of a map, beyond which the rounding of its shift would count
_SETTLED = 1e-16  # error of a tension over the largest, where Newton's method need not go on
TOUCHING = 1e-12  # relative distance at which a tension counts as being at its bound
TOLERANCE = 8 * ROUNDING  # of a tension beyond its bound; a guide there would chatter

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
    if right > constant * (1.0 + TOUCHING):
        return (right - constant) / guides[i].output_ratio
    return 0.0


class Breakpoint:
    """A point at which G_j changes its slope, seen from the root, before the map of its stack."""

    tau: float  # [-]
    bend: float  # slope beyond it less slope before it [m]
    jump: float  # G_j beyond it less G_j before it [m]


BREAKPOINT = record_type(Breakpoint)
_SIZE = BREAKPOINT.itemsize
_breakpoints_at: Callable[[int, int], Any] = Array(BREAKPOINT)
_numbers: Callable[[int, int], FloatArray] = Array("float64")


class Stack(NamedTuple):
    """Breakpoints on one side of a root, the nearest on top, and their map τ → scale τ + shift."""

    points: Any
    size: int
    scale: float
    inverse: float  # of the scale
    shift: float


@compiled
def _mapped(stack: Stack, scale: float, inverse: float, shift: float) -> Stack:
    """The stack with every τ moved to scale τ + shift; slopes shrink as distances grow."""
    shift += scale * stack.shift
    scale, inverse = scale * stack.scale, inverse * stack.inverse
    inverse *= 2.0 - scale * inverse  # else what hundreds of guides round would add up
    if max(scale, inverse) > _FARTHEST:
        for k in range(stack.size):
            point = stack.points[k]
            point.tau, point.bend = scale * point.tau + shift, point.bend * inverse
        scale, inverse, shift = 1.0, 1.0, 0.0
    return Stack(stack.points, stack.size, scale, inverse, shift)


@compiled
def _cut(stack: Stack, size: int) -> Stack:
    """The lowest ``size`` breakpoints of the stack."""
    return Stack(stack.points, size, stack.scale, stack.inverse, stack.shift)


@compiled
def _pushed(stack: Stack, tau: float, bend: float, jump: float) -> Stack:
    """The stack with one breakpoint more."""
    point = stack.points[stack.size]
    point.tau = (tau - stack.shift) * stack.inverse
    point.bend, point.jump = bend * stack.scale, jump
    return _cut(stack, stack.size + 1)


Side = tuple[float, float]  # slope and value of G_j on one side of its root


@compiled
def _search(
    side: float, tau: float, bound: float, at_zero: float, slope: float, near: Stack, far: Stack
) -> tuple[float, Side, Side, Stack, Stack]:
    """Root of G_j on the right of ``tau`` (``side`` +1) or on its left (−1), at most at ``bound``.

    G_j at ``tau`` is on a line with this ``slope`` and this value ``at_zero``; ``near`` holds the
    breakpoints on that side. Returns the root, G_j just before and just beyond it, seen from
    ``tau``, and both stacks.

    What a breakpoint changes of the value at 0 is at most a length of tendon. Elsewhere it would be
    rounded: a segment that is next to nothing puts breakpoints at strains of 10⁶, and steep lines
    of much friction begin at strains of 10⁻⁹.
    """
    while True:
        at, bend, jump, left = bound, 0.0, -side * math.inf, 0
        if near.size > 0:
            point = near.points[near.size - 1]
            inner = near.scale * point.tau + near.shift
            if side * (inner - tau) <= TOUCHING * abs(near.shift):
                inner = tau  # rounding moves it neither past that nor off a slack segment's 0
            if side * (inner - bound) < -TOUCHING * abs(near.shift):
                at, bend, jump, left = inner, point.bend * near.inverse, point.jump, near.size - 1
        value = at_zero + slope * at
        if side * value < 0.0:
            return -at_zero / slope, (slope, 0.0), (slope, 0.0), near, far
        near = _cut(near, left)
        if not side * (value + jump) > 0.0:
            return at, (slope, value), (slope + bend, value + jump), near, far
        far = _pushed(far, at, -bend, -jump)
        tau, at_zero, slope = at, at_zero + jump - bend * at, slope + bend


@compiled
def _walk_forward(
    segments: Segments, guides: Guides, given: bool, left: Stack, right: Stack, roots: FloatArray
) -> None:
    """The τ*_j, with tangents at the tensions that the segments have."""
    least, most = 0.0, math.inf
    low, high = least, most
    root = 0.0
    before, beyond = (0.0, 0.0), (0.0, 0.0)  # slope and value of G_j on the left and right of it
    first = 0
    if given:
        first, root = 1, segments[0].tension
        least, most = root, root
        roots[0] = root
    for j in range(first, len(segments)):
        if j > 0:
            guide = guides[j - 1]
            ratio, back, constant = guide.input_ratio, guide.output_ratio, guide.constant_friction
            inverse, inverse_back = 1.0 / ratio, 1.0 / back
            left = _mapped(left, inverse, ratio, -constant * inverse)
            right = _mapped(right, back, inverse_back, constant)
            least, most = max(0.0, least - constant) * inverse, most * back + constant
            low, high = (root - constant) * inverse, root * back + constant
            if low > least and root > constant * (1.0 + TOUCHING):
                left = _pushed(left, low, before[0] * ratio, before[1])
            else:
                low, left = least, _cut(left, 0)
            if high < most:
                right = _pushed(right, high, beyond[0] * inverse_back, beyond[1])
            else:
                high, right = most, _cut(right, 0)
        tau = segments[j].tension
        if not 0.0 <= tau <= 1e100:
            tau = 0.0
        holds, slope, _ = held(segments, j, tau)
        value = holds - segments[j].stored
        root = tau - value / slope
        before = beyond = (slope, 0.0)
        if root < low:
            zero = value - slope * tau
            root, beyond, before, left, right = _search(-1.0, low, least, zero, slope, left, right)
        elif root > high:
            zero = value - slope * tau
            root, before, beyond, right, left = _search(1.0, high, most, zero, slope, right, left)
        roots[j] = root


@compiled
def _walk_back(segments: Segments, guides: Guides, given: bool, roots: FloatArray) -> float:
    """Tensions and slip that follow from the τ*_j; about the error of one over the largest.

    After a change of a tension that is of the order of the square of the change.
    """
    most, largest = 0.0, 0.0
    for j in range(len(segments) - 1, -1, -1):
        tau = roots[j]
        if j < len(guides):
            right = segments[j + 1].tension
            low, high = lowest(guides, j, right), highest(guides, j, right)
            guides[j].slip = 0.0
            if tau > high * (1.0 + TOUCHING):
                guides[j].slip = 1.0
            elif tau < low * (1.0 - TOUCHING):
                guides[j].slip = -1.0
            tau = min(max(tau, low), high)
        if j == 0 and given:  # rounding apart, the walk has left it
            break
        change = abs(tau - segments[j].tension)
        if change * segments[j].strain_slope <= TOLERANCE:  # rounding, all there is if none is taut
            change = 0.0
        if not change <= most:  # nor if it is not a number
            most = change
        largest = max(largest, tau)
        segments[j].tension = tau
    return most * most / largest if most != 0.0 else 0.0


@compiled
def _lacking(segments: Segments, guides: Guides, j: int, first: int) -> float:
    """What the sliding run that ends with segment j lacks [m]."""
    total = 0.0
    for k in range(j, first - 1, -1):
        total += held(segments, k, segments[k].tension)[0] - segments[k].stored
        if k == 0 or guides[k - 1].slip == 0.0:
            break
    return total


@compiled
def _slip_at_bound(segments: Segments, guides: Guides, i: int, passed: float) -> float:
    """Direction in which guide i lets ``passed`` through; 0 if its tensions do not.

    If τ* is at the bound itself, on a jump, the flow is what is needed of that.
    """
    left, right = segments[i].tension, segments[i + 1].tension
    if passed > 0.0 and left >= highest(guides, i, right) * (1.0 - TOUCHING) - TOLERANCE:
        return 1.0
    least = guides[i].output_ratio * left + guides[i].constant_friction  # of the right, to slide
    if passed < 0.0 and (left <= TOLERANCE or right >= least * (1.0 - TOUCHING) - TOLERANCE):
        return -1.0
    return 0.0


@compiled
def _set_flows(segments: Segments, guides: Guides, given: bool) -> bool:
    """Flows over the guides; whether every segment ends with the length of its tension.

    A segment that is slack, to rounding, may end with more. It keeps what it has unless a neighbour
    needs it.
    """
    first = 1 if given else 0
    beyond, total, holds = 0.0, 0.0, True
    for j in range(len(segments)):
        total += abs(segments[j].stored)
    for j in range(len(segments) - 1, first - 1, -1):
        slip = guides[j - 1].slip if j > 0 else 0.0
        tau = segments[j].tension
        length, slope, _ = held(segments, j, tau)
        passed = segments[j].stored + beyond - length
        if tau <= TOLERANCE:
            needed = max(0.0, _lacking(segments, guides, j - 1, first)) if slip > 0.0 else 0.0
            if needed < passed:
                segments[j].tension, passed = 0.0, needed
        counts = total + abs(beyond) - slope
        if j > 0 and not passed * slip > 0.0 and abs(passed) > TOLERANCE * counts:
            slip = _slip_at_bound(segments, guides, j - 1, passed)
        if not passed * slip > 0.0:
            holds &= abs(passed) <= TOUCHING * counts
            passed = slip = 0.0
        if j > 0:
            guides[j - 1].flow, guides[j - 1].slip = passed, slip
        beyond = passed
    return holds


@compiled
def _lie_slack(segments: Segments, guides: Guides, total: float, slack: float) -> None:
    """Spread a tendon of a length evenly along its path, whose length it has ``slack`` times."""
    passed = 0.0
    segments[len(guides)].tension = 0.0
    for k in range(len(guides)):
        length = segments[k].length / (1.0 + segments[k].strain_offset)
        passed += slack * length - segments[k].stored
        flow = passed if abs(passed) > TOLERANCE * total else 0.0
        segments[k].tension, guides[k].flow, guides[k].slip = 0.0, flow, np.sign(flow)


@apart
def lies_slack(segments: Segments, guides: Guides) -> bool:
    """Return whether a tendon is longer than its path; it is spread evenly along it then."""
    path, total = 0.0, 0.0
    for k in range(len(segments)):
        path += segments[k].length / (1.0 + segments[k].strain_offset)
        total += segments[k].stored
    if total < path:
        return False
    _lie_slack(segments, guides, total, total / path)
    return True


@compiled
def _has_tendon(segments: Segments) -> bool:
    """Return whether any is left between the ends."""
    total = 0.0
    for j in range(len(segments)):
        total += segments[j].stored
    return total > 0.0


@compiled
def _settle(segments: Segments, guides: Guides, given: bool, within: float, work: int) -> bool:
    """Rounds until the error is ``within``; ``work`` has room for breakpoints and the τ*_j."""
    most = 2 * len(guides)
    left = Stack(_breakpoints_at(work, most), 0, 1.0, 1.0, 0.0)
    right = Stack(_breakpoints_at(work + most * _SIZE, most), 0, 1.0, 1.0, 0.0)
    roots = _numbers(work + 2 * most * _SIZE, len(segments))
    for _ in range(_ROUNDS):
        _walk_forward(segments, guides, given, left, right, roots)
        if _walk_back(segments, guides, given, roots) <= within:
            return True
    return False


@apart
def find_slip(segments: Segments, guides: Guides, given: bool, within: float) -> bool:
    """Tensions and slip for given holding ratios.

    Args:
        segments, guides: see ``records``; the first tangents are at ``tension``.
        given: whether the tension of the first segment is, which may then have any length.
        within: error of a tension, over the largest.

    Returns:
        False if no tendon is left between the ends, or if rounding keeps the rounds from
        settling. The tensions are inf then.
    """
    solved = given or _has_tendon(segments)
    if solved:
        work = _malloc(4 * len(guides) * _SIZE + 8 * len(segments))
        solved = work != 0 and _settle(segments, guides, given, within, work)
        _free(work)
    if not solved:
        for j in range(len(segments)):
            segments[j].tension = math.inf
    return solved


@apart
def balance(segments: Segments, guides: Guides, given: bool) -> bool:
    """Tensions, flows and slip for given holding ratios; as `find_slip`, and then the flows.

    Returns:
        False also if rounding leaves a segment without the length of its tension.
    """
    solved = find_slip(segments, guides, given, _SETTLED)
    return solved and _set_flows(segments, guides, given)
