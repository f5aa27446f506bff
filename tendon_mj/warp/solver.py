"""Solver of one time step: tensions of the segments and flow of tendon over each guide.

Where the guides slide as they did in the last step, each run of them is one scalar equation; where
they do not, `breakpoints` solves the whole tendon. The same as in `tendon_mj.sheath`, without drag,
where the method is explained; the tests hold one against the other.
"""

import warp as wp

from tendon_mj.warp.breakpoints import (
    SETTLED,
    TOLERANCE,
    find_slip,
    highest,
    lies_slack,
    set_flows,
)
from tendon_mj.warp.tendons import Sheath, Tendons, held, tension_of

wp.set_module_options({"enable_backward": False})

_STEPS = wp.constant(4)
_NEAR = wp.constant(wp.float64(1e-6))  # error of a tension, see `tendon_mj.sheath`


@wp.func
def _is_frictionless(t: Tendons, s: Sheath, i: int) -> bool:
    row, w = s.guide + i, s.world
    one = wp.float64(1.0)
    free = t.input_ratio[row, w] == one and t.output_ratio[row, w] == one
    return free and t.constant[row, w] == wp.float64(0.0)


@wp.func
def _gain(t: Tendons, s: Sheath, i: int) -> wp.float64:
    """Growth of τ behind guide i, which slides, per growth before it."""
    row, w = s.guide + i, s.world
    if t.slip[row, w] > 0:
        return wp.float64(1.0) / t.input_ratio[row, w]
    return t.output_ratio[row, w]


@wp.func
def _behind(t: Tendons, s: Sheath, i: int, tau: wp.float64) -> wp.float64:
    """τ behind guide i, which slides, from τ before it."""
    row, w = s.guide + i, s.world
    if t.slip[row, w] > 0:
        return (tau - t.constant[row, w]) * _gain(t, s, i)
    return _gain(t, s, i) * tau + t.constant[row, w]


@wp.func
def _finish_run(t: Tendons, s: Sheath, first: int, last: int, head: wp.float64) -> bool:
    """Tensions and flows of the run once the tension of its first segment is known."""
    w = s.world
    passed = wp.float64(0.0)
    tau = wp.float64(head)
    for k in range(first, last + 1):
        if not tau > wp.float64(0.0):
            return False
        t.tension[s.segment + k, w] = tau
        if k < last:
            holds, _ = held(t, s, k, tau)
            passed += holds - t.kept[s.segment + k, w]
            t.flow[s.guide + k, w] = passed
            tau = _behind(t, s, k, tau)
    return True


@wp.func
def _solve_run(t: Tendons, s: Sheath, first: int, last: int) -> bool:
    """Tensions and flows of a run of sliding guides, from segment ``first`` to segment ``last``."""
    head = wp.float64(t.tension[s.segment + first, s.world])
    if not head > wp.float64(0.0):
        head = wp.float64(1e-6)
    for _ in range(_STEPS):
        missing, slope, curvature = wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)
        tau, gain, most = wp.float64(head), wp.float64(1.0), wp.float64(1.0)
        for k in range(first, last + 1):
            holds, falls = held(t, s, k, tau)
            missing += holds - t.kept[s.segment + k, s.world]
            slope += gain * falls
            curvature -= gain * gain * wp.float64(2.0) * falls / (wp.float64(1.0) + tau)
            if k < last:
                tau = _behind(t, s, k, tau)
                gain *= _gain(t, s, k)
                most = wp.max(most, gain)
        step = -missing / slope
        step /= wp.float64(1.0) + wp.float64(0.5) * step * curvature / slope
        head += step
        # the largest tension's error is of the order of the cube of its step
        most *= wp.abs(step)
        if most * most * most <= wp.float64(1e-17):
            return _finish_run(t, s, first, last, head)
    return False


@wp.func
def _follow_input(t: Tendons, s: Sheath, last: int) -> bool:
    """Tensions and flows of the run from the input, whose tension is given, to segment ``last``."""
    w = s.world
    tau = wp.float64(t.tension[s.segment, w])
    for k in range(last):
        tau = _behind(t, s, k, tau)
        if not tau >= wp.float64(0.0):
            return False
        t.tension[s.segment + k + 1, w] = tau
    passed = wp.float64(0.0)
    for back in range(last):
        k = last - 1 - back
        row = s.segment + k + 1
        holds, _ = held(t, s, k + 1, t.tension[row, w])
        passed += t.kept[row, w] - holds
        t.flow[s.guide + k, w] = passed
    return True


@wp.func
def _guess_from_motion(t: Tendons, s: Sheath) -> None:
    """Let every guide slide as the motion takes the tendon over it, where the input is given."""
    w = s.world
    passed = wp.float64(0.0)
    for back in range(s.guides):
        k = s.guides - 1 - back
        row, guide = s.segment + k + 1, s.guide + k
        tau = t.tension[row, w]
        holds, _ = held(t, s, k + 1, tau)
        passed += t.kept[row, w] - holds
        ratio = wp.max(t.input_ratio[guide, w], t.output_ratio[guide, w])
        yields = t.length[row, w] + t.give[row, w]
        if wp.abs(passed) > wp.float64(4.0) * (ratio - wp.float64(1.0)) * tau * yields:
            t.slip[guide, w] = wp.where(passed > wp.float64(0.0), 1, -1)


@wp.func
def _agrees(t: Tendons, s: Sheath) -> bool:
    """Whether the solution agrees, to rounding, with the slip from which it follows."""
    w = s.world
    for i in range(s.guides):
        row, segment = s.guide + i, s.segment + i
        slip, flow = t.slip[row, w], t.flow[row, w]
        if slip == 0:
            t.flow[row, w] = wp.float64(0.0)
            left, right = t.tension[segment, w], t.tension[segment + 1, w]
            if left > highest(t, s, i, right) + TOLERANCE:
                return False
            if right > t.output_ratio[row, w] * left + t.constant[row, w] + TOLERANCE:
                return False
        elif flow * wp.float64(slip) < wp.float64(0.0):
            if _is_frictionless(t, s, i):
                t.slip[row, w] = -slip  # nothing rubs: either direction will do
            elif wp.abs(flow) < TOLERANCE * t.length[segment, w]:
                t.flow[row, w] = wp.float64(0.0)
            else:
                return False
    return True


@wp.func
def _follow_pattern(t: Tendons, s: Sheath) -> bool:
    """Tensions and flows for the guides' slip; whether they are the solution."""
    w = s.world
    first = int(0)
    while first <= s.guides:
        last = int(first)
        while last < s.guides:
            if t.slip[s.guide + last, w] == 0:
                break
            last += 1
        if s.given and first == 0:
            if not _follow_input(t, s, last):
                return False
        elif last == first:
            t.tension[s.segment + first, w] = tension_of(t, s, first)
        elif not _solve_run(t, s, first, last):
            return False
        tau = t.tension[s.segment + last, w]
        # a slack segment between guides that hold is right where the input is given
        slack = s.given and tau == wp.float64(0.0)
        if not ((wp.float64(0.0) < tau and tau < wp.float64(1e300)) or slack):
            return False
        first = last + 1
    return _agrees(t, s)


@wp.func
def _balance(t: Tendons, s: Sheath) -> bool:
    """Equilibrium for given holding ratios: the slip of the last step, or what breakpoints find."""
    if _follow_pattern(t, s):
        return True
    if not s.given and lies_slack(t, s):
        return True
    if not find_slip(t, s, _NEAR):
        return False
    if _follow_pattern(t, s):
        return True
    return find_slip(t, s, SETTLED) and set_flows(t, s)


@wp.func
def _release(t: Tendons, s: Sheath) -> bool:
    """Whether a guide broke loose that was at rest; it slides at μ_d from here on."""
    w = s.world
    released = bool(False)
    for i in range(s.guides):
        row = s.guide + i
        dynamic = t.dynamic_ratio[row, w]
        if t.slip[row, w] > 0 and t.input_ratio[row, w] > dynamic:
            t.input_ratio[row, w] = dynamic
            released = True
        elif t.slip[row, w] < 0 and t.output_ratio[row, w] > dynamic:
            t.output_ratio[row, w] = dynamic
            released = True
    return released


@wp.func
def _is_bounded(t: Tendons, s: Sheath) -> bool:
    """Whether every tension has a bound; where one has none it is inf, and nothing flows."""
    w = s.world
    bounded = bool(True)
    for j in range(s.guides + 1):
        if not wp.isfinite(t.tension[s.segment + j, w]):
            t.tension[s.segment + j, w] = wp.float64(wp.inf)
            bounded = False
    if not bounded:
        for i in range(s.guides):
            t.flow[s.guide + i, w] = wp.float64(0.0)
            t.slip[s.guide + i, w] = t.previous_slip[s.guide + i, w]
    return bounded


@wp.func
def solve_flow(t: Tendons, s: Sheath) -> bool:
    """Solve for tensions and flows such that every guide either holds or slides by its law.

    ``tension`` holds a guess on entry; it, ``flow`` and ``slip`` receive the result.

    Returns:
        False where the result is not the solution. The flow is then the best that was found, or 0
        where there is none.
    """
    w = s.world
    stiction = bool(False)
    for i in range(s.guides):
        row = s.guide + i
        slip = t.previous_slip[row, w]
        static, dynamic = t.static_ratio[row, w], t.dynamic_ratio[row, w]
        t.input_ratio[row, w] = wp.where(slip > 0, dynamic, static)
        t.output_ratio[row, w] = wp.where(slip < 0, dynamic, static)
        free = t.constant[row, w] == wp.float64(0.0) and static == wp.float64(1.0)
        t.slip[row, w] = wp.where(free, 1, slip)
        t.flow[row, w] = wp.float64(0.0)
        if static != dynamic:
            stiction = True
    if s.given:
        _guess_from_motion(t, s)
    solved = bool(False)
    for _ in range(1 + 2 * s.guides):
        solved = _balance(t, s)
        if not (stiction and solved):
            break
        if not _release(t, s):
            break
    return _is_bounded(t, s) and solved
