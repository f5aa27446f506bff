"""An elbow that two cables in sheaths turn, simulated without MuJoCo and without this package.

A cable bears a tension at each place of its sheath. If one end takes up cable, the tension there
rises to P, and along the sheath it becomes max(T, P e^(-μφ)), with the bend φ counted from that
end; if the end gives cable back, it becomes min(T, P e^(μφ)). With P the stretch ∫ T/EA grows by
what was taken up. These are the capstan's fronts of slip, exact in each step; strains are small.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from tendon_mj.typing import FloatArray

_PLACES = 101  # along a sheath, its ends included
_STEP = 2.5e-4  # [s]
_FLANK = 3e4  # of play between pulley and joint [N m/rad]


class Elbow(NamedTuple):
    """Numbers of a rig; ``drum_play`` [m] and ``output_play`` [rad] are what a model may lack."""

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


@numba.njit
def _front(
    tension: FloatArray, ratio: FloatArray, stretch: float, taken: float
) -> tuple[float, int]:
    """Tension at the first end of a cable that this end moves by ``taken`` [m], and its front.

    ``ratio`` is e^(-μφ) from that end, ``stretch`` that of one place for one newton [m/N].
    """
    rises = taken > 0.0
    held, scale, last = taken / stretch, 0.0, len(tension) - 1
    for k in range(last + 1):
        weight = 0.5 if k in (0, last) else 1.0
        held += weight * tension[k]
        scale += weight * (ratio[k] if rises else 1.0 / ratio[k])
        first = held / scale
        if k == last:
            break
        following = first * (ratio[k + 1] if rises else 1.0 / ratio[k + 1])
        if (following <= tension[k + 1]) if rises else (following >= tension[k + 1]):
            break
    return first, k


@numba.njit
def _take_up(tension: FloatArray, ratio: FloatArray, stretch: float, taken: float) -> None:
    """Move the first end of a cable by ``taken``; see `_front`."""
    first, front = _front(tension, ratio, stretch, taken)
    for i in range(front + 1):
        tension[i] = first * (ratio[i] if taken > 0.0 else 1.0 / ratio[i])


@numba.njit
def _simulate(rig: Elbow, drum: FloatArray, steps: int) -> FloatArray:
    phi = np.linspace(0.0, rig.bend, _PLACES)
    ratio = np.exp(-rig.friction * phi)
    stretch = rig.length / (_PLACES - 1) / rig.axial_stiffness
    cables = np.full((2, _PLACES), rig.pretension)
    sides = (1.0, -1.0)
    angle = speed = pulley = wound = 0.0
    measured = np.empty((len(drum), 3))
    for sample in range(len(drum)):
        for step in range(steps if sample else 0):
            share = (step + 1) / steps
            motor = rig.drum_radius * (drum[sample - 1] * (1.0 - share) + drum[sample] * share)
            before, half = wound, 0.5 * rig.drum_play
            wound = min(max(wound, motor - half), motor + half)
            for c in range(2):
                _take_up(cables[c], ratio, stretch, sides[c] * (wound - before))
            gap = 0.5 * rig.output_play
            if gap > 0.0:  # the pulley, which has no mass, is where the flank bears the cables
                low, high = pulley - 0.05, pulley + 0.05
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    beyond = middle - angle
                    torque = -_FLANK * (beyond - min(max(beyond, -gap), gap))
                    for c in range(2):
                        given = -sides[c] * rig.radius * (middle - pulley)
                        output, _ = _front(cables[c, ::-1], ratio, stretch, given)
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
                _take_up(cables[c, ::-1], ratio, stretch, given)
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
