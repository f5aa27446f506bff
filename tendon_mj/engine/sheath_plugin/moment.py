"""What an evaluation must know of the moment in which MuJoCo calls it."""

from __future__ import annotations

from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import byte, double, doubles, integer, pointer

RK4 = 1  # mjINT_RK4


@compiled
def is_stage(layout: Any, m: int, time: float, on_trial: float, trial_time: float) -> bool:
    """Whether this evaluation is an inner stage of Runge-Kutta, which must leave no trace."""
    if integer(m + layout.o_integrator, 0) != RK4 or on_trial == 0.0:
        return False
    h = double(m + layout.o_timestep, 0)
    since = time - trial_time
    return 0.25 * h < since < 1.25 * h


@compiled
def control(layout: Any, m: int, d: int, actuator: int) -> float:
    """The control of an actuator, within its range; 0 where there is no actuator."""
    if actuator < 0:
        return 0.0
    adr = integer(pointer(m + layout.m_actuator_ctrladr), actuator)
    value = double(pointer(d + layout.d_ctrl), adr)
    if byte(pointer(m + layout.m_actuator_ctrllimited), adr):
        limits = doubles(pointer(m + layout.m_actuator_ctrlrange) + 16 * adr, 2)
        value = min(max(value, limits[0]), limits[1])
    return value
