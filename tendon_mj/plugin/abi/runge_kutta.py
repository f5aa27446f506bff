"""Inner stages of MuJoCo's Runge-Kutta integrator, seen from an evaluation."""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import double, integer

RK4 = 1  # mjINT_RK4


@compiled
def is_stage(layout: Layout, m: int, time: float, has_trial: float, trial_time: float) -> bool:
    """Whether this evaluation is an inner stage of Runge-Kutta, which must leave no trace."""
    if integer(m + layout.o_integrator, 0) != RK4 or has_trial == 0.0:
        return False
    h = double(m + layout.o_timestep, 0)
    since = time - trial_time
    return 0.25 * h < since < 1.25 * h
