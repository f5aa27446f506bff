"""The flow problem where sliding itself takes tension: viscous friction and the tendon's mass.

The guide's law then holds with τ_i − b − D f in the place of what it held before,

    slides to the input   τ_i = UP τ_{i+1} + C + D f + b         f > 0
    slides to the output  τ_{i+1} = DOWN τ_i + C − D f − b       f < 0

and rests where both hold as ≥ with f = 0. The flows are the unknowns: a guide's equation knows its
own and its two neighbours', so Newton's method solves a tridiagonal system. The guides' slip is
corrected as long as the solution denies it. Should that go in circles, one guide after the other is
given its own exact answer; flow over a guide only ever makes its neighbours flow more, so these
rounds converge from anywhere, and the pattern that they find is finished by Newton's method.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

import math

import numpy as np

from tendon_mj.compilation import apart, compiled
from tendon_mj.sheath.tables import (
    CONSTANT,
    DOWN,
    DRAG,
    FLOW,
    GIVE,
    LENGTH,
    OFFSET,
    PUSH,
    ROUNDING,
    SHARE,
    SLIP,
    STORED,
    TENSION,
    UP,
    Table,
)

_PASSES = 16  # pattern corrections, and one a guide
_STEPS = 40  # of Newton's method, of which a taut tendon needs about 4
_ROUNDS, _LOTS = 10, 40  # of relaxation: rounds before the pattern is tried, and such lots
_SETTLED = (
    1e-15  # change in a round, over the tendon's length, at which relaxation has come to rest
)
_VERGE = 8 * ROUNDING


@compiled
def _pull(segments: Table, j: int, stored: float) -> tuple[float, float]:
    """τ of segment j when it holds ``stored``, and dτ/ds ≤ 0; 0 where slack, inf where empty."""
    if not stored > 0.0:
        return np.inf, -np.inf
    stretch = 1.0 + segments[OFFSET, j]
    pull = segments[LENGTH, j] - stored * stretch
    if pull <= 0.0:
        return 0.0, 0.0
    softness = segments[SHARE, j] * stored + segments[GIVE, j]
    tau = pull / softness
    return tau, -(stretch + segments[SHARE, j] * tau) / softness


@compiled
def _kept(segments: Table, guides: Table, j: int) -> float:
    """What segment j holds once the flows at hand have passed [m]."""
    stored = segments[STORED, j]
    if j < guides.shape[1]:
        stored += guides[FLOW, j]
    if j > 0:
        stored -= guides[FLOW, j - 1]
    return stored


@compiled
def _is_free(guides: Table, i: int) -> bool:
    """Whether nothing rubs at guide i, so that its law is the same in both directions."""
    return guides[CONSTANT, i] == 0.0 and guides[UP, i] == 1.0 and guides[DOWN, i] == 1.0


@compiled
def _law(guides: Table, i: int, slip: float) -> tuple[float, float, float]:
    """Weights p, q and constant c of p τ_i − q τ_{i+1} = c + D f, the law of a sliding guide."""
    if slip > 0.0:
        return 1.0, guides[UP, i], guides[CONSTANT, i] + guides[PUSH, i]
    return guides[DOWN, i], 1.0, guides[PUSH, i] - guides[CONSTANT, i]


@compiled
def _begin(segments: Table, guides: Table) -> bool:
    """Flows to start from, after which every segment holds tendon; False where there is none."""
    emptied, path, total = False, 0.0, 0.0
    for j in range(segments.shape[1]):
        emptied |= not segments[STORED, j] > 0.0
        path += segments[LENGTH, j]
        total += segments[STORED, j]
    for i in range(guides.shape[1]):
        guides[FLOW, i] = 0.0
    if not emptied:
        return True
    passed = 0.0
    for i in range(guides.shape[1]):
        passed += total * segments[LENGTH, i] / path - segments[STORED, i]
        guides[FLOW, i] = passed
    return total > 0.0


@compiled
def _newton_step(segments: Table, guides: Table, steps: Table, ratios: Table) -> float:
    """One step of Newton's method on all sliding guides; how far it moved, in strain."""
    n = guides.shape[1]
    left, left_slope = _pull(segments, 0, _kept(segments, guides, 0))
    before = 0.0  # of the forward elimination: what the guide before hands on
    for i in range(n):
        right, right_slope = _pull(segments, i + 1, _kept(segments, guides, i + 1))
        if guides[SLIP, i] == 0.0:
            steps[i], ratios[i] = -guides[FLOW, i], 0.0
        else:
            p, q, c = _law(guides, i, guides[SLIP, i])
            drag = guides[DRAG, i]
            missing = p * left - q * right - c - drag * guides[FLOW, i]
            lower, upper = -p * left_slope, -q * right_slope
            pivot = drag - p * left_slope - q * right_slope
            if i > 0:
                pivot -= lower * ratios[i - 1]
                missing += lower * before
            steps[i], ratios[i] = missing / pivot, upper / pivot
        before = steps[i]
        left, left_slope = right, right_slope
    for i in range(n - 2, -1, -1):
        steps[i] += ratios[i] * steps[i + 1]
    # no segment may lose more than four fifths of what it holds at once
    most, part = 0.0, 1.0
    for j in range(n + 1):
        change = (steps[j] if j < n else 0.0) - (steps[j - 1] if j > 0 else 0.0)
        change /= _kept(segments, guides, j)
        most = max(most, abs(change))
        if change < -0.8:
            part = min(part, -0.8 / change)
    for i in range(n):
        guides[FLOW, i] += part * steps[i]
    return most


@compiled
def _solve(segments: Table, guides: Table) -> bool:
    """Flows and tensions for the guides' slip as it is."""
    n = guides.shape[1]
    if not _begin(segments, guides):
        segments[TENSION, n] = np.inf
        return False
    steps, ratios = np.empty(n), np.empty(n)
    for _ in range(_STEPS):
        moved = _newton_step(segments, guides, steps, ratios)
        if not math.isfinite(moved):
            return False
        if moved <= 1e-9:  # of its square is what Newton's method leaves
            _tighten(segments, guides)
            return True
    return False


@compiled
def _tighten(segments: Table, guides: Table) -> None:
    """Tensions that go with the flows."""
    for j in range(segments.shape[1]):
        segments[TENSION, j] = _pull(segments, j, _kept(segments, guides, j))[0]


@compiled
def _correct(segments: Table, guides: Table) -> int:
    """Count and correct the guides whose slip the solution denies by more than rounding."""
    changed = 0
    for i in range(guides.shape[1]):
        left, right = segments[TENSION, i], segments[TENSION, i + 1]
        constant, push = guides[CONSTANT, i], guides[PUSH, i]
        if guides[SLIP, i] == 0.0:
            if left > guides[UP, i] * right + constant + push + _VERGE:
                guides[SLIP, i] = 1.0
                changed += 1
            elif right > guides[DOWN, i] * left + constant - push + _VERGE:
                guides[SLIP, i] = -1.0
                changed += 1
        elif guides[FLOW, i] * guides[SLIP, i] < 0.0:
            if _is_free(guides, i):
                guides[SLIP, i] = -guides[SLIP, i]
            elif abs(guides[FLOW, i]) < _VERGE * segments[LENGTH, i]:
                guides[FLOW, i] = 0.0
            else:
                guides[SLIP, i] = 0.0
                changed += 1
    return changed


@apart
def _follow_pattern(segments: Table, guides: Table) -> bool:
    """Solve, and correct the slip, until nothing is left to correct."""
    for _ in range(_PASSES + guides.shape[1]):
        if not _solve(segments, guides):
            return False
        if _correct(segments, guides) == 0:
            return True
    return False


@compiled
def _own_flow(segments: Table, guides: Table, i: int) -> float:
    """Flow over guide i for which its law holds while its neighbours' flows stay."""
    here = _kept(segments, guides, i) - guides[FLOW, i]
    beyond = _kept(segments, guides, i + 1) + guides[FLOW, i]
    left, right = _pull(segments, i, here)[0], _pull(segments, i + 1, beyond)[0]
    constant, push = guides[CONSTANT, i], guides[PUSH, i]
    if left > guides[UP, i] * right + constant + push:
        slip, low, high = 1.0, max(0.0, -here), beyond
    elif right > guides[DOWN, i] * left + constant - push:
        slip, low, high = -1.0, -here, min(0.0, beyond)
    else:
        return 0.0
    p, q, c = _law(guides, i, slip)
    flow = 0.5 * (low + high)
    for _ in range(200):
        left, left_slope = _pull(segments, i, here + flow)
        right, right_slope = _pull(segments, i + 1, beyond - flow)
        missing = p * left - q * right - c - guides[DRAG, i] * flow
        if missing > 0.0:
            low = flow
        else:
            high = flow
        step = flow + missing / (guides[DRAG, i] - p * left_slope - q * right_slope)
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - flow) <= 1e-15 * (here + beyond) or step in (low, high):
            return step
        flow = step
    return flow


@compiled
def _relax_once(segments: Table, guides: Table) -> float:
    """Give each guide its own flow, there and back along the tendon; the largest change [m]."""
    n, most = guides.shape[1], 0.0
    for k in range(2 * n - 1):
        i = k if k < n else 2 * (n - 1) - k
        before = guides[FLOW, i]
        guides[FLOW, i] = _own_flow(segments, guides, i)
        most = max(most, abs(guides[FLOW, i] - before))
    return most


@compiled
def _point(guides: Table, flows: Table) -> None:
    """Take these flows, and their directions for the slip."""
    for i in range(guides.shape[1]):
        guides[FLOW, i], guides[SLIP, i] = flows[i], np.sign(flows[i])


@apart
def _relax(segments: Table, guides: Table) -> bool:
    """Guide after guide; the pattern that comes out is tried now and then."""
    if not _begin(segments, guides):
        segments[TENSION, guides.shape[1]] = np.inf
        return False
    length, flows = 0.0, np.empty(guides.shape[1])
    for j in range(segments.shape[1]):
        length += segments[LENGTH, j]
    for _ in range(_LOTS):
        changed = 0.0
        for _ in range(_ROUNDS):
            changed = _relax_once(segments, guides)
        for i in range(guides.shape[1]):
            flows[i] = guides[FLOW, i]
        _point(guides, flows)
        if _follow_pattern(segments, guides):
            return True
        _point(guides, flows)
        if changed <= _SETTLED * length:
            _tighten(segments, guides)
            return True
    _tighten(segments, guides)
    return False


@apart
def balance_dragged(segments: Table, guides: Table) -> bool:
    """Equilibrium for given holding ratios, DRAG > 0 at every guide.

    Returns:
        False where no solution was found.
    """
    return _follow_pattern(segments, guides) or _relax(segments, guides)
