"""The friction law of a tendon in its sheath, as a value.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Final, NamedTuple

from tendon_mj.errors import InvalidValueError


class Range(NamedTuple):
    """What a parameter of the law may be: from ``low`` to ``high``, in a unit.

    Attributes:
        low: lowest allowed value.
        closed: whether that value itself is allowed.
        unit: of both.
        high: which the value has to stay below.
    """

    low: float
    closed: bool
    unit: str
    high: float = math.inf

    def admits(self, value: float) -> bool:
        """Whether a value is finite and within the range."""
        above = value > self.low or (self.closed and value == self.low)
        return math.isfinite(value) and above and value < self.high

    def __str__(self) -> str:
        said = ["finite"]
        if self.low > -math.inf:
            said.append(f"{'≥' if self.closed else '>'} {self.low:g}")
        if self.high < math.inf:
            said.append(f"< {self.high:g}")
        return " and ".join(said)


RANGES: Final[dict[str, Range]] = {
    "axial_stiffness": Range(0.0, False, "N"),
    "friction": Range(0.0, True, "-"),
    "static_friction": Range(0.0, True, "-"),
    "constant_friction": Range(0.0, True, "N"),
    "axial_damping": Range(0.0, True, "N s"),
    "pretension": Range(0.0, True, "N"),
    "stribeck_friction": Range(0.0, True, "-"),
    "stribeck_velocity": Range(0.0, True, "m/s"),
    "viscous_friction": Range(0.0, True, "N s/m"),
    "direction_asymmetry": Range(-1.0, False, "-", 1.0),
    "friction_gradient": Range(-math.inf, False, "1/m"),
    "friction_drift": Range(-math.inf, False, "1/s"),
    "backlash": Range(0.0, True, "m"),
    "stiffening": Range(0.0, True, "-"),
    "creep": Range(0.0, True, "-"),
    "creep_time": Range(0.0, True, "s"),
    "sheath_compliance": Range(0.0, True, "m/N"),
    "tendon_mass": Range(0.0, True, "kg"),
    "extra_bend": Range(-math.inf, False, "rad"),
}
# An effect, and the scale without which it means nothing.
_SCALES = {"stribeck_friction": "stribeck_velocity", "creep": "creep_time"}


def _in(where: str) -> str:
    return f"{where}: " if where else ""


def check_range(name: str, value: float, where: str = "") -> None:
    """Refuse a law's parameter outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    allowed = RANGES[name]
    if not allowed.admits(value):
        raise InvalidValueError(
            f"{_in(where)}{name} = {value:g} [{allowed.unit}] must be {allowed}"
        )


def check_scales(values: Mapping[str, float | None], where: str = "") -> None:
    """Refuse an effect whose scale is missing: a velocity for Stribeck's, a time for creep.

    Raises:
        InvalidValueError: names both values.
    """
    for effect, scale in _SCALES.items():
        if (values[effect] or 0.0) > 0.0 and not (values[scale] or 0.0) > 0.0:
            raise InvalidValueError(
                f"{_in(where)}{effect} = {values[effect]:g} needs {scale} > 0 "
                f"[{RANGES[scale].unit}]"
            )


@dataclass(frozen=True)
class Law:
    """What a tendon and its sheath are made of; geometry not included.

    A guide that bends the tendon by φ [rad] lets it slide when
    T_high = T_low e^{μφ} + F_c/n, with n the number of guides. Each of the parameters from
    ``stribeck_friction`` on is an effect of its own, and none where it is 0.

    Attributes:
        axial_stiffness: EA, tension per unit strain [N].
        friction: μ_d, coefficient while sliding [-].
        static_friction: μ_s ≥ μ_d, coefficient at rest [-]; None means μ_s = μ_d.
        constant_friction: F_c, tension-independent friction of the whole sheath [N].
        axial_damping: c, tension per strain rate [N s].
        pretension: T_0, uniform tension in the reference pose [N].
        stribeck_friction: Δμ, what is added to μ at rest and fades with sliding speed [-].
        stribeck_velocity: v_s, speed at which it has faded to 1/e; > 0 where Δμ is [m/s].
        viscous_friction: c_v, friction per sliding speed of the whole sheath [N s/m].
        direction_asymmetry: α, μ is (1 + α) times as large towards the input, (1 − α) back [-].
        friction_gradient: γ, relative growth of μ per tendon drawn past a guide [1/m].
        friction_drift: β, relative growth of μ per time [1/s].
        backlash: b, play of the drive before it winds [m].
        stiffening: κ, T = EA ε (1 + κ ε) [-].
        creep: χ, share of the elastic strain that is added under a load that lasts [-].
        creep_time: τ_c, in which it comes; > 0 where χ is [s].
        sheath_compliance: C_s, by which the sheath's mount at the input yields [m/N].
        tendon_mass: m, of the tendon in the sheath [kg].
        extra_bend: φ_x, bend that the drawn path does not show [rad].

    Raises:
        InvalidValueError: for a value outside its range, μ_s < μ_d, or an effect without its scale.

    Source: Kaneko et al. 1991, eq. (1); F_c after their section 2.3.
    """

    axial_stiffness: float
    friction: float
    static_friction: float | None = None
    constant_friction: float = 0.0
    axial_damping: float = 0.0
    pretension: float = 0.0
    stribeck_friction: float = 0.0
    stribeck_velocity: float = 0.0
    viscous_friction: float = 0.0
    direction_asymmetry: float = 0.0
    friction_gradient: float = 0.0
    friction_drift: float = 0.0
    backlash: float = 0.0
    stiffening: float = 0.0
    creep: float = 0.0
    creep_time: float = 0.0
    sheath_compliance: float = 0.0
    tendon_mass: float = 0.0
    extra_bend: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                check_range(field.name, value)
        check_static(self.friction, self.mu_s)
        check_scales(asdict(self))

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
        raise InvalidValueError(
            f"{_in(where)}static_friction = {static_friction:g} must be ≥ friction = {friction:g}"
        )
