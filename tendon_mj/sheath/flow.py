"""One time step of a tendon in its sheath: how much of it flows over each guide.

Guide i sits between segment i (input side) and i+1 (output side). At rest it holds as long as
T_{i+1} e^{−μ_s φ} ≤ T_i ≤ T_{i+1} e^{μ_s φ}; once it moves it slides at μ_d. A guide that breaks
loose within the step therefore drops to μ_d and may take others with it: rounds are repeated until
no guide breaks loose any more. Each round only ever frees guides, so there are at most 2n + 1.
"""

from __future__ import annotations

import math

from tendon_mj.sheath.compiled import compiled
from tendon_mj.sheath.pattern import try_pattern
from tendon_mj.sheath.sweep import Array, sweep

_PASSES = 24  # pattern corrections before the sweep, which needs none, takes over


@compiled
def _balance(
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
    """Equilibrium for given holding ratios: the known pattern if it serves, else the sweep."""
    for _ in range(_PASSES):
        changed = try_pattern(
            length, give, offset, a, stored, up, down, constant, tension, flow, slip
        )
        if changed == 0:
            return True
        if changed < 0:
            break
    return sweep(
        length, give, offset, a, stored, up, down, constant, alone, tension, flow, slip
    )


@compiled
def settle(
    length: Array,
    give: Array,
    offset: Array,
    a: float,
    stored: Array,
    static: Array,
    dynamic: Array,
    constant: Array,
    was_sliding: Array,
    up: Array,
    down: Array,
    alone: Array,
    tension: Array,
    flow: Array,
    slip: Array,
) -> bool:
    """Let the tendon flow until every guide either holds or slides by its law.

    Args:
        length, give, offset, a, stored: the n+1 segments, see ``segments`` [m].
        static, dynamic: (n,) e^{μ_s φ} and e^{μ_d φ} of each guide [-].
        constant: (n,) tension-independent friction of each guide over EA [-].
        was_sliding: (n,) slip at the end of the step before: +1, 0, −1.
        up, down, alone: (n,), (n,), (n+1,) work space.
        tension: (n+1,) T/EA [-]; a guess on entry, the result on return.
        flow: (n,) unstretched length that passes each guide towards the input in this step [m].
        slip: (n,) direction of that flow.

    Returns:
        False where the result is not the solution. ``flow`` is then the best that was found, or 0
        where there is none.
    """
    guides = static.shape[0]
    two_coefficients = False
    for i in range(guides):
        up[i] = dynamic[i] if was_sliding[i] > 0.0 else static[i]
        down[i] = dynamic[i] if was_sliding[i] < 0.0 else static[i]
        free = constant[i] == 0.0 and static[i] == 1.0
        slip[i] = 1.0 if free else was_sliding[i]
        two_coefficients |= static[i] != dynamic[i]
    solved = False
    for _ in range(2 * guides + 2):
        solved = _balance(
            length, give, offset, a, stored, up, down, constant, alone, tension, flow, slip
        )
        loosened = False
        if two_coefficients and solved:
            for i in range(guides):
                if slip[i] > 0.0 and up[i] > dynamic[i]:
                    up[i], loosened = dynamic[i], True
                elif slip[i] < 0.0 and down[i] > dynamic[i]:
                    down[i], loosened = dynamic[i], True
        if not loosened:
            break
    if not math.isfinite(tension[guides]):
        for i in range(guides):
            flow[i], slip[i] = 0.0, was_sliding[i]
    return solved
