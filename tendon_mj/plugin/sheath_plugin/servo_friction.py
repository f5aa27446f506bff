"""Friction inside a servo, in front of the cables that are not drawn.

It opposes motion, and holds at rest, with at most

    F = F_0 + |k_e τ_e − k_m τ_m| + s (F_s + |k'_e τ_e − k'_m τ_m| + q),   s = e^{−|v/v_s|^a},

with τ_m the torque of the motor, τ_e that of all other forces on the tendon but dampers, and v its
velocity. Where they oppose each other q is q_e τ_e² if the motor drives, |τ_m| > |τ_e|, and
q_m τ_m² if the load does.

Source: bam/model.py of Rhoban/bam, `compute_frictions`; M1 to M5 of its models are parts of M6.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.sheath import POSITIVE, described, with_parameters

_AT_REST = "servo_stribeck_velocity"


@with_parameters
class ServoFriction:
    """Parameters of a servo's friction, of a fixed tendon that is as long as its joint's angle."""

    servo_friction: float = described("F_0", "N m", "friction of a servo without load", default=0.0)
    servo_motor_friction: float = described("k_m", "-", "its growth with the motor", default=0.0)
    servo_load_friction: float = described("k_e", "-", "its growth with the load", default=0.0)
    servo_stribeck: float = described(
        "F_s", "N m", "addition to F_0 at rest, fading with speed", scale=_AT_REST, default=0.0
    )
    servo_motor_stribeck: float = described(
        "k'_m", "-", "addition to k_m at rest", scale=_AT_REST, default=0.0
    )
    servo_load_stribeck: float = described(
        "k'_e", "-", "addition to k_e at rest", scale=_AT_REST, default=0.0
    )
    servo_motor_square: float = described(
        "q_m",
        "1/(N m)",
        "friction at rest over the motor's torque squared, if the load drives",
        scale=_AT_REST,
        default=0.0,
    )
    servo_load_square: float = described(
        "q_e",
        "1/(N m)",
        "friction at rest over the load squared, if the motor drives",
        scale=_AT_REST,
        default=0.0,
    )
    servo_stribeck_velocity: float = described(
        "v_s", "rad/s", "speed at which what is added at rest has faded to 1/e", default=0.0
    )
    servo_stribeck_exponent: float = described(
        "a", "-", "exponent by which it fades; not given: 1", POSITIVE, default=0.0
    )


@compiled
def has_servo(servo: ServoFriction) -> bool:
    """Return whether there is any friction inside a servo."""
    moving = servo.servo_friction + servo.servo_motor_friction + servo.servo_load_friction
    held = servo.servo_stribeck + servo.servo_motor_stribeck + servo.servo_load_stribeck
    return moving + held + servo.servo_motor_square + servo.servo_load_square > 0.0


@compiled
def servo_bound(servo: ServoFriction, motor: float, load: float, speed: float) -> float:
    """Largest friction of a servo [N m] under both torques [N m], at a speed [rad/s]."""
    bound = servo.servo_friction
    bound += abs(servo.servo_load_friction * load - servo.servo_motor_friction * motor)
    if servo.servo_stribeck_velocity == 0.0:
        return bound
    held = servo.servo_stribeck
    held += abs(servo.servo_load_stribeck * load - servo.servo_motor_stribeck * motor)
    if load * motor < 0.0:
        by_motor = abs(motor) > abs(load)
        driven = servo.servo_load_square * load * load
        held += driven if by_motor else servo.servo_motor_square * motor * motor
    exponent = servo.servo_stribeck_exponent if servo.servo_stribeck_exponent > 0.0 else 1.0
    return bound + held * math.exp(-((abs(speed) / servo.servo_stribeck_velocity) ** exponent))
