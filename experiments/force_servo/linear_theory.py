"""Linear theory of the servo while the whole tendon slides in one direction.

J_m θ̈ + G_v θ̇ = G_t r (T_r − T_out) with T_out = T_0 + K_t(±λ) (r θ − ξ_B): a second-order system of
ω² = K_t G_t r²/J_m and ζ = G_v/(2 r √(J_m K_t G_t)), different in each direction.

Source: Kaneko et al. 1991, eqs. (27)–(36), the G_v of (28).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.servo_bench import Servo
from tendon_mj import theory
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

# Factor on ω of the scheduled gains beyond what a step from rest requires: after a reversal the
# plain servo leaves the backlash with speed, and must not be faster there either.
_MARGIN = 1.3


@dataclass(frozen=True)
class Mode:
    """Second-order system that the servo is in one direction.

    Attributes:
        stiffness: K_t [N/m].
        frequency: ω [rad/s].
        damping: ζ [-].
        slope: ω/2ζ = K_t G_t r²/G_v, of the line ẋ₂ = 0 in the phase plane [1/s].
    """

    stiffness: float
    frequency: float
    damping: float
    slope: float


def transmission_stiffness(bench: Bench, direction: int) -> float:
    """K_t of the bench by the closed form [N/m]; direction +1 pulling, −1 loosening."""
    return float(
        theory.transmission_stiffness(
            direction * bench.exponent,
            bench.axial_stiffness,
            bench.length,
            bench.environment_stiffness,
            bench.sensor_stiffness,
        )
    )


def mode(bench: Bench, servo: Servo, direction: int) -> Mode:
    """Mode of the servo on the bench; direction +1 pulling, −1 loosening."""
    stiffness = transmission_stiffness(bench, direction)
    gain, brake = servo.tension_gain, servo.velocity_gain
    if direction < 0:
        gain = servo.loosening_tension_gain or gain
        brake = servo.loosening_velocity_gain or brake
    frequency = float(np.sqrt(stiffness * gain / servo.inertia) * servo.radius)
    damping = brake / (2.0 * servo.inertia * frequency)
    return Mode(stiffness, frequency, damping, stiffness * gain * servo.radius**2 / brake)


def with_damping(bench: Bench, servo: Servo, damping: float) -> Servo:
    """Servo with the G_v for which ζ is ``damping`` while pulling; 1 is critical."""
    brake = damping * 2.0 * servo.inertia * mode(bench, servo, 1).frequency
    return dataclasses.replace(servo, velocity_gain=float(brake))


def with_scheduled_gains(bench: Bench, servo: Servo) -> Servo:
    """Servo with loosening gains of ζ = 1 whose rise time is no longer than with its own gains.

    A critically damped response rises later than an overshooting one of the same ω, so ω is
    multiplied by the ratio of the two rise times, and by a margin.
    """
    plain = mode(bench, servo, -1)
    speedup = _MARGIN * rise_time(1.0) / rise_time(min(plain.damping, 1.0))
    frequency = speedup * plain.frequency
    gain = frequency**2 * servo.inertia / (plain.stiffness * servo.radius**2)
    return dataclasses.replace(
        servo,
        loosening_tension_gain=float(gain),
        loosening_velocity_gain=float(2.0 * servo.inertia * frequency),
    )


def step_error(damping: float, phase: FloatArray, speed: float = 0.0) -> FloatArray:
    """Error of a mode with ζ ≤ 1 after a unit step, over ``phase`` = ωt [-].

    It starts at error 1 with ``speed`` = −de/d(ωt).
    """
    damped = np.sqrt(max(1.0 - damping**2, 1e-12))  # frequency over ω
    cosine, sine = np.cos(damped * phase), np.sin(damped * phase) / damped
    return np.asarray(np.exp(-damping * phase) * (cosine + (damping - speed) * sine))


def rise_time(damping: float) -> float:
    """Time from 10 % to 90 % of a step, times ω [-]."""
    phase = np.linspace(0.0, 12.0, 24001)
    error = step_error(damping, phase)
    return float(phase[np.argmax(error <= 0.1)] - phase[np.argmax(error <= 0.9)])


def overshoot(damping: float, speed: float = 0.0) -> float:
    """Overshoot over the step [-]: e^{−πζ/√(1−ζ²)} from rest, more with an initial speed."""
    return float(max(0.0, -step_error(damping, np.linspace(0.0, 40.0, 80001), speed).min()))


def speed_after_backlash(
    bench: Bench, servo: Servo, direction: int, tension: float, step: float
) -> float:
    """Speed at which the motor leaves the backlash of a reversal, over ω times the step [-].

    In the backlash the output does not move and the motor follows J θ̈ + G_v θ̇ = G_t r ΔT.

    Args:
        bench, servo: parameters.
        direction: after the reversal, +1 pulling, −1 loosening.
        tension: T_out at the reversal [N].
        step: ΔT of the reference [N].
    """
    ahead = mode(bench, servo, direction)
    gap = theory.reversal_backlash(bench.exponent, tension, bench.axial_stiffness, bench.length)
    # travel as a share of that of the whole step, time in 1/ω
    width = float(gap) * ahead.stiffness / step
    rate, lag = 0.5 / ahead.damping, 0.5 / ahead.damping
    phase = np.linspace(0.0, 20.0 + width / rate, 200001)
    travel = rate * (phase - lag * -np.expm1(-phase / lag))
    return float(rate * -np.expm1(-phase[np.argmax(travel >= width)] / lag))
