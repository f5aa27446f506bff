"""Controls of actuators as MuJoCo applies them."""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import byte, double, doubles, integer, pointer


@compiled
def control(layout: Layout, m: int, d: int, actuator: int) -> float:
    """Control of an actuator, within its range; 0 where there is no actuator."""
    if actuator < 0:
        return 0.0
    adr = integer(pointer(m + layout.m_actuator_ctrladr), actuator)
    value = double(pointer(d + layout.d_ctrl), adr)
    if byte(pointer(m + layout.m_actuator_ctrllimited), adr):
        limits = doubles(pointer(m + layout.m_actuator_ctrlrange) + 16 * adr, 2)
        value = min(max(value, limits[0]), limits[1])
    return value
