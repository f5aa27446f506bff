"""The flow problem solved exactly by one sweep along the tendon: slow at worst, never wrong.

Cut the tendon behind segment j and ask which tension τ*_j its last segment would take alone. The
full tendon's tension there is τ_j = clip(τ*_j, lowest, highest), the two bounds being what guide j
allows against τ_{j+1}. So a walk forward finds every τ*_j, a walk backward the tensions. The
missing length of the prefix, G_j(τ) = Σ_{k≤j} (s_k(τ_k) − stored_k), falls with τ, hence one root;
it is bracketed and cannot be missed. This is the argument by which fused regression problems are
solved by dynamic programming, with friction bounds in the place of a fusion penalty.
"""

from __future__ import annotations

import numpy as np

from tendon_mj.sheath.compiled import compiled
from tendon_mj.sheath.segments import held, held_slope, tension_of

Array = np.ndarray[tuple[int], np.dtype[np.float64]]

_TOUCHING = 1e-12  # relative distance at which a tension counts as being at its bound
_SLACK = 1e-14  # normalised tension below which a prefix counts as slack
_ITERATIONS = 200  # Newton needs about 4; bisection from the widest bracket about 110


@compiled
def highest(right: float, up: float, constant: float) -> float:
    """Largest tension that a guide holds on its input side against ``right``."""
    return up * right + constant


@compiled
def lowest(right: float, down: float, constant: float) -> float:
    """Smallest tension that a guide holds on its input side against ``right``."""
    # the rounding of a difference must not make a slack segment taut
    return (right - constant) / down if right > constant * (1.0 + _TOUCHING) else 0.0


@compiled
def _missing(
    j: int,
    tau: float,
    alone: Array,
    length: Array,
    give: Array,
    offset: Array,
    a: float,
    stored: Array,
    up: Array,
    down: Array,
    constant: Array,
) -> tuple[float, float]:
    """G_j(τ) [m] and its slope: what the prefix up to segment j lacks when j is at τ."""
    total, slope, gain = 0.0, 0.0, 1.0
    for k in range(j, -1, -1):
        total += held(length[k], give[k], offset[k], a, tau) - stored[k]
        slope += gain * held_slope(length[k], give[k], offset[k], a, tau)
        if k == 0:
            break
        low, high = lowest(tau, down[k - 1], constant[k - 1]), highest(tau, up[k - 1], constant[k - 1])
        if alone[k - 1] > high:
            tau, gain = high, gain * up[k - 1]
        elif alone[k - 1] < low:
            tau, gain = low, gain / down[k - 1]
        else:
            break
    return total, slope


@compiled
def _alone(
    j: int,
    alone: Array,
    length: Array,
    give: Array,
    offset: Array,
    a: float,
    stored: Array,
    up: Array,
    down: Array,
    constant: Array,
) -> float:
    """τ*_j: the root of G_j, 0 for a slack prefix, inf for one without tendon."""
    own = tension_of(length[j], give[j], offset[j], a, stored[j])
    if j == 0:
        return own
    if lowest(own, down[j - 1], constant[j - 1]) <= alone[j - 1] <= highest(own, up[j - 1], constant[j - 1]):
        return own
    total = 0.0
    for k in range(j + 1):
        total += stored[k]
    if total <= 0.0:
        return np.inf
    low = _SLACK  # not 0: only above it do the slack segments before this one spare tendon
    if _missing(j, low, alone, length, give, offset, a, stored, up, down, constant)[0] <= 0.0:
        return 0.0
    high = own if np.isfinite(own) and own > 0.0 else 1.0
    while _missing(j, high, alone, length, give, offset, a, stored, up, down, constant)[0] > 0.0:
        low, high = high, 4.0 * high
        if high > 1e300:
            return np.inf
    tau = high
    for _ in range(_ITERATIONS):
        value, slope = _missing(j, tau, alone, length, give, offset, a, stored, up, down, constant)
        if value > 0.0:
            low = tau
        else:
            high = tau
        step = tau - value / slope
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - tau) <= 1e-15 * tau or step in (low, high):
            # a bracket shut on a jump: the slack before it can spare any amount at `low`
            return low if high - low <= 1e-14 * high else step
        tau = step
    return tau


@compiled
def _slack(
    length: Array, offset: Array, stored: Array, tension: Array, flow: Array, slip: Array
) -> bool:
    """Whether the tendon is longer than its path; it then lies evenly along it, without tension."""
    path, total = 0.0, 0.0
    for k in range(length.shape[0]):
        path += length[k] / (1.0 + offset[k])
        total += stored[k]
    if total < path:
        return False
    passed = 0.0
    tension[-1] = 0.0
    for k in range(flow.shape[0]):
        passed += length[k] / (1.0 + offset[k]) * (total / path) - stored[k]
        tension[k], flow[k], slip[k] = 0.0, passed, np.sign(passed)
    return True


@compiled
def sweep(
    length: Array,
    give: Array,
    offset: Array,
    a: float,
    stored: Array,
    up: Array,
    down: Array,
    constant: Array,
    alone: Array,
    tension: Array,
    flow: Array,
    slip: Array,
) -> bool:
    """Tensions, flows and slip of the whole tendon by the walk forward and back.

    Args:
        length, give, offset, a, stored: the n+1 segments, see ``segments`` [m].
        up, down: (n,) largest ratio input side/output side, and the inverse, at which a guide holds.
        constant: (n,) tension-independent part of the guide's friction, over EA [-].
        alone: (n+1,) work space.
        tension: (n+1,) result, T/EA [-].
        flow: (n,) result, unstretched length that passed each guide towards the input [m].
        slip: (n,) result, +1 towards the input, −1 towards the output, 0 at rest.

    Returns:
        False if no solution was found: no tendon is left between the ends, or tension-independent
        friction keeps a stretch of it slack that its neighbours then ask too much of.
    """
    last = length.shape[0] - 1
    if _slack(length, offset, stored, tension, flow, slip):
        return True
    for j in range(last + 1):
        alone[j] = _alone(j, alone, length, give, offset, a, stored, up, down, constant)
    tension[last] = alone[last]
    if not np.isfinite(tension[last]):
        return False
    beyond = 0.0
    for j in range(last - 1, -1, -1):
        low = lowest(tension[j + 1], down[j], constant[j])
        high = highest(tension[j + 1], up[j], constant[j])
        tension[j] = min(max(alone[j], low), high)
        passed = stored[j + 1] + beyond - held(length[j + 1], give[j + 1], offset[j + 1], a, tension[j + 1])
        if tension[j + 1] == 0.0:  # slack: it holds what it holds, unless a neighbour needs it
            if alone[j] > high * (1.0 + _TOUCHING):
                passed = _missing(j, high, alone, length, give, offset, a, stored, up, down, constant)[0]
            else:
                passed = min(0.0, passed)
        if passed > 0.0 and tension[j] >= high * (1.0 - _TOUCHING):
            slip[j] = 1.0
        elif passed < 0.0 and tension[j] <= low * (1.0 + _TOUCHING):
            slip[j] = -1.0
        else:
            slip[j], passed = 0.0, 0.0
        flow[j] = beyond = passed
    passed = 0.0
    for j in range(last + 1):  # what a slack segment was asked for, it must have had
        beyond = flow[j] if j < last else 0.0
        kept = stored[j] + beyond - passed
        passed = beyond
        if tension[j] == 0.0 and kept < held(length[j], give[j], offset[j], a, 0.0) * (1.0 - _TOUCHING):
            return False
    return True
