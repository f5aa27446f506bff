"""The flow problem where sliding itself takes tension: viscous friction and the tendon's mass.

The guide's law then holds with τ_i − b − D f in the place of what it held before,

    slides to the input   τ_i = R_in τ_{i+1} + C + D f + b        f > 0
    slides to the output  τ_{i+1} = R_out τ_i + C − D f − b       f < 0

and rests where both hold as ≥ with f = 0; R_in is ``input_ratio``, R_out ``output_ratio``. The
flows are the unknowns: a guide's equation has its own and its two neighbours', so Newton's method
solves a tridiagonal system. The guides' slip is corrected as long as the solution contradicts it.
Where these corrections cycle, one guide after the other is given its own exact solution; flow over
a guide only ever makes its neighbours flow more, so this relaxation converges from anywhere, and
the pattern that it finds is finished by Newton's method.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

import math

import numpy as np

from tendon_mj.compilation import apart, compiled
from tendon_mj.sheath.records import ROUNDING, Array, Guides, Segments
from tendon_mj.sheath.tension_by_slip_pattern import is_frictionless

_PASSES = 16  # pattern corrections, and one a guide
_STEPS = 40  # of Newton's method, of which a taut tendon needs about 4
_ROUNDS, _ATTEMPTS = 10, 40  # rounds of relaxation before the pattern is tried; such attempts
_CONVERGED = 1e-15  # change in a round, over the tendon's length, at which relaxation ends
_TOLERANCE = 8 * ROUNDING


@compiled
def _spare(segments: Segments, j: int, stored: float) -> float:
    """Unstretched length that segment j may lose when it holds ``stored``, s + g/a [m].

    An elastic support shortens the path as the tension rises, by more than the segment's own length
    where it comes to that.
    """
    return stored + segments[j].support_compliance / segments[j].strain_slope


@compiled
def _tension_at(segments: Segments, j: int, stored: float) -> tuple[float, float]:
    """τ of segment j when it holds ``stored``, and dτ/ds ≤ 0; 0 where slack, inf where empty."""
    if not _spare(segments, j, stored) > 0.0:
        return np.inf, -np.inf
    stretch = 1.0 + segments[j].strain_offset
    pull = segments[j].length - stored * stretch
    if pull <= 0.0:
        return 0.0, 0.0
    softness = segments[j].strain_slope * stored + segments[j].support_compliance
    tau = pull / softness
    return tau, -(stretch + segments[j].strain_slope * tau) / softness


@compiled
def _stored_after(segments: Segments, guides: Guides, j: int) -> float:
    """Unstretched length of segment j once the flows at hand have passed [m]."""
    stored = segments[j].stored
    if j < len(guides):
        stored += guides[j].flow
    if j > 0:
        stored -= guides[j - 1].flow
    return stored


@compiled
def _law(guides: Guides, i: int, slip: float) -> tuple[float, float, float]:
    """Weights p, q and constant c of p τ_i − q τ_{i+1} = c + D f, the law of a sliding guide."""
    if slip > 0.0:
        return 1.0, guides[i].input_ratio, guides[i].constant_friction + guides[i].momentum
    return guides[i].output_ratio, 1.0, guides[i].momentum - guides[i].constant_friction


@compiled
def _set_initial_flows(segments: Segments, guides: Guides) -> bool:
    """Set flows to start from, after which every segment holds tendon; False if there is none."""
    emptied, path, total = False, 0.0, 0.0
    for j in range(len(segments)):
        emptied |= not _spare(segments, j, segments[j].stored) > 0.0
        path += segments[j].length
        total += segments[j].stored
    for i in range(len(guides)):
        guides[i].flow = 0.0
    if not emptied:
        return True
    passed = 0.0
    for i in range(len(guides)):
        passed += total * segments[i].length / path - segments[i].stored
        guides[i].flow = passed
    return total > 0.0


@compiled
def _newton_step(segments: Segments, guides: Guides, steps: Array, ratios: Array) -> float:
    """One step of Newton's method on all sliding guides; how far it moved, in strain."""
    n = len(guides)
    left, left_slope = _tension_at(segments, 0, _stored_after(segments, guides, 0))
    before = 0.0  # right-hand side of the guide before, after forward elimination
    for i in range(n):
        right, right_slope = _tension_at(segments, i + 1, _stored_after(segments, guides, i + 1))
        if guides[i].slip == 0.0:
            steps[i], ratios[i] = -guides[i].flow, 0.0
        else:
            p, q, c = _law(guides, i, guides[i].slip)
            drag = guides[i].drag
            missing = p * left - q * right - c - drag * guides[i].flow
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
    # no segment may lose more than four fifths of what it can at once
    most, part = 0.0, 1.0
    for j in range(n + 1):
        change = (steps[j] if j < n else 0.0) - (steps[j - 1] if j > 0 else 0.0)
        change /= _spare(segments, j, _stored_after(segments, guides, j))
        most = max(most, abs(change))
        if change < -0.8:
            part = min(part, -0.8 / change)
    for i in range(n):
        guides[i].flow += part * steps[i]
    return most


@compiled
def _solve(segments: Segments, guides: Guides) -> bool:
    """Flows and tensions for the guides' slip as it is."""
    n = len(guides)
    if not _set_initial_flows(segments, guides):
        segments[n].tension = np.inf
        return False
    steps, ratios = np.empty(n), np.empty(n)
    for _ in range(_STEPS):
        moved = _newton_step(segments, guides, steps, ratios)
        if not math.isfinite(moved):
            return False
        if moved <= 1e-9:  # the error that Newton's method leaves is of its square
            _set_tensions(segments, guides)
            return True
    return False


@compiled
def _set_tensions(segments: Segments, guides: Guides) -> None:
    """Set the tensions that belong to the flows."""
    for j in range(len(segments)):
        segments[j].tension = _tension_at(segments, j, _stored_after(segments, guides, j))[0]


@compiled
def _correct(segments: Segments, guides: Guides) -> int:
    """Count and correct the guides whose slip the solution denies by more than rounding."""
    changed = 0
    for i in range(len(guides)):
        left, right = segments[i].tension, segments[i + 1].tension
        constant, momentum = guides[i].constant_friction, guides[i].momentum
        if guides[i].slip == 0.0:
            if left > guides[i].input_ratio * right + constant + momentum + _TOLERANCE:
                guides[i].slip = 1.0
                changed += 1
            elif right > guides[i].output_ratio * left + constant - momentum + _TOLERANCE:
                guides[i].slip = -1.0
                changed += 1
        elif guides[i].flow * guides[i].slip < 0.0:
            if is_frictionless(guides[i]):
                guides[i].slip = -guides[i].slip
            elif abs(guides[i].flow) < _TOLERANCE * segments[i].length:
                guides[i].flow = 0.0
            else:
                guides[i].slip = 0.0
                changed += 1
    return changed


@apart
def _follow_pattern(segments: Segments, guides: Guides) -> bool:
    """Solve, and correct the slip, until nothing is left to correct."""
    for _ in range(_PASSES + len(guides)):
        if not _solve(segments, guides):
            return False
        if _correct(segments, guides) == 0:
            return True
    return False


@compiled
def _flow_alone(segments: Segments, guides: Guides, i: int) -> float:
    """Flow over guide i for which its law holds while its neighbours' flows stay."""
    here = _stored_after(segments, guides, i) - guides[i].flow
    beyond = _stored_after(segments, guides, i + 1) + guides[i].flow
    lowest, highest = -_spare(segments, i, here), _spare(segments, i + 1, beyond)
    left, right = _tension_at(segments, i, here)[0], _tension_at(segments, i + 1, beyond)[0]
    constant, momentum = guides[i].constant_friction, guides[i].momentum
    if left > guides[i].input_ratio * right + constant + momentum:
        slip, low, high = 1.0, max(0.0, lowest), highest
    elif right > guides[i].output_ratio * left + constant - momentum:
        slip, low, high = -1.0, lowest, min(0.0, highest)
    else:
        return 0.0
    p, q, c = _law(guides, i, slip)
    flow = 0.5 * (low + high)
    for _ in range(200):
        left, left_slope = _tension_at(segments, i, here + flow)
        right, right_slope = _tension_at(segments, i + 1, beyond - flow)
        missing = p * left - q * right - c - guides[i].drag * flow
        if missing > 0.0:
            low = flow
        else:
            high = flow
        step = flow + missing / (guides[i].drag - p * left_slope - q * right_slope)
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - flow) <= 1e-15 * (highest - lowest) or step in (low, high):
            return step
        flow = step
    return flow


@compiled
def _relax_once(segments: Segments, guides: Guides) -> float:
    """Give each guide its own flow, there and back along the tendon; the largest change [m]."""
    n, most = len(guides), 0.0
    for k in range(2 * n - 1):
        i = k if k < n else 2 * (n - 1) - k
        before = guides[i].flow
        guides[i].flow = _flow_alone(segments, guides, i)
        most = max(most, abs(guides[i].flow - before))
    return most


@compiled
def _set_pattern(guides: Guides, flows: Array) -> None:
    """Set the flows, and their directions as the pattern of slip."""
    for i in range(len(guides)):
        guides[i].flow, guides[i].slip = flows[i], np.sign(flows[i])


@apart
def _relax(segments: Segments, guides: Guides) -> bool:
    """Guide after guide; the pattern that comes out is tried now and then."""
    if not _set_initial_flows(segments, guides):
        segments[len(guides)].tension = np.inf
        return False
    length, flows = 0.0, np.empty(len(guides))
    for j in range(len(segments)):
        length += segments[j].length
    for _ in range(_ATTEMPTS):
        changed = 0.0
        for _ in range(_ROUNDS):
            changed = _relax_once(segments, guides)
        for i in range(len(guides)):
            flows[i] = guides[i].flow
        _set_pattern(guides, flows)
        if _follow_pattern(segments, guides):
            return True
        _set_pattern(guides, flows)
        if changed <= _CONVERGED * length:
            _set_tensions(segments, guides)
            return True
    _set_tensions(segments, guides)
    return False


@apart
def balance_dragged(segments: Segments, guides: Guides) -> bool:
    """Equilibrium for given holding ratios, DRAG > 0 at every guide.

    Returns:
        False where no solution was found.
    """
    return _follow_pattern(segments, guides) or _relax(segments, guides)
