"""Solver of one time step: tensions of the segments and flow of tendon over each guide.

The same as `tendon_mj.sheath.tension_solver`, without drag.
"""

import warp as wp

from tendon_mj.warp.slip_pattern import guess_from_motion, try_pattern
from tendon_mj.warp.sweep import sweep
from tendon_mj.warp.tendons import Sheath, Tendons

wp.set_module_options({"enable_backward": False})

_PASSES = wp.constant(16)


@wp.func
def _balance(t: Tendons, s: Sheath) -> bool:
    """Equilibrium for given holding ratios: the known pattern if it serves, else the sweep."""
    for _ in range(_PASSES + s.guides):
        changed = try_pattern(t, s)
        if changed == 0:
            return True
        if changed < 0:
            break
    return sweep(t, s)


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
        guess_from_motion(t, s)
    solved = bool(False)
    for _ in range(1 + 2 * s.guides):
        solved = _balance(t, s)
        if not (stiction and solved):
            break
        if not _release(t, s):
            break
    return _is_bounded(t, s) and solved
