"""Flows over guides of which it is known where they slide, where sliding itself takes tension.

A guide that slides obeys p τ_i − q τ_{i+1} = c + D f (see ``tension_with_drag``): its equation has
its own flow and its two neighbours', so Newton's method solves a tridiagonal system.

A pattern of slip may leave a segment less than no tendon. Its tension goes on along a tangent
there, so that every pattern has a solution. It is the minimum of a convex function, by whose slope
a step is cut where full ones go to and fro, between what is slack and what is taut.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

import math

import numpy as np

from tendon_mj.compilation import apart, compiled
from tendon_mj.sheath.records import ROUNDING, Array, Guides, Segments

_STEPS = 40  # of Newton's method, of which a taut tendon needs about 4
_HALVINGS = 40  # of a step that goes too far
TOLERANCE = 8 * ROUNDING  # of a tension, within which a law is met


@compiled
def spare(segments: Segments, j: int, stored: float) -> float:
    """Unstretched length that segment j may lose when it holds ``stored``, s + g/a [m].

    An elastic support shortens the path as the tension rises, by more than the segment's own length
    where it comes to that.
    """
    return stored + segments[j].support_compliance / segments[j].strain_slope


@compiled
def tension_at(segments: Segments, j: int, stored: float, least: float) -> tuple[float, float]:
    """τ of segment j when it holds ``stored``, and dτ/ds ≤ 0; 0 where slack.

    Where less is left of it than the part ``least`` of its length, τ goes on along its tangent.
    """
    stretch = 1.0 + segments[j].strain_offset
    lacking = max(least * segments[j].length - spare(segments, j, stored), 0.0)
    stored += lacking
    pull = segments[j].length - stored * stretch
    if pull <= 0.0:
        return 0.0, 0.0
    softness = segments[j].strain_slope * stored + segments[j].support_compliance
    tau = pull / softness
    slope = -(stretch + segments[j].strain_slope * tau) / softness
    return tau - slope * lacking, slope


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
def _newton_step(
    segments: Segments, guides: Guides, steps: Array, ratios: Array, least: float
) -> float:
    """Newton's step of all sliding guides; how far it goes, in strain, 0 where there is none to go.

    That is where every law is met to rounding: a slack tendon with little drag would move by more.
    The segments receive their tensions.
    """
    n, met = len(guides), True
    left, left_slope = tension_at(segments, 0, stored_after(segments, guides, 0), least)
    segments[0].tension = left
    before = 0.0  # right-hand side of the guide before, after forward elimination
    for i in range(n):
        right, right_slope = tension_at(
            segments, i + 1, stored_after(segments, guides, i + 1), least
        )
        segments[i + 1].tension = right
        if guides[i].slip == 0.0:
            steps[i], ratios[i] = 0.0, 0.0
        else:
            p, q, c = law(guides, i, guides[i].slip)
            drag = guides[i].drag
            missing = p * left - q * right - c - drag * guides[i].flow
            met &= abs(missing) <= TOLERANCE * (p + q) * (1.0 + left + right)
            lower, upper = -p * left_slope, -q * right_slope
            pivot = drag - p * left_slope - q * right_slope
            if i > 0:
                pivot -= lower * ratios[i - 1]
                missing += lower * before
            steps[i], ratios[i] = missing / pivot, upper / pivot
        before = steps[i]
        left, left_slope = right, right_slope
    if met:
        return 0.0
    for i in range(n - 2, -1, -1):
        steps[i] += ratios[i] * steps[i + 1]
    most = 0.0
    for j in range(n + 1):
        change = (steps[j] if j < n else 0.0) - (steps[j - 1] if j > 0 else 0.0)
        left = spare(segments, j, stored_after(segments, guides, j))
        most = max(most, abs(change) / max(left, least * segments[j].length))
    return most


@compiled
def _descent(segments: Segments, guides: Guides, steps: Array, part: float, least: float) -> float:
    """How steeply a convex function falls at a part of a step: its minimum is the solution.

    Each law is a row of its gradient once it is weighted such that both neighbours of a segment
    feel its tension alike, w_i p_i = w_{i−1} q_{i−1}.
    """
    falls, weight, q = 0.0, 1.0, 1.0
    stored = segments[0].stored
    for i in range(len(guides)):
        flow = guides[i].flow + part * steps[i]
        beyond = segments[i + 1].stored - flow
        if guides[i].slip == 0.0:
            weight, q = 1.0, 1.0
        else:
            left = tension_at(segments, i, stored + flow, least)[0]
            after = 0.0
            if i + 1 < len(guides):
                after = guides[i + 1].flow + part * steps[i + 1]
            right = tension_at(segments, i + 1, beyond + after, least)[0]
            p, q_here, c = law(guides, i, guides[i].slip)
            weight *= q / p
            q = q_here
            falls += weight * steps[i] * (p * left - q * right - c - guides[i].drag * flow)
        stored = beyond
    return falls


@apart
def _part_to_go(segments: Segments, guides: Guides, steps: Array, least: float) -> float:
    """Part of a step, 1 at most, after which the convex function has about ceased to fall."""
    enough = 0.5 * _descent(segments, guides, steps, 0.0, least)
    low, high, part = 0.0, 1.0, 1.0
    for _ in range(_HALVINGS):
        falls = _descent(segments, guides, steps, part, least)
        if abs(falls) <= enough or (part == 1.0 and falls > 0.0):
            break
        if falls > 0.0:
            low = part
        else:
            high = part
        part = 0.5 * (low + high)
    return part


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
def solve_pattern(segments: Segments, guides: Guides, least: float) -> bool:
    """Flows and tensions for the guides' slip as it is, from the flows at hand.

    By full steps or, where those go to and fro, from rest: by full steps again, then by cut ones.
    """
    n = len(guides)
    steps, ratios = np.empty(n), np.empty(n)
    for k in range(3 * _STEPS + n):
        for i in range(n):
            if k in (_STEPS, 2 * _STEPS) or guides[i].slip == 0.0:
                guides[i].flow = 0.0
        moves = _newton_step(segments, guides, steps, ratios, least)
        if moves == 0.0:
            return True
        if not math.isfinite(moves):
            return False
        part = 1.0 if k < 2 * _STEPS else _part_to_go(segments, guides, steps, least)
        for i in range(n):
            guides[i].flow += part * steps[i]
        # the error that Newton's method leaves is of the square, where no segment becomes slack
        if moves <= 1e-8 and part == 1.0 and _set_tensions(segments, guides, least):
            return True
    return False
