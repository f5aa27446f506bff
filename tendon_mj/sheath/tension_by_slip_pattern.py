"""The flow problem when it is known which guides slide: one scalar equation per sliding run.

Guides that slide in a row tie the tensions of their segments to each other, and the run as a whole
conserves its tendon: one unknown, solved by Halley's method. Most steps slide as the step before
did, and then this is the quickest way; the solution shows whether it did.

If the input tension is given, the run that begins at the input has no unknown: its tensions
follow from one end, the flows from the other, and what it lacks comes in at the input.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

from tendon_mj.native import compiled
from tendon_mj.sheath.records import Guide, Guides, Segments
from tendon_mj.sheath.segment_law import held, tension_of
from tendon_mj.sheath.tension_by_breakpoints import TOLERANCE, highest

_STEPS = 4


@compiled
def is_frictionless(guide: Guide) -> bool:
    """Return whether nothing rubs at a guide, so that its law is the same in both directions."""
    free = guide.input_ratio == 1.0 and guide.output_ratio == 1.0
    return guide.constant_friction == 0.0 and free


@compiled
def _over(guides: Guides, i: int, tau: float) -> tuple[float, float]:
    """τ behind guide i, which slides, from τ before it; its growth per growth before it."""
    if guides[i].slip > 0.0:
        ratio = 1.0 / guides[i].input_ratio
        return (tau - guides[i].constant_friction) * ratio, ratio
    ratio = guides[i].output_ratio
    return ratio * tau + guides[i].constant_friction, ratio


@compiled
def _solve_run(segments: Segments, guides: Guides, first: int, last: int) -> bool:
    """Tensions and flows of a run of sliding guides, from segment ``first`` to segment ``last``."""
    head = segments[first].tension
    if not head > 0.0:
        head = 1e-6
    for _ in range(_STEPS):
        missing, slope, curvature, tau, gain, most = 0.0, 0.0, 0.0, head, 1.0, 1.0
        for k in range(first, last + 1):
            holds, falls, curves = held(segments, k, tau)
            missing += holds - segments[k].stored
            slope += gain * falls
            curvature += gain * gain * curves
            if k < last:
                tau, ratio = _over(guides, k, tau)
                gain *= ratio
                most = max(most, gain)
        step = -missing / slope
        step /= 1.0 + 0.5 * step * curvature / slope
        head += step
        # the largest tension's error is of the order of the cube of its step
        if abs(most * step) ** 3 <= 1e-17:
            return _finish_run(segments, guides, first, last, head)
    return False


@compiled
def _finish_run(segments: Segments, guides: Guides, first: int, last: int, tau: float) -> bool:
    """Tensions and flows of the run once the tension of its first segment is known."""
    passed = 0.0
    for k in range(first, last + 1):
        if not tau > 0.0:
            return False
        segments[k].tension = tau
        if k < last:
            passed += held(segments, k, tau)[0] - segments[k].stored
            guides[k].flow = passed
            tau = _over(guides, k, tau)[0]
    return True


@compiled
def _follow_input(segments: Segments, guides: Guides, last: int) -> bool:
    """Tensions and flows of the run from the input, whose tension is given, to segment ``last``."""
    tau = segments[0].tension
    for k in range(last):
        tau = _over(guides, k, tau)[0]
        if not tau >= 0.0:
            return False
        segments[k + 1].tension = tau
    passed = 0.0
    for k in range(last - 1, -1, -1):
        passed += segments[k + 1].stored - held(segments, k + 1, segments[k + 1].tension)[0]
        guides[k].flow = passed
    return True


@compiled
def guess_from_motion(segments: Segments, guides: Guides) -> None:
    """Let every guide slide as the motion takes the tendon over it, where the input is given.

    A stiff tendon whose path changes by more than it can stretch slides wherever it rubs. Segments
    have the tensions of the step before.
    """
    passed = 0.0
    for k in range(len(guides) - 1, -1, -1):
        segment = segments[k + 1]
        passed += segment.stored - held(segments, k + 1, segment.tension)[0]
        ratio = max(guides[k].input_ratio, guides[k].output_ratio)
        yields = segment.length + segment.support_compliance
        if abs(passed) > 4.0 * (ratio - 1.0) * segment.tension * yields:
            guides[k].slip = 1.0 if passed > 0.0 else -1.0


@compiled
def _agrees(segments: Segments, guides: Guides) -> bool:
    """Return whether the solution agrees, to rounding, with the slip from which it follows."""
    for i in range(len(guides)):
        guide = guides[i]
        left, right = segments[i].tension, segments[i + 1].tension
        if guide.slip == 0.0:
            guide.flow = 0.0
            if left > highest(guides, i, right) + TOLERANCE:
                return False
            if right > guide.output_ratio * left + guide.constant_friction + TOLERANCE:
                return False
        elif left + right == 0.0 and abs(guide.flow) < TOLERANCE * segments[i].length:
            guide.flow = 0.0  # a slack tendon that rounding would move
        elif not guide.flow * guide.slip >= 0.0:  # nor if it is not a number
            if is_frictionless(guide):
                guide.slip = -guide.slip  # nothing rubs: either direction will do
            elif abs(guide.flow) < TOLERANCE * min(segments[i].length, segments[i + 1].length):
                guide.flow = 0.0
            else:
                return False
    return True


@compiled
def follow_pattern(segments: Segments, guides: Guides, given: bool) -> bool:
    """Tensions and flows for the guides' slip; whether they are the solution.

    ``given``: whether the tension of the first segment is.
    """
    last_guide = len(guides)
    first = 0
    while first <= last_guide:
        last = first
        while last < last_guide and guides[last].slip != 0.0:
            last += 1
        if given and first == 0:
            if not _follow_input(segments, guides, last):
                return False
        elif last == first:
            segments[first].tension = tension_of(segments, first)
        elif not _solve_run(segments, guides, first, last):
            return False
        tau = segments[last].tension
        # a slack segment between guides that hold is right where the input is given
        if not (0.0 < tau < 1e300 or (given and tau == 0.0)):
            return False
        first = last + 1
    return _agrees(segments, guides)
