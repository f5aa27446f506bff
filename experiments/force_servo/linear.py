"""Linear theory of the servo: what it does while the whole tendon slides one way.

J_m θ̈ + G_v θ̇ = G_t r (T_r − T_out) with T_out = T_0 + K_t(±λ) (r θ − ξ_B): a second-order system of
ω² = K_t G_t r²/J_m and ζ = G_v/(2 r √(J_m K_t G_t)), another one for each direction.

Source: Kaneko et al. 1991, eqs. (27)–(36), the G_v of (28).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.bench import Servo
from tendon_mj import theory
from tendon_mj.builders.bench import Bench
from tendon_mj.replay.rollout import Array

# By which scheduled gains are faster than they need be from rest: after a reversal the plain servo
# comes out of the backlash with speed, and is not to be the faster one there either.
_MARGIN = 1.3


@dataclass(frozen=True)
class Mode:
    """The servo in one direction.

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


def transmission(bench: Bench, direction: int) -> float:
    """K_t [N/m] of the bench by the closed form, direction +1 pulling, −1 loosening."""
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
    """ω, ζ and ω/2ζ of the servo on the bench."""
    stiffness = transmission(bench, direction)
    gain, brake = servo.tension_gain, servo.velocity_gain
    if direction < 0:
        gain = servo.loosening_tension_gain or gain
        brake = servo.loosening_velocity_gain or brake
    frequency = float(np.sqrt(stiffness * gain / servo.inertia) * servo.radius)
    damping = brake / (2.0 * servo.inertia * frequency)
    return Mode(stiffness, frequency, damping, stiffness * gain * servo.radius**2 / brake)


def damped(bench: Bench, servo: Servo, damping: float) -> Servo:
    """The servo with G_v such that ζ is ``damping`` while it pulls; 1 is critical."""
    brake = damping * 2.0 * servo.inertia * mode(bench, servo, 1).frequency
    return dataclasses.replace(servo, velocity_gain=float(brake))


def scheduled(bench: Bench, servo: Servo) -> Servo:
    """The servo with loosening gains of ζ = 1 that rise no later than its own when loosening.

    Critical damping rises later than an overshooting response of the same ω, so ω goes up by the
    ratio of the two rise times, and by a margin.
    """
    plain = mode(bench, servo, -1)
    speedup = _MARGIN * rise(1.0) / rise(min(plain.damping, 1.0))
    frequency = speedup * plain.frequency
    gain = frequency**2 * servo.inertia / (plain.stiffness * servo.radius**2)
    return dataclasses.replace(
        servo,
        loosening_tension_gain=float(gain),
        loosening_velocity_gain=float(2.0 * servo.inertia * frequency),
    )


def settle(damping: float, phase: Array, speed: float = 0.0) -> Array:
    """Error over ω t of a mode with ζ ≤ 1 that starts at error 1 with ``speed`` −de/d(ωt) [-]."""
    turn = np.sqrt(max(1.0 - damping**2, 1e-12))
    cosine, sine = np.cos(turn * phase), np.sin(turn * phase) / turn
    return np.asarray(np.exp(-damping * phase) * (cosine + (damping - speed) * sine))


def rise(damping: float) -> float:
    """ω t from 10 % to 90 % of a step [-]."""
    phase = np.linspace(0.0, 12.0, 24001)
    error = settle(damping, phase)
    return float(phase[np.argmax(error <= 0.1)] - phase[np.argmax(error <= 0.9)])


def overshoot(damping: float, speed: float = 0.0) -> float:
    """Overshoot over the step [-]: e^{−πζ/√(1−ζ²)} from rest, more when it arrives with speed."""
    return float(max(0.0, -settle(damping, np.linspace(0.0, 40.0, 80001), speed).min()))


def arrival(bench: Bench, servo: Servo, direction: int, tension: float, step: float) -> float:
    """Speed at which the motor leaves the backlash of a reversal, over ω times the step [-].

    In the backlash the output holds still and the motor follows J θ̈ + G_v θ̇ = G_t r ΔT.

    Args:
        bench, servo: as they are.
        direction: in which it goes now.
        tension: T_out at the reversal [N].
        step: ΔT of the reference [N].
    """
    ahead = mode(bench, servo, direction)
    gap = theory.reversal_backlash(bench.exponent, tension, bench.axial_stiffness, bench.length)
    # as a share of the way that the output will make; time in 1/ω
    way = float(gap) * ahead.stiffness / step
    rate, lag = 0.5 / ahead.damping, 0.5 / ahead.damping
    phase = np.linspace(0.0, 20.0 + way / rate, 200001)
    gone = rate * (phase - lag * -np.expm1(-phase / lag))
    return float(rate * -np.expm1(-phase[np.argmax(gone >= way)] / lag))
