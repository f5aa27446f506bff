"""What differs from episode to episode, and by how much."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from tendon_mj.errors import InvalidValueError

_UNITS = {"friction": "-", "pretension": "N", "bend": "rad", "axial_stiffness": "N"}


@dataclass(frozen=True, kw_only=True)
class Ranges:
    """(low, high) of every number that an episode draws uniformly; low = high keeps it.

    Friction, pretension and axial stiffness are live parameters of the simulation's data: setting
    them costs nothing. Bend is geometry, so unless it is kept the model is built anew for every
    episode (about 5 ms).

    Attributes:
        friction: μ, the same for both tendons [-].
        pretension: T_0 of both tendons [N].
        axial_stiffness: EA of both tendons [N].
        bend: of both sheaths [rad].

    Raises:
        InvalidValueError: not two finite numbers in order, or below 0.
    """

    friction: tuple[float, float] = (0.05, 0.25)
    pretension: tuple[float, float] = (3.0, 6.0)
    axial_stiffness: tuple[float, float] = (2000.0, 2000.0)
    bend: tuple[float, float] = (math.pi / 3.0, math.pi)

    def __post_init__(self) -> None:
        for field in fields(self):
            low, high = getattr(self, field.name)
            if not (math.isfinite(high) and 0.0 <= low <= high):
                unit = _UNITS[field.name]
                raise InvalidValueError(
                    f"{field.name} = ({low}, {high}) [{unit}] must be finite, in order and ≥ 0"
                )

    def draw(self, random: np.random.RandomState) -> dict[str, float]:
        """One number from each range, by name."""
        return {f.name: float(random.uniform(*getattr(self, f.name))) for f in fields(self)}
