"""Muscles, whose force is defined over a range of lengths that grows with their gear."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray


def is_muscle(model: mujoco.MjModel, actuator: int) -> bool:
    """Whether an actuator's force is a muscle's, of its length and speed."""
    return bool(
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_MUSCLE.value
        or model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_MUSCLE.value
    )


def ranges_of_gear(
    model: mujoco.MjModel, actuator: int
) -> list[tuple[NDArray[np.float64], tuple[int, int], float]]:
    """Both ends of a muscle's range of lengths: array, index, and length of a gear of 1 [m].

    None of another actuator, and of a muscle whose gear is 0.
    """
    gear, ends = float(model.actuator_gear[actuator, 0]), model.actuator_lengthrange
    if not is_muscle(model, actuator) or gear == 0.0:
        return []
    return [(ends, (actuator, k), float(ends[actuator, k]) / gear) for k in range(2)]
