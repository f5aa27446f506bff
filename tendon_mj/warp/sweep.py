"""The flow problem solved by one sweep along the tendon: exact, O(n²) in the worst case.

The same as in `tendon_mj.sheath`, where the method is explained; the tests hold one against the
other.
"""

import warp as wp

from tendon_mj.warp.tendons import Sheath, Tendons, held, highest, lowest, slope_of, tension_of

wp.set_module_options({"enable_backward": False})

_TOUCHING = wp.constant(wp.float64(1e-12))
_ROUNDING = wp.constant(wp.float64(5e-16))
_ROUNDED = wp.constant(wp.float64(8e-15))
_SLACK = wp.constant(wp.float64(1e-14))
_HUGE = wp.constant(wp.float64(1e300))
_ITERATIONS = wp.constant(200)


@wp.func
def _missing(
    t: Tendons, s: Sheath, j: int, at: wp.float64, first: int
) -> tuple[wp.float64, wp.float64]:
    """G_j(τ) [m] and its slope: missing length of segments ``first`` to j when j is at τ.

    Where the input is given, segments at the most or least that it allows them take from it what
    they lack: nothing is asked of j then, though rounding puts τ's bound beyond their tension.
    """
    w = s.world
    touching = wp.where(first > 0, _ROUNDING * wp.float64(j), wp.float64(0.0))
    total = wp.float64(0.0)
    slope = wp.float64(0.0)
    gain = wp.float64(1.0)
    tau = wp.float64(at)
    k = int(j)
    while k >= first:
        holds = held(t, s, k, tau)
        total += holds - t.kept[s.segment + k, w]
        slope += gain * slope_of(t, s, k, tau, holds)
        k -= 1
        if k >= first:
            low, high = lowest(t, s, k, tau), highest(t, s, k, tau)
            prefix = t.prefix[s.segment + k, w]
            if prefix > high * (wp.float64(1.0) + touching):
                tau = high
                gain *= t.input_ratio[s.guide + k, w]
            elif prefix < low * (wp.float64(1.0) - touching):
                tau = low
                gain /= t.output_ratio[s.guide + k, w]
            else:
                k = -1
    return total, slope


@wp.func
def _gain(t: Tendons, s: Sheath, j: int, first: int) -> wp.float64:
    """How much larger than segment j's tension that of segment ``first`` can be."""
    gain = wp.float64(1.0)
    for k in range(first, j):
        gain *= t.input_ratio[s.guide + k, s.world]
    return gain


@wp.func
def _root(
    t: Tendons, s: Sheath, j: int, below: wp.float64, above: wp.float64, first: int
) -> wp.float64:
    """Root of G_j between two tensions, from above by Newton's method."""
    low = wp.float64(below)
    high = wp.float64(above)
    tau = wp.float64(above)
    rounding = _ROUNDING / _gain(t, s, j, first)  # a segment before this one multiplies it
    for _ in range(_ITERATIONS):
        value, slope = _missing(t, s, j, tau, first)
        if value > wp.float64(0.0):
            low = tau
        else:
            high = tau
        step = tau - value / slope
        if not (low < step and step < high):
            step = wp.float64(0.5) * (low + high)
        close = wp.abs(step - tau) <= wp.float64(1e-15) * tau + rounding
        if close or step == low or step == high:
            # a bracket shut on a jump: the slack before it can spare any amount at `low`
            if high - low <= wp.float64(1e-14) * high + wp.float64(2.0) * rounding:
                return low
            return step
        tau = step
    return tau


@wp.func
def _prefix_tension(t: Tendons, s: Sheath, j: int) -> wp.float64:
    """τ*_j: the root of G_j, 0 for a slack prefix, inf for one without tendon."""
    w = s.world
    own = tension_of(t, s, j)
    if j == 0:
        return own
    before = t.prefix[s.segment + j - 1, w]
    if lowest(t, s, j - 1, own) <= before and before <= highest(t, s, j - 1, own):
        return own
    total = wp.float64(0.0)
    for k in range(j + 1):
        total += t.kept[s.segment + k, w]
    if total <= wp.float64(0.0):
        return wp.float64(wp.inf)
    # not 0: only above it do the slack segments before this one spare tendon
    low = _SLACK / _gain(t, s, j, 0)
    value, _ = _missing(t, s, j, low, 0)
    if value <= wp.float64(0.0):
        return wp.float64(0.0)
    high = wp.float64(1.0)
    if wp.isfinite(own) and own > wp.float64(0.0):
        high = own
    value, _ = _missing(t, s, j, high, 0)
    while value > wp.float64(0.0):
        low = high
        high = wp.float64(4.0) * high
        if high > _HUGE:
            return wp.float64(wp.inf)
        value, _ = _missing(t, s, j, high, 0)
    return _root(t, s, j, low, high, 0)


@wp.func
def _prefix_tension_within(
    t: Tendons, s: Sheath, j: int, low: wp.float64, high: wp.float64
) -> wp.float64:
    """τ*_j where the input tension is given, which all guides together allow from low to high."""
    own = tension_of(t, s, j)
    before = t.prefix[s.segment + j - 1, s.world]
    if lowest(t, s, j - 1, own) <= before and before <= highest(t, s, j - 1, own):
        return own
    value, _ = _missing(t, s, j, low, 1)
    if value <= wp.float64(0.0):
        return low
    value, _ = _missing(t, s, j, high, 1)
    if value >= wp.float64(0.0):
        return high
    return _root(t, s, j, low, high, 1)


@wp.func
def _fill_prefix_tensions(t: Tendons, s: Sheath) -> None:
    """Walk forward: τ*_j of every segment."""
    w = s.world
    low = wp.float64(t.tension[s.segment, w])
    high = wp.float64(t.tension[s.segment, w])
    for j in range(s.guides + 1):
        row = s.segment + j
        if not s.given:
            t.prefix[row, w] = _prefix_tension(t, s, j)
        elif j == 0:
            t.prefix[row, w] = low
        else:
            guide = s.guide + j - 1
            constant = t.constant[guide, w]
            low = wp.max(wp.float64(0.0), low - constant) / t.input_ratio[guide, w]
            high = t.output_ratio[guide, w] * high + constant
            t.prefix[row, w] = _prefix_tension_within(t, s, j, low, high)


@wp.func
def _set_slack(t: Tendons, s: Sheath) -> bool:
    """Lay a tendon longer than its path evenly along it, without tension; False for a taut one."""
    w = s.world
    path = wp.float64(0.0)
    total = wp.float64(0.0)
    for k in range(s.guides + 1):
        path += t.length[s.segment + k, w]
        total += t.kept[s.segment + k, w]
    if total < path:
        return False
    passed = wp.float64(0.0)
    t.tension[s.segment + s.guides, w] = wp.float64(0.0)
    for k in range(s.guides):
        passed += t.length[s.segment + k, w] / path * total - t.kept[s.segment + k, w]
        t.tension[s.segment + k, w] = wp.float64(0.0)
        t.flow[s.guide + k, w] = passed
        t.slip[s.guide + k, w] = _sense(passed)
    return True


@wp.func
def _sense(flow: wp.float64) -> int:
    """+1, −1, or 0 where nothing flows."""
    return wp.where(flow > wp.float64(0.0), 1, wp.where(flow < wp.float64(0.0), -1, 0))


@wp.func
def _flow_at(t: Tendons, s: Sheath, j: int, beyond: wp.float64) -> wp.float64:
    """Length that passes guide j towards the input, ``beyond`` being the flow over the next one."""
    row, w = s.segment + j, s.world
    right = t.tension[row + 1, w]
    passed = t.kept[row + 1, w] + beyond - held(t, s, j + 1, right)
    high, low = highest(t, s, j, right), lowest(t, s, j, right)
    if right == wp.float64(0.0):  # slack: it keeps its length, unless a neighbour needs it
        if t.prefix[row, w] > high * (wp.float64(1.0) + _TOUCHING):
            passed, _ = _missing(t, s, j, high, 0)
        else:
            passed = wp.min(wp.float64(0.0), passed)
    rounded = wp.where(s.given, _ROUNDED, wp.float64(0.0))
    tau = t.tension[row, w]
    to_input = tau >= high * (wp.float64(1.0) - _TOUCHING) - rounded
    to_output = tau <= low * (wp.float64(1.0) + _TOUCHING) + rounded
    if (passed > wp.float64(0.0) and to_input) or (passed < wp.float64(0.0) and to_output):
        return passed
    return wp.float64(0.0)


@wp.func
def _holds(t: Tendons, s: Sheath) -> bool:
    """Whether every segment ends with the length of its tension, a slack one with at least that."""
    w = s.world
    first = wp.where(s.given, 1, 0)
    passed = wp.float64(0.0)
    if s.given and s.guides > 0:
        passed = t.flow[s.guide, w]
    rounded = wp.float64(0.0)
    for j in range(first, s.guides + 1):
        rounded += _ROUNDED * t.kept[s.segment + j, w]
    for j in range(first, s.guides + 1):
        row = s.segment + j
        beyond = wp.float64(0.0)
        if j < s.guides:
            beyond = t.flow[s.guide + j, w]
        had = t.kept[row, w]
        kept = had + beyond - passed
        passed = beyond
        needed = held(t, s, j, t.tension[row, w])
        tolerance = rounded + _TOUCHING * (wp.abs(needed) + wp.abs(beyond) + wp.abs(kept - had))
        if s.given:
            tolerance -= _ROUNDED * slope_of(t, s, j, t.tension[row, w], needed)
        if kept < needed - tolerance:
            return False
        if kept > needed + tolerance and t.tension[row, w] > wp.float64(0.0):
            return False
    return True


@wp.func
def sweep(t: Tendons, s: Sheath) -> bool:
    """Tensions, flows and slip of the whole tendon by the walk forward and back.

    Returns:
        False if no solution was found.
    """
    w = s.world
    if not s.given and _set_slack(t, s):
        return True
    _fill_prefix_tensions(t, s)
    end = s.segment + s.guides
    t.tension[end, w] = t.prefix[end, w]
    if not wp.isfinite(t.tension[end, w]):
        return False
    beyond = wp.float64(0.0)
    for back in range(s.guides):
        j = s.guides - 1 - back
        row = s.segment + j
        right = t.tension[row + 1, w]
        low, high = lowest(t, s, j, right), highest(t, s, j, right)
        t.tension[row, w] = wp.min(wp.max(t.prefix[row, w], low), high)
        beyond = _flow_at(t, s, j, beyond)
        t.flow[s.guide + j, w] = beyond
        t.slip[s.guide + j, w] = _sense(beyond)
    if s.given:  # rounding apart, the walk back has left it
        t.tension[s.segment, w] = t.prefix[s.segment, w]
    return _holds(t, s)
