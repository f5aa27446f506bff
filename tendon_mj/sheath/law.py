"""The friction law of a tendon in its sheath, as a value.

Equations: docs/theory.md, section 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Final

from tendon_mj.errors import InvalidValueError

# name -> (lowest allowed value, whether that value itself is allowed, unit)
RANGES: Final[dict[str, tuple[float, bool, str]]] = {
    "axial_stiffness": (0.0, False, "N"),
    "friction": (0.0, True, "-"),
    "static_friction": (0.0, True, "-"),
    "constant_friction": (0.0, True, "N"),
    "axial_damping": (0.0, True, "N s"),
    "pretension": (0.0, True, "N"),
}


def check_range(name: str, value: float, where: str = "") -> None:
    """Refuse a law's parameter outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    low, closed, unit = RANGES[name]
    if not math.isfinite(value) or value < low or (value == low and not closed):
        sign = "≥" if closed else ">"
        place = f"{where}: " if where else ""
        raise InvalidValueError(
            f"{place}{name} = {value:g} [{unit}] must be finite and {sign} {low:g}"
        )


@dataclass(frozen=True)
class Law:
    """What a tendon and its sheath are made of; geometry not included.

    A guide that bends the tendon by φ [rad] lets it slide when
    T_high = T_low e^{μφ} + F_c/n, with n the number of guides.

    Attributes:
        axial_stiffness: EA, tension per unit strain [N].
        friction: μ_d, coefficient while sliding [-].
        static_friction: μ_s ≥ μ_d, coefficient at rest [-]; None means μ_s = μ_d.
        constant_friction: F_c, tension-independent friction of the whole sheath [N].
        axial_damping: c, tension per strain rate [N s].
        pretension: T_0, uniform tension in the reference pose [N].

    Raises:
        InvalidValueError: for a value outside its range, or μ_s < μ_d.

    Source: Kaneko et al. 1991, eq. (1); F_c after their section 2.3.
    """

    axial_stiffness: float
    friction: float
    static_friction: float | None = None
    constant_friction: float = 0.0
    axial_damping: float = 0.0
    pretension: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                check_range(field.name, value)
        check_static(self.friction, self.mu_s)

    @property
    def mu_s(self) -> float:
        """μ_s, the coefficient at rest [-]."""
        return self.friction if self.static_friction is None else self.static_friction


def check_static(friction: float, static_friction: float, where: str = "") -> None:
    """Refuse μ_s < μ_d: a tendon would then speed up from a guide that still holds it.

    Raises:
        InvalidValueError: names both values.
    """
    if static_friction < friction:
        place = f"{where}: " if where else ""
        raise InvalidValueError(
            f"{place}static_friction = {static_friction:g} must be ≥ friction = {friction:g}"
        )
