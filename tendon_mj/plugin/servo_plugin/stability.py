"""The most damping of a servo that does not take it implicitly: one with a clock, or under RK4."""

from __future__ import annotations

import math

from tendon_mj.plugin.abi.runge_kutta import RK4

_RUNGE_KUTTA = 2.785293563405282  # where |1 + z + z²/2 + z³/6 + z⁴/24| = 1 on the negative axis


def largest_damping(timestep: float, integrator: int, period: float, delay: float) -> float:
    """Rate G_v/J [1/s] from which on damping makes the motor swing up instead; may be without end.

    Args:
        timestep: [s].
        integrator: MuJoCo's number of it.
        period: between samples of the controller [s]; 0: every time step.
        delay: from a sample to its torque [s].
    """
    if period > 0.0 or delay > 0.0:  # a torque changes on time steps only
        return sampled_damping(max(period, timestep), math.ceil(delay / timestep - 1e-6) * timestep)
    return _RUNGE_KUTTA / timestep if integrator == RK4 else math.inf


def sampled_damping(held: float, delay: float) -> float:
    """Like ``largest_damping`` where every torque is held for a while [1/s].

    v_{k+1} = v_k − g ((1 − m) v_{k−d} + m v_{k−d−1}) with g = held G_v/J and delay = (d + m) held:
    the least g for which a root lies on the unit circle, z = e^{iω}. That is 2/held without a delay
    and tends to π/(2 delay) with a long one.

    Args:
        held: [s].
        delay: from a sample to its torque [s].
    """
    whole = math.floor(delay / held + 1e-9)
    part = max(delay / held - whole, 0.0)

    def phase(angle: float) -> float:
        late = math.atan2(part * math.sin(angle), 1.0 - part + part * math.cos(angle))
        return (whole + 0.5) * angle + late - 0.5 * math.pi

    low, high = 0.0, math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if phase(middle) >= 0.0 else (middle, high)
    size = math.hypot(1.0 - part + part * math.cos(high), part * math.sin(high))
    return 2.0 * math.sin(0.5 * high) / (size * held)
