"""The flow problem of a whole tendon, in a number of operations that its guides bound.

The same as in `tendon_mj.sheath`, where the method is explained; the tests hold one against the
other. The two stacks of breakpoints grow from both ends of a sheath's rows: together they never
hold more than two for each guide.
"""

import warp as wp

from tendon_mj.warp.tendons import INF, ONE, TWO, ZERO, Sheath, Tendons, held

wp.set_module_options({"enable_backward": False})

_ROUNDS = wp.constant(64)
_FARTHEST = wp.constant(wp.float64(16.0))  # scale of a map
_HUGE = wp.constant(wp.float64(1e100))
SETTLED = wp.constant(wp.float64(1e-16))  # error of a tension over the largest
TOUCHING = wp.constant(wp.float64(1e-12))
TOLERANCE = wp.constant(wp.float64(4e-15))


@wp.func
def highest(t: Tendons, s: Sheath, i: int, right: wp.float64) -> wp.float64:
    """Largest τ that guide i holds on its input side against ``right``."""
    row, w = s.guide + i, s.world
    return t.input_ratio[row, w] * right + t.constant[row, w]


@wp.func
def lowest(t: Tendons, s: Sheath, i: int, right: wp.float64) -> wp.float64:
    """Smallest τ that guide i holds on its input side against ``right``."""
    row, w = s.guide + i, s.world
    constant = t.constant[row, w]
    # the rounding of a difference must not make a slack segment taut
    if right > constant * (ONE + TOUCHING):
        return (right - constant) * t.output_inverse[row, w]
    return ZERO


@wp.struct
class Stack:
    """Breakpoints on one side of a root, the nearest on top, and their map τ → scale τ + shift."""

    bottom: wp.int32  # row
    step: wp.int32  # from a row to the next
    count: wp.int32
    scale: wp.float64
    inverse: wp.float64  # of the scale
    shift: wp.float64


@wp.func
def _unmapped(bottom: int, step: int, count: int) -> Stack:
    """A stack whose breakpoints are where its rows have them."""
    stack = Stack()
    stack.bottom = bottom
    stack.step = step
    stack.count = count
    stack.scale = ONE
    stack.inverse = ONE
    return stack


@wp.func
def _mapped(
    t: Tendons, s: Sheath, stack: Stack, scale: wp.float64, inverse: wp.float64, shift: wp.float64
) -> Stack:
    """The stack with every τ moved to scale τ + shift; slopes shrink as distances grow."""
    w = s.world
    stack.shift = scale * stack.shift + shift
    stack.scale = scale * stack.scale
    inverse *= stack.inverse
    stack.inverse = inverse * (TWO - stack.scale * inverse)
    if wp.max(stack.scale, stack.inverse) > _FARTHEST:
        for k in range(stack.count):
            row = stack.bottom + stack.step * k
            t.breakpoint[row, w] = stack.scale * t.breakpoint[row, w] + stack.shift
            t.bend[row, w] = t.bend[row, w] * stack.inverse
        return _unmapped(stack.bottom, stack.step, stack.count)
    return stack


@wp.func
def _pushed(
    t: Tendons, s: Sheath, stack: Stack, tau: wp.float64, bend: wp.float64, jump: wp.float64
) -> Stack:
    """The stack with one breakpoint more."""
    row, w = stack.bottom + stack.step * stack.count, s.world
    t.breakpoint[row, w] = (tau - stack.shift) * stack.inverse
    t.bend[row, w] = bend * stack.scale
    t.jump[row, w] = jump
    stack.count += 1
    return stack


@wp.func
def _search(
    t: Tendons,
    s: Sheath,
    side: wp.float64,
    start: wp.float64,
    bound: wp.float64,
    start_zero: wp.float64,
    start_slope: wp.float64,
    near: Stack,
    far: Stack,
) -> tuple[wp.float64, wp.vec2d, wp.vec2d, Stack, Stack]:
    """Root of G_j on the right of ``start`` (``side`` +1) or left of it (−1), at most at ``bound``.

    ``start_zero`` and ``start_slope`` are the value at 0 and the slope of the line on which G_j is
    at ``start``; ``near`` holds the breakpoints on that side. Returns the root, slope and value of
    G_j just before and just beyond it, seen from ``start``, and both stacks.
    """
    w = s.world
    tau, at_zero, slope = wp.float64(start), wp.float64(start_zero), wp.float64(start_slope)
    while True:
        at, bend, jump, left = wp.float64(bound), wp.float64(0.0), -side * INF, int(0)
        if near.count > 0:
            row = near.bottom + near.step * (near.count - 1)
            inner = near.scale * t.breakpoint[row, w] + near.shift
            if side * (inner - tau) <= TOUCHING * wp.abs(near.shift):
                inner = tau  # rounding moves it neither past that nor off a slack segment's 0
            if side * (inner - bound) < -TOUCHING * wp.abs(near.shift):
                at, bend, jump = inner, t.bend[row, w] * near.inverse, wp.float64(t.jump[row, w])
                left = near.count - 1
        value = at_zero + slope * at
        if side * value < ZERO:
            before = wp.vec2d(slope, ZERO)
            return -at_zero / slope, before, before, near, far
        near.count = left
        if not side * (value + jump) > ZERO:
            beyond = wp.vec2d(slope + bend, value + jump)
            return at, wp.vec2d(slope, value), beyond, near, far
        far = _pushed(t, s, far, at, -bend, -jump)
        tau, at_zero, slope = at, at_zero + jump - bend * at, slope + bend


@wp.func
def _walk_forward(t: Tendons, s: Sheath) -> None:
    """τ*_j of every segment, with tangents at its tension."""
    w = s.world
    left = _unmapped(2 * s.guide, 1, 0)
    right = _unmapped(2 * (s.guide + s.guides) - 1, -1, 0)
    least, most = wp.float64(0.0), wp.float64(INF)
    low, high = wp.float64(0.0), wp.float64(INF)
    first, root = int(0), wp.float64(0.0)
    before, beyond = wp.vec2d(), wp.vec2d()  # slope and value of G_j on the left and right of it
    if s.given:
        first, root = 1, wp.float64(t.tension[s.segment, w])
        least, most = wp.float64(root), wp.float64(root)
        t.prefix[s.segment, w] = root
    for j in range(first, s.guides + 1):
        row, guide = s.segment + j, s.guide + j - 1
        if j > 0:
            ratio, back = t.input_ratio[guide, w], t.output_ratio[guide, w]
            constant = t.constant[guide, w]
            inverse, inverse_back = t.input_inverse[guide, w], t.output_inverse[guide, w]
            left = _mapped(t, s, left, inverse, ratio, -constant * inverse)
            right = _mapped(t, s, right, back, inverse_back, constant)
            least = wp.max(ZERO, least - constant) * inverse
            most = most * back + constant
            low = (root - constant) * inverse
            high = root * back + constant
            if low > least and root > constant * (ONE + TOUCHING):
                left = _pushed(t, s, left, low, before[0] * ratio, before[1])
            else:
                low = wp.float64(least)
                left.count = 0
            if high < most:
                right = _pushed(t, s, right, high, beyond[0] * inverse_back, beyond[1])
            else:
                high = wp.float64(most)
                right.count = 0
        tau = wp.float64(t.tension[row, w])
        tau = wp.where(tau >= ZERO and tau <= _HUGE, tau, ZERO)
        holds, slope, _ = held(t, s, j, tau)
        value = holds - t.kept[row, w]
        root = tau - value / slope
        before, beyond = wp.vec2d(slope, ZERO), wp.vec2d(slope, ZERO)
        if root < low or root > high:
            side = wp.where(root > high, ONE, -ONE)
            start = wp.clamp(root, low, high)
            bound, near, far = least, left, right
            if side > ZERO:
                bound, near, far = most, right, left
            zero = value - slope * tau
            root, inner, outer, near, far = _search(
                t, s, side, start, bound, zero, slope, near, far
            )
            if side > ZERO:
                before, beyond, left, right = inner, outer, far, near
            else:
                before, beyond, left, right = outer, inner, near, far
        t.prefix[row, w] = root


@wp.func
def _walk_back(t: Tendons, s: Sheath) -> wp.float64:
    """Tensions and slip that follow from the τ*_j; about the error of one over the largest."""
    w = s.world
    most, largest = wp.float64(0.0), wp.float64(0.0)
    for back in range(s.guides + 1):
        j = s.guides - back
        row, guide = s.segment + j, s.guide + j
        tau = wp.float64(t.prefix[row, w])
        if j < s.guides:
            right = t.tension[row + 1, w]
            low, high = lowest(t, s, j, right), highest(t, s, j, right)
            t.slip[guide, w] = 0
            if tau > high * (ONE + TOUCHING):
                t.slip[guide, w] = 1
            elif tau < low * (ONE - TOUCHING):
                t.slip[guide, w] = -1
            tau = wp.min(wp.max(tau, low), high)
        if not (j == 0 and s.given):  # rounding apart, the walk has left that
            change = wp.abs(tau - t.tension[row, w])
            if not change <= wp.max(most, TOLERANCE):  # nor if it is not a number
                most = change
            largest = wp.max(largest, tau)
            t.tension[row, w] = tau
    return wp.where(most != ZERO, most * most / largest, ZERO)


@wp.func
def _lacking(t: Tendons, s: Sheath, j: int, first: int) -> wp.float64:
    """What the sliding run that ends with segment j lacks [m]."""
    w = s.world
    total = wp.float64(0.0)
    for back in range(j + 1 - first):
        k = j - back
        if t.slip[s.guide + k, w] == 0:
            break
        holds, _, _ = held(t, s, k, t.tension[s.segment + k, w])
        total += holds - t.kept[s.segment + k, w]
    return total


@wp.func
def _slip_at_bound(t: Tendons, s: Sheath, i: int, passed: wp.float64) -> int:
    """Direction in which guide i lets ``passed`` through; 0 if its tensions do not.

    If τ* is at the bound itself, on a jump, the flow is what is needed of that.
    """
    row, w = s.segment + i, s.world
    left, right = t.tension[row, w], t.tension[row + 1, w]
    if passed > ZERO and left >= highest(t, s, i, right) * (ONE - TOUCHING) - TOLERANCE:
        return 1
    least = t.output_ratio[s.guide + i, w] * left + t.constant[s.guide + i, w]  # of the right
    if passed < ZERO and (left <= TOLERANCE or right >= least * (ONE - TOUCHING) - TOLERANCE):
        return -1
    return 0


@wp.func
def set_flows(t: Tendons, s: Sheath) -> bool:
    """Flows over the guides; whether every segment ends with the length of its tension.

    A segment that is slack, to rounding, may end with more. It keeps what it has unless a neighbour
    needs it.
    """
    w = s.world
    first = wp.where(s.given, 1, 0)
    beyond, total, solved = wp.float64(0.0), wp.float64(0.0), bool(True)
    for j in range(s.guides + 1):
        total += wp.abs(t.kept[s.segment + j, w])
    for back in range(s.guides + 1 - first):
        j = s.guides - back
        row, guide = s.segment + j, s.guide + j - 1
        slip = int(0)
        if j > 0:
            slip = t.slip[guide, w]
        tau = t.tension[row, w]
        holds, slope, _ = held(t, s, j, tau)
        passed = t.kept[row, w] + beyond - holds
        if tau <= TOLERANCE:
            needed = wp.float64(0.0)
            if slip > 0:
                needed = wp.max(ZERO, _lacking(t, s, j - 1, first))
            if needed < passed:
                passed = wp.float64(needed)
                t.tension[row, w] = ZERO
        counts = total + wp.abs(beyond) - slope
        flows = passed * wp.float64(slip) > ZERO
        if j > 0 and not flows and wp.abs(passed) > TOLERANCE * counts:
            slip = _slip_at_bound(t, s, j - 1, passed)
        if not passed * wp.float64(slip) > ZERO:
            solved = solved and wp.abs(passed) <= TOUCHING * counts
            passed = wp.float64(0.0)
            slip = 0
        if j > 0:
            t.flow[guide, w] = passed
            t.slip[guide, w] = slip
        beyond = passed
    return solved


@wp.func
def _lie_slack(t: Tendons, s: Sheath, total: wp.float64, slack: wp.float64) -> None:
    """Spread a tendon of a length evenly along its path, whose length it has ``slack`` times."""
    w = s.world
    passed = wp.float64(0.0)
    t.tension[s.segment + s.guides, w] = ZERO
    for k in range(s.guides):
        row, guide = s.segment + k, s.guide + k
        passed += slack * t.length[row, w] - t.kept[row, w]
        t.tension[row, w] = ZERO
        flow = wp.where(wp.abs(passed) > TOLERANCE * total, passed, ZERO)
        t.flow[guide, w] = flow
        t.slip[guide, w] = wp.where(flow > ZERO, 1, wp.where(flow < ZERO, -1, 0))


@wp.func
def lies_slack(t: Tendons, s: Sheath) -> bool:
    """Return whether a tendon is longer than its path; it is spread evenly along it then."""
    path, total = wp.float64(0.0), wp.float64(0.0)
    for j in range(s.guides + 1):
        path += t.length[s.segment + j, s.world]
        total += t.kept[s.segment + j, s.world]
    if total < path:
        return False
    _lie_slack(t, s, total, total / path)
    return True


@wp.func
def _has_tendon(t: Tendons, s: Sheath) -> bool:
    """Return whether any is left between the ends."""
    total = wp.float64(0.0)
    for j in range(s.guides + 1):
        total += t.kept[s.segment + j, s.world]
    return total > ZERO


@wp.func
def find_slip(t: Tendons, s: Sheath, within: wp.float64) -> bool:
    """Tensions and slip for given holding ratios; the first tangents are at ``tension``.

    ``within`` is the error of a tension over the largest. Returns False if no tendon is left
    between the ends, or if rounding keeps the rounds from settling. The tensions are inf then.
    """
    if s.given or _has_tendon(t, s):
        for _ in range(_ROUNDS):
            _walk_forward(t, s)
            if _walk_back(t, s) <= within:
                return True
    for j in range(s.guides + 1):
        t.tension[s.segment + j, s.world] = INF
    return False
