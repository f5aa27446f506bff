"""An elbow that two cables in sheaths turn, simulated without MuJoCo and without this package."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from experiments.fronts_of_slip import PLACES, front, stretch_of_place, take_up
from tendon_mj.typing import FloatArray

_STEP = 2.5e-4  # [s]
_FLANK = 3e4  # of play between pulley and joint [N m/rad]


class Elbow(NamedTuple):
    """Numbers of a rig; the last three are what a model may lack.

    ``drum_play`` is in m, ``output_play`` in rad, ``output_compliance``, of what holds each cable
    at the joint, in m/N.
    """

    friction: float
    bend: float
    length: float
    axial_stiffness: float
    pretension: float
    radius: float
    drum_radius: float
    mass: float
    centre_of_mass: float
    inertia: float
    damping: float
    dry_friction: float
    drum_play: float = 0.0
    output_play: float = 0.0
    output_compliance: float = 0.0


@numba.njit
def _past_mount(
    cable: FloatArray, ratio: FloatArray, stretch: float, given: float, compliance: float
) -> float:
    """What a cable takes up at its mount [m], which yields to its tension and moves by ``given``.

    ``given`` is counted from where the mount would be without tension.
    """
    tension = cable[0]
    most = abs(given - compliance * tension)
    least = -most
    for _ in range(50):
        middle = 0.5 * (least + most)
        tension, _ = front(cable, ratio, stretch, middle)
        if middle + compliance * tension < given:
            least = middle
        else:
            most = middle
    return float(0.5 * (least + most))


@numba.njit
def _simulate(rig: Elbow, drum: FloatArray, steps: int) -> FloatArray:
    phi = np.linspace(0.0, rig.bend, PLACES)
    ratio = np.exp(-rig.friction * phi)
    stretch = stretch_of_place(rig.length, rig.axial_stiffness, rig.pretension)
    cables = np.full((2, PLACES), rig.pretension)
    sides = (1.0, -1.0)
    yielded = np.full(2, rig.output_compliance * rig.pretension)
    angle = speed = pulley = wound = 0.0
    measured = np.empty((len(drum), 3))
    for sample in range(len(drum)):
        for step in range(steps if sample else 0):
            share = (step + 1) / steps
            motor = rig.drum_radius * (drum[sample - 1] * (1.0 - share) + drum[sample] * share)
            before, half = wound, 0.5 * rig.drum_play
            wound = min(max(wound, motor - half), motor + half)
            for c in range(2):
                take_up(cables[c], ratio, stretch, sides[c] * (wound - before))
            gap = 0.5 * rig.output_play
            if gap > 0.0:  # the pulley, which has no mass, is where the flank bears the cables
                low, high = pulley - 0.05, pulley + 0.05
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    beyond = middle - angle
                    torque = -_FLANK * (beyond - min(max(beyond, -gap), gap))
                    for c in range(2):
                        given = -sides[c] * rig.radius * (middle - pulley)
                        output, _ = front(cables[c, ::-1], ratio, stretch, given)
                        torque += sides[c] * rig.radius * output
                    if torque > 0.0:
                        low = middle
                    else:
                        high = middle
                turned = 0.5 * (low + high)
            else:
                turned = angle
            torque = 0.0
            for c in range(2):
                given = -sides[c] * rig.radius * (turned - pulley)
                if rig.output_compliance > 0.0:
                    given += yielded[c]
                    given = _past_mount(
                        cables[c, ::-1], ratio, stretch, given, rig.output_compliance
                    )
                take_up(cables[c, ::-1], ratio, stretch, given)
                yielded[c] = rig.output_compliance * cables[c, -1]
                torque += sides[c] * rig.radius * cables[c, -1]
            pulley = turned
            torque -= rig.mass * 9.81 * rig.centre_of_mass * np.sin(angle)
            speed = (speed + _STEP * torque / rig.inertia) / (
                1.0 + _STEP * rig.damping / rig.inertia
            )
            slowed = _STEP * rig.dry_friction / rig.inertia
            speed = max(0.0, speed - slowed) if speed > 0.0 else min(0.0, speed + slowed)
            angle += _STEP * speed
        if cables.min() < 0.0:
            measured[:] = np.nan
            break
        measured[sample] = cables[0, 0], cables[1, 0], angle
    return measured


def simulate(rig: Elbow, drum: FloatArray, period: float) -> FloatArray:
    """Tensions at both drums [N] and angle of the joint [rad], (n, 3), for the drum's angle [rad].

    All are NaN if a cable goes slack, which these profiles do not describe.

    Args:
        rig: its numbers.
        drum: angle of the drum at each sample [rad]; above 0 it winds in the first cable.
        period: between samples [s].
    """
    return np.asarray(_simulate(rig, drum, round(period / _STEP)))
