"""The flow problem solved by a root search in each segment, as an independent truth: O(n²).

Cut the tendon behind segment j and ask which tension τ*_j its last segment would take alone. The
full tendon's tension there is τ_j = clip(τ*_j, lowest, highest), the two bounds being what guide j
allows against τ_{j+1}. So a walk forward finds every τ*_j, a walk backward the tensions. The
missing length of the prefix, G_j(τ) = Σ_{k≤j} (s_k(τ_k) − stored_k), falls with τ, hence one root;
it is bracketed and cannot be missed. This is the argument by which fused regression problems are
solved by dynamic programming, with friction bounds in the place of a fusion penalty.

Where the input tension is given, the length of the first segment is not constrained, so that no
τ*_j leaves the bounds of the guides before it.

Equations: docs/theory.md, section 4.
"""

import numpy as np
from numba import njit

from tendon_mj.sheath.records import ROUNDING
from tendon_mj.sheath.segment_law import held, tension_of

compiled = njit(error_model="numpy")
held, tension_of = compiled(held), compiled(tension_of)
_TOUCHING = 1e-12  # relative distance at which a tension counts as being at its bound
_ROUNDED = 16 * ROUNDING  # and where the input is given, which stiffer tendons have: τ is smaller
_SLACK = 1e-14  # normalised tension at the input below which a prefix counts as slack
_ITERATIONS = 200  # Newton needs about 4; bisection from the widest bracket about 110


@compiled
def highest(guides, i, right):
    """Largest τ that guide i holds on its input side against ``right``."""
    return guides[i].input_ratio * right + guides[i].constant_friction


@compiled
def lowest(guides, i, right):
    """Smallest τ that guide i holds on its input side against ``right``."""
    constant = guides[i].constant_friction
    # the rounding of a difference must not make a slack segment taut
    if right > constant * (1.0 + _TOUCHING):
        return (right - constant) / guides[i].output_ratio
    return 0.0


@compiled
def _missing(segments, prefix, guides, j, tau, first):
    """G_j(τ) [m] and its slope: what segments ``first`` to j lack when j is at τ.

    Where the input is given, segments at the most or least that it allows them take from it what
    they lack: j need not give any, though rounding puts τ's bound beyond their tension.
    """
    total, slope, gain = 0.0, 0.0, 1.0
    touching = ROUNDING * j if first > 0 else 0.0
    for k in range(j, -1, -1):
        holds, falls, _ = held(segments, k, tau)
        total += holds - segments[k].stored
        slope += gain * falls
        if k == first:
            break
        low, high = lowest(guides, k - 1, tau), highest(guides, k - 1, tau)
        if prefix[k - 1] > high * (1.0 + touching):
            tau, gain = high, gain * guides[k - 1].input_ratio
        elif prefix[k - 1] < low * (1.0 - touching):
            tau, gain = low, gain / guides[k - 1].output_ratio
        else:
            break
    return total, slope


@compiled
def _gain(guides, j, first):
    """How much larger than segment j's tension that of segment ``first`` can be."""
    gain = 1.0
    for k in range(first, j):
        gain *= guides[k].input_ratio
    return gain


@compiled
def _prefix_tension(segments, prefix, guides, j):
    """τ*_j: the root of G_j, 0 for a slack prefix, inf for one without tendon."""
    own = tension_of(segments, j)
    if j == 0:
        return own
    if lowest(guides, j - 1, own) <= prefix[j - 1] <= highest(guides, j - 1, own):
        return own
    total = 0.0
    for k in range(j + 1):
        total += segments[k].stored
    if total <= 0.0:
        return np.inf
    # not 0: only above it do the slack segments before this one give tendon
    low = _SLACK / _gain(guides, j, 0)
    if _missing(segments, prefix, guides, j, low, 0)[0] <= 0.0:
        return 0.0
    high = own if np.isfinite(own) and own > 0.0 else 1.0
    while _missing(segments, prefix, guides, j, high, 0)[0] > 0.0:
        low, high = high, 4.0 * high
        if high > 1e300:
            return np.inf
    return _root(segments, prefix, guides, j, low, high, 0)


@compiled
def _root(segments, prefix, guides, j, low, high, first):
    """Root of G_j between two tensions, from above by Newton's method."""
    tau = high
    rounding = ROUNDING / _gain(guides, j, first)  # a segment before this one multiplies it
    for _ in range(_ITERATIONS):
        value, slope = _missing(segments, prefix, guides, j, tau, first)
        if value > 0.0:
            low = tau
        else:
            high = tau
        step = tau - value / slope
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - tau) <= 1e-15 * tau + rounding or step in (low, high):
            # a bracket shut on a jump: the slack before it can give any amount at `low`
            return low if high - low <= 1e-14 * high + 2.0 * rounding else step
        tau = step
    return tau


@compiled
def _prefix_tension_within(segments, prefix, guides, j, low, high: float):
    """τ*_j where the input tension is given, which all guides together allow from low to high."""
    own = tension_of(segments, j)
    before = prefix[j - 1]
    if lowest(guides, j - 1, own) <= before <= highest(guides, j - 1, own):
        return own
    if _missing(segments, prefix, guides, j, low, 1)[0] <= 0.0:
        return low
    if _missing(segments, prefix, guides, j, high, 1)[0] >= 0.0:
        return high
    return _root(segments, prefix, guides, j, low, high, 1)


@compiled
def _fill_prefix_tensions(segments, prefix, guides, given):
    """Walk forward: τ*_j of every segment."""
    low = high = segments[0].tension
    for j in range(len(segments)):
        if not given:
            prefix[j] = _prefix_tension(segments, prefix, guides, j)
        elif j == 0:
            prefix[0] = low
        else:
            constant = guides[j - 1].constant_friction
            low = max(0.0, low - constant) / guides[j - 1].input_ratio
            high = guides[j - 1].output_ratio * high + constant
            prefix[j] = _prefix_tension_within(segments, prefix, guides, j, low, high)


@compiled
def _set_slack(segments, guides):
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


@compiled
def _flow_at(segments, prefix, guides, j, beyond, rounded):
    """Length that passes guide j towards the input, ``beyond`` being what passes the next one."""
    right = segments[j + 1].tension
    passed = segments[j + 1].stored + beyond - held(segments, j + 1, right)[0]
    high, low = highest(guides, j, right), lowest(guides, j, right)
    if right == 0.0:  # slack: it keeps what it holds, unless a neighbour needs it
        if prefix[j] > high * (1.0 + _TOUCHING):
            passed = _missing(segments, prefix, guides, j, high, 0)[0]
        else:
            passed = min(0.0, passed)
    tau = segments[j].tension
    if passed > 0.0 and tau >= high * (1.0 - _TOUCHING) - rounded:
        return passed
    if passed < 0.0 and tau <= low * (1.0 + _TOUCHING) + rounded:
        return passed
    return 0.0


@compiled
def _holds(segments, guides, first):
    """Whether every segment ends with the length of its tension, a slack one with at least that.

    Where friction multiplies a tension that is at most rounding, the whole tendon's counts.
    """
    last = len(guides)
    passed = guides[0].flow if first > 0 and last > 0 else 0.0
    rounded = 0.0
    for j in range(first, last + 1):
        rounded += _ROUNDED * segments[j].stored
    for j in range(first, last + 1):
        beyond = guides[j].flow if j < last else 0.0
        kept = segments[j].stored + beyond - passed
        passed = beyond
        needed, slope, _ = held(segments, j, segments[j].tension)
        tolerance = _TOUCHING * (abs(needed) + abs(beyond) + abs(kept - segments[j].stored))
        tolerance += rounded
        if first > 0:
            tolerance -= _ROUNDED * slope
        if kept < needed - tolerance:
            return False
        if kept > needed + tolerance and segments[j].tension > 0.0:
            return False
    return True


@compiled
def sweep(segments, guides, given=False):
    """Tensions, flows and slip of the whole tendon by the walk forward and back.

    ``given``: whether the tension of the first segment is. Returns False without a solution: no
    tendon is left between the ends, or tension-independent friction keeps a stretch slack from
    which its neighbours then need too much.
    """
    if not given and _set_slack(segments, guides):
        return True
    last = len(guides)
    prefix = np.empty(len(segments))
    _fill_prefix_tensions(segments, prefix, guides, given)
    segments[last].tension = prefix[last]
    if not np.isfinite(segments[last].tension):
        return False
    beyond = 0.0
    for j in range(last - 1, -1, -1):
        right = segments[j + 1].tension
        low, high = lowest(guides, j, right), highest(guides, j, right)
        segments[j].tension = min(max(prefix[j], low), high)
        beyond = _flow_at(segments, prefix, guides, j, beyond, _ROUNDED if given else 0.0)
        guides[j].flow = beyond
        guides[j].slip = np.sign(beyond)
    if given:  # rounding apart, the walk back has left it
        segments[0].tension = prefix[0]
    return _holds(segments, guides, 1 if given else 0)
