"""Solver of one time step: tensions of the segments and flow of tendon over each guide.

If the guides slide as they did in the last step, each run of them is one scalar equation; where
they do not, `breakpoints` solves the whole tendon. The same as in `tendon_mj.sheath`, without drag,
where the method is explained; the tests hold one against the other.

A GPU runs 32 threads in step, here 32 worlds, and takes as long for them as for the way of each one
after the other where they differ. So loops here go over all segments, whatever the guides do: the
equations of all runs advance together. Each function is called from one place, as all of them
become one kernel, which is slower the longer it is.
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
from tendon_mj.warp.tendons import ONE, ZERO, Sheath, Tendons, held

wp.set_module_options({"enable_backward": False})

_STEPS = wp.constant(4)
_NEAR = wp.constant(wp.float64(1e-3))  # error of a tension, see `tendon_mj.sheath`
_LARGEST = wp.constant(wp.float64(1e300))


@wp.func
def _is_frictionless(t: Tendons, s: Sheath, i: int) -> bool:
    row, w = s.guide + i, s.world
    free = t.input_ratio[row, w] == ONE and t.output_ratio[row, w] == ONE
    return free and t.constant[row, w] == ZERO


@wp.func
def _guess_from_motion(t: Tendons, s: Sheath) -> None:
    """Let every guide slide as the motion takes the tendon over it, where the input is given."""
    w = s.world
    passed = wp.float64(0.0)
    for back in range(s.guides):
        k = s.guides - 1 - back
        row, guide = s.segment + k + 1, s.guide + k
        tau = t.tension[row, w]
        holds, _, _ = held(t, s, k + 1, tau)
        passed += t.kept[row, w] - holds
        ratio = wp.max(t.input_ratio[guide, w], t.output_ratio[guide, w])
        yields = t.length[row, w] + t.give[row, w]
        if wp.abs(passed) > wp.float64(4.0) * (ratio - ONE) * tau * yields:
            t.slip[guide, w] = wp.where(passed > ZERO, 1, -1)


@wp.func
def _slides(t: Tendons, s: Sheath, i: int) -> bool:
    """Return whether guide i slides; the ends of the tendon do not."""
    if i < 0 or i >= s.guides:
        return False
    return t.slip[s.guide + i, s.world] != 0


@wp.func
def _over(t: Tendons, s: Sheath, i: int, tau: wp.float64) -> tuple[wp.float64, wp.float64]:
    """τ behind guide i, which slides, from τ before it; its growth per growth before it."""
    row, w = s.guide + i, s.world
    constant = t.constant[row, w]
    if t.slip[row, w] > 0:
        gain = t.input_inverse[row, w]
        return (tau - constant) * gain, wp.float64(gain)
    ratio = t.output_ratio[row, w]
    return ratio * tau + constant, wp.float64(ratio)


@wp.func
def _advance_heads(t: Tendons, s: Sheath) -> bool:
    """One step of every run's equation for its first tension; whether that is the last one."""
    w = s.world
    solved = bool(True)
    first = int(0)
    head, tau = wp.float64(0.0), wp.float64(0.0)
    gain, most = wp.float64(1.0), wp.float64(1.0)
    missing, slope, curvature = wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)
    goes_on = bool(False)
    for k in range(s.guides + 1):
        came = bool(goes_on)
        goes_on = _slides(t, s, k)
        if came:
            tau, growth = _over(t, s, k - 1, tau)
            gain *= growth
            most = wp.max(most, gain)
        else:
            first = int(k)
            tau = wp.float64(t.tension[s.segment + k, w])
            if goes_on and not tau > ZERO:
                tau = wp.float64(1e-6)
            head = wp.float64(tau)
            gain, most = wp.float64(1.0), wp.float64(1.0)
            missing, slope, curvature = wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)
        is_known = (first == k and not goes_on) or (first == 0 and s.given)
        if not is_known:
            holds, falls, inverse = held(t, s, k, tau)
            missing += holds - t.kept[s.segment + k, w]
            slope += gain * falls
            curvature -= gain * gain * wp.float64(2.0) * falls * inverse
        if not (goes_on or is_known):
            change = -missing / slope
            change /= ONE + wp.float64(0.5) * change * curvature / slope
            t.tension[s.segment + first, w] = head + change
            # the largest tension's error is of the order of the cube of its step
            most *= wp.abs(change)
            solved = solved and most * most * most <= wp.float64(1e-17)
    return solved


@wp.func
def _follow_heads(t: Tendons, s: Sheath) -> bool:
    """Tensions of all segments from the first of each run; whether all are in range."""
    w = s.world
    in_range = bool(True)
    may_be_slack = bool(False)
    tau = wp.float64(0.0)
    for k in range(s.guides + 1):
        row = s.segment + k
        if _slides(t, s, k - 1):
            tau, _ = _over(t, s, k - 1, tau)
        else:
            # a slack segment between guides that hold is right where the input is given
            may_be_slack = s.given and (k == 0 or not _slides(t, s, k))
            tau = wp.float64(t.tension[row, w])
        t.tension[row, w] = tau
        taut = tau > ZERO and tau < _LARGEST
        in_range = in_range and (taut or (may_be_slack and tau == ZERO))
    return in_range


@wp.func
def _set_flows(t: Tendons, s: Sheath) -> bool:
    """Flows that the tensions need; whether they agree, to rounding, with the guides' slip."""
    w = s.world
    agrees = bool(True)
    passed = wp.float64(0.0)
    for back in range(s.guides):
        k = s.guides - back
        row, segment = s.guide + k - 1, s.segment + k
        slip = int(t.slip[row, w])
        left, right = wp.float64(t.tension[segment - 1, w]), wp.float64(t.tension[segment, w])
        flow = wp.float64(0.0)
        if slip == 0:
            passed = wp.float64(0.0)
            holds_left = left <= highest(t, s, k - 1, right) + TOLERANCE
            most = t.output_ratio[row, w] * left + t.constant[row, w] + TOLERANCE
            agrees = agrees and holds_left and right <= most
        else:
            holds, _, _ = held(t, s, k, right)
            passed += t.kept[segment, w] - holds
            flow = wp.float64(passed)
            near, beyond = t.length[segment - 1, w], t.length[segment, w]
            if left + right == ZERO and wp.abs(flow) < TOLERANCE * near:
                flow = wp.float64(0.0)  # a slack tendon that rounding would move
            elif not flow * wp.float64(slip) >= ZERO:  # nor if it is not a number
                if _is_frictionless(t, s, k - 1):
                    t.slip[row, w] = -slip  # nothing rubs: either direction will do
                elif wp.abs(flow) < TOLERANCE * wp.min(near, beyond):
                    flow = wp.float64(0.0)
                else:
                    agrees = False
        t.flow[row, w] = flow
    return agrees


@wp.func
def _follow_pattern(t: Tendons, s: Sheath) -> bool:
    """Tensions and flows for the guides' slip; whether they are the solution."""
    for k in range(s.guides + 1):
        given = s.given and k == 0
        if not (given or _slides(t, s, k - 1) or _slides(t, s, k)):
            t.tension[s.segment + k, s.world] = t.alone[s.segment + k, s.world]
    step = int(0)
    solved = bool(False)
    while step < _STEPS and not solved:
        solved = _advance_heads(t, s)
        step += 1
    if not solved:
        return False
    if not _follow_heads(t, s):
        return False
    return _set_flows(t, s)


@wp.func
def _balance(t: Tendons, s: Sheath) -> bool:
    """Equilibrium for given holding ratios: the slip of the last step, or what breakpoints find."""
    if not s.given:
        if lies_slack(t, s):
            return True
    within = wp.float64(_NEAR)
    attempt = int(0)
    while attempt < 3:
        if attempt > 0:
            if not find_slip(t, s, within):
                return False
            within = wp.float64(SETTLED)
        if attempt < 2:
            if _follow_pattern(t, s):
                return True
        attempt += 1
    return set_flows(t, s)


@wp.func
def _release(t: Tendons, s: Sheath) -> bool:
    """Return whether a guide broke loose that was at rest; it slides at μ_d from here on."""
    w = s.world
    released = bool(False)
    for i in range(s.guides):
        row = s.guide + i
        dynamic, slip = t.dynamic_ratio[row, w], t.slip[row, w]
        if slip > 0 and t.input_ratio[row, w] > dynamic:
            t.input_ratio[row, w] = dynamic
            t.input_inverse[row, w] = ONE / dynamic
            released = True
        elif slip < 0 and t.output_ratio[row, w] > dynamic:
            t.output_ratio[row, w] = dynamic
            t.output_inverse[row, w] = ONE / dynamic
            released = True
    return released


@wp.func
def _is_bounded(t: Tendons, s: Sheath) -> bool:
    """Return whether every tension has a bound; if one has none it is inf, and nothing flows."""
    w = s.world
    bounded = bool(True)
    for j in range(s.guides + 1):
        if not wp.isfinite(t.tension[s.segment + j, w]):
            t.tension[s.segment + j, w] = wp.float64(wp.inf)
            bounded = False
    if not bounded:
        for i in range(s.guides):
            t.flow[s.guide + i, w] = ZERO
            t.slip[s.guide + i, w] = t.previous_slip[s.guide + i, w]
    return bounded


@wp.func
def solve_flow(t: Tendons, s: Sheath) -> bool:
    """Solve for tensions and flows such that every guide either holds or slides by its law.

    ``tension`` holds a guess on entry, ``slip`` that of the last step; they and ``flow`` receive
    the result.

    Returns:
        False if the result is not the solution. The flow is then the best that was found, or 0
        if there is none.
    """
    for i in range(s.guides):
        t.flow[s.guide + i, s.world] = ZERO
    if s.given:
        _guess_from_motion(t, s)
    solved = bool(False)
    tries = 1 + 2 * s.guides
    while tries > 0:
        solved = _balance(t, s)
        tries -= 1
        released = bool(False)
        if solved:
            released = _release(t, s)
        if not released:
            tries = 0
    return _is_bounded(t, s) and solved
