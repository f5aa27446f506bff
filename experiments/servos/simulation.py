"""A servo, its gear, two cables in sheaths and a joint, without MuJoCo and without this package.

Where the drum has play, its cables pull it to the one flank or the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from experiments.fronts_of_slip import PLACES, front, stretch_of_place, take_up
from tendon_mj.typing import FloatArray

_STEP = 5e-5  # [s]


class Servo(NamedTuple):
    """Numbers of a rig, at the joint; ``play`` is that of the drum [m of cable]."""

    kp: float
    kv: float
    efficiency: float
    armature: float
    friction: float
    bend: float
    length: float
    axial_stiffness: float
    pretension: float
    radius: float
    mass: float
    centre_of_mass: float
    inertia: float
    damping: float
    play: float = 0.0


@numba.njit
def _simulate(rig: Servo, goal: FloatArray, steps: int) -> FloatArray:
    ratio = np.exp(-rig.friction * np.linspace(0.0, rig.bend, PLACES))
    stretch = stretch_of_place(rig.length, rig.axial_stiffness, rig.pretension)
    cables = np.full((2, PLACES), rig.pretension)
    sides = (1.0, -1.0)
    forward = 1.0 - rig.efficiency
    back = 1.0 / (2.0 - 1.0 / rig.efficiency) - 1.0
    motor = motor_speed = angle = speed = wound = 0.0
    measured = np.empty((len(goal), 3))
    for sample in range(len(goal)):
        for step in range(steps if sample else 0):
            share = (step + 1) / steps
            aim = goal[sample - 1] * (1.0 - share) + goal[sample] * share
            torque = rig.kp * (aim - motor) - rig.kv * motor_speed
            moved = motor_speed * rig.armature / _STEP + torque
            for c in range(2):
                moved -= sides[c] * rig.radius * cables[c, 0]
            # the gear's friction, in proportion to the torque: more where the load drives it
            loss = abs(torque) * (forward if moved * torque > 0.0 else back)
            moved = max(0.0, moved - loss) if moved > 0.0 else min(0.0, moved + loss)
            motor_speed = moved * _STEP / rig.armature
            motor += _STEP * motor_speed
            before = wound
            low, high = rig.radius * motor - 0.5 * rig.play, rig.radius * motor + 0.5 * rig.play
            while high - low > 1e-10:  # the drum, which has no mass, goes where its cables pull it
                middle, pull = 0.5 * (low + high), 0.0
                for c in range(2):
                    tension, _ = front(cables[c], ratio, stretch, sides[c] * (middle - before))
                    pull += sides[c] * tension
                low, high = (low, middle) if pull > 0.0 else (middle, high)
            wound = 0.5 * (low + high)
            torque = -rig.mass * 9.81 * rig.centre_of_mass * np.sin(angle)
            for c in range(2):
                take_up(cables[c], ratio, stretch, sides[c] * (wound - before))
                torque += sides[c] * rig.radius * cables[c, -1]
            speed = (speed + _STEP * torque / rig.inertia) / (
                1.0 + _STEP * rig.damping / rig.inertia
            )
            angle += _STEP * speed
            for c in range(2):
                take_up(cables[c, ::-1], ratio, stretch, -sides[c] * rig.radius * _STEP * speed)
        if cables.min() < 0.0:
            measured[:] = np.nan
            break
        torque = rig.kp * (goal[sample] - motor) - rig.kv * motor_speed
        measured[sample] = motor, torque, angle
    return measured


def simulate(rig: Servo, goal: FloatArray, period: float) -> FloatArray:
    """Angle of the motor [rad], its torque [N m] and the joint's angle [rad], (n, 3).

    All are NaN if a cable goes slack, which fronts of slip do not describe.

    Args:
        rig: its numbers.
        goal: angle that the servo is sent at each sample [rad].
        period: between samples [s].
    """
    return np.asarray(_simulate(rig, goal, round(period / _STEP)))
