"""Parameters of a spool."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tendon_mj.errors import InvalidValueError

_RESOLVED = 4.0  # J over r² h² EA/ℓ; a step is stable from 1/4 on, and does not ring from 1 on


@dataclass(frozen=True, kw_only=True)
class Spool:
    """A drum on a hinge, which winds a tendon in as it turns forward.

    Attributes:
        radius: r, of the drum [m].
        armature: J, inertia of drum, rotor and gear about the hinge [kg m²]; by default
            4 r² h² EA/ℓ with h the time step and ℓ the length of the straight span at the input
            end, four times the least with which the spool does not ring on it.
        damping: of the hinge [N m s/rad].

    Raises:
        InvalidValueError: a number that is not finite, or outside its range.
    """

    radius: float
    armature: float | None = None
    damping: float = 0.0

    def __post_init__(self) -> None:
        armature = 1.0 if self.armature is None else self.armature
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise InvalidValueError(f"Spool: radius = {self.radius} [m] must be finite and > 0")
        if not (math.isfinite(armature) and armature > 0.0):
            raise InvalidValueError(f"Spool: armature = {armature} [kg m²] must be finite and > 0")
        if not (math.isfinite(self.damping) and self.damping >= 0.0):
            raise InvalidValueError(
                f"Spool: damping = {self.damping} [N m s/rad] must be finite and ≥ 0"
            )

    def inertia(self, stiffness: float, timestep: float) -> float:
        """J, given or by default [kg m²].

        Args:
            stiffness: EA/ℓ of the straight span at the input end [N/m].
            timestep: h [s].
        """
        if self.armature is not None:
            return self.armature
        return _RESOLVED * self.radius**2 * timestep**2 * stiffness

    def least_inertia(self, stiffness: float, timestep: float) -> float:
        """Inertia above which a step is stable, r² h² EA/4ℓ [kg m²]."""
        return 0.25 * self.radius**2 * timestep**2 * stiffness
