"""The friction law of a tendon in its sheath, as a value, and the description of its parameters.

A field of a dataclass carries its description: symbol, unit, range and one line of text. Messages,
docstrings, tables and the order in which compiled code stores the values are derived from the
fields. A parameter is added here, and where its equation is; its row in docs/plugin.md is then
written by `python -m tests.plugin.test_attribute_tables`. Equations: docs/theory.md, sections 4
and 7.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, asdict, dataclass, field, fields
from typing import (
    Any,
    Final,
    NamedTuple,
    SupportsFloat,
    TypedDict,
    TypeVar,
    dataclass_transform,
)

from tendon_mj.errors import InvalidValueError

_C = TypeVar("_C")
_KEY = "parameter"
_MOST_BEND = 8.0 * math.pi  # four turns; a guide's bend in degrees, or a sheath's, is more
_MOST_FRICTION = 2.0  # more than rubber; what cables have, 0.03 to 0.5, is 3 to 50 in percent
LARGEST: Final = 1e30  # in size: products of parameters beyond may not be finite


class Range(NamedTuple):
    """Interval of allowed values, from ``low`` to ``high``.

    Attributes:
        low: lowest value.
        closed: whether ``low`` itself is allowed.
        high: bound that a value has to stay below.
    """

    low: float = 0.0
    closed: bool = True
    high: float = math.inf

    def admits(self, value: float) -> bool:
        """Return whether a value is finite and within the range."""
        above = value > self.low or (self.closed and value == self.low)
        return math.isfinite(value) and above and value < self.high

    @property
    def smallest(self) -> float:
        """Least size of a value; what must not be 0 divides."""
        return 1.0 / LARGEST if self == POSITIVE else 0.0

    def bounds(self) -> list[str]:
        """The finite bounds as text."""
        low = [f"{'≥' if self.closed else '>'} {self.low:g}"] if self.low > -math.inf else []
        high = [f"< {self.high:g}"] if self.high < math.inf else []
        return low + high

    def __str__(self) -> str:
        return " and ".join(["finite", *self.bounds()])


ANY = Range(-math.inf, False)
POSITIVE = Range(0.0, False)
_NOT_NEGATIVE = Range()


class Parameter(NamedTuple):
    """Description of a parameter.

    Attributes:
        symbol: in the equations.
        unit: SI; "-" if there is none.
        text: its meaning in one line.
        range: allowed values.
        scale: name of the parameter without which this one has no meaning; empty: none.
        default: value if it is not given; None: required, or taken from elsewhere.
        required: whether it has to be given.
    """

    symbol: str
    unit: str
    text: str
    range: Range
    scale: str = ""
    default: float | None = None
    required: bool = False

    def line(self) -> str:
        """Symbol, text and unit as in a docstring."""
        return f"{self.symbol}, {self.text} [{self.unit}]."

    def outside(self) -> str:
        """What is said of a value outside the range."""
        return f"must be {self.range}"

    def extreme(self) -> str:
        """What is said of a value that is too large or too small to be computed with."""
        least = -LARGEST if self.range.low < 0.0 else self.range.smallest
        return f"is out of range, {least:g} to {LARGEST:g}"


def described(
    symbol: str,
    unit: str,
    text: str,
    allowed: Range = _NOT_NEGATIVE,
    scale: str = "",
    default: Any = MISSING,
) -> Any:
    """Field of a dataclass that is a parameter; see `Parameter`."""
    return field(default=default, metadata={_KEY: Parameter(symbol, unit, text, allowed, scale)})


@dataclass_transform(field_specifiers=(described,), frozen_default=True)
def with_parameters(cls: type[_C]) -> type[_C]:
    """Class decorator: a frozen dataclass, each field of which is `described`."""
    return dataclass(frozen=True)(cls)


def parameters_of(described_class: Any) -> dict[str, Parameter]:
    """Parameters of a dataclass by name, in the order of its fields."""
    return {field.name: _complete(field) for field in fields(described_class)}


def _complete(field: Field[Any]) -> Parameter:
    parameter: Parameter = field.metadata[_KEY]
    if field.default is MISSING:
        return parameter._replace(required=True)
    return parameter._replace(default=field.default)


def attribute_lines(parameters: Mapping[str, Parameter], indent: str) -> str:
    """Lines ``name: symbol, text [unit].`` of a docstring."""
    return "\n".join(f"{indent}{name}: {p.line()}" for name, p in parameters.items())


def in_place(where: str) -> str:
    """Prefix of a message; empty if no place is named."""
    return f"{where}: " if where else ""


def check_in_range(
    parameters: Mapping[str, Parameter], name: str, value: float, where: str = ""
) -> None:
    """Refuse a value outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    parameter = parameters[name]
    allowed, given = parameter.range, f"{in_place(where)}{name} = {value:g} [{parameter.unit}]"
    if not allowed.admits(value):
        raise InvalidValueError(f"{given} {parameter.outside()}")
    if not allowed.smallest <= abs(value) <= LARGEST:
        raise InvalidValueError(f"{given} {parameter.extreme()}")


def doubt_of_unit(name: str, value: float) -> str:
    """Doubt of a friction in percent, or a bend in degrees; empty if it may be right."""
    if name == "extra_bend" and value > _MOST_BEND:
        turns = value / (2.0 * math.pi)
        return f"{name} = {value:.4g} rad are {turns:.0f} turns: a bend in degrees is to be in rad"
    if name not in ("friction", "static_friction") or value <= _MOST_FRICTION:
        return ""
    share = math.exp(-math.pi * value)
    return (
        f"{name} = {value:g} lets {share:.1g} of a tension through half a turn, and cables have"
        f" 0.03 to 0.5: if it is in percent, give {value / 100.0:g}"
    )


@with_parameters
class Law:
    """Parameters of a tendon and its sheath; geometry not included.

    A guide that bends the tendon by φ [rad] lets it slide when
    T_high = T_low e^{μφ} + F_c/n, with n the number of guides. Each of the parameters from
    ``stribeck_friction`` on is an effect of its own, and none where it is 0.

    Raises:
        InvalidValueError: for a value outside its range, μ_s < μ_d, or an effect without its scale.

    Source: Kaneko et al. 1991, eq. (1); F_c after their section 2.3.
    """

    axial_stiffness: float = described(
        "EA", "N", "tension per unit strain; a tendon that MuJoCo drives does without", POSITIVE
    )
    friction: float = described("μ_d", "-", "friction coefficient while sliding")
    static_friction: float | None = described(
        "μ_s", "-", "friction coefficient at rest, ≥ μ_d; not given: μ_d", default=None
    )
    constant_friction: float = described(
        "F_c",
        "N",
        "tension-independent friction of the whole sheath, shared by its guides",
        default=0.0,
    )
    axial_damping: float = described("c", "N s", "tension per strain rate", default=0.0)
    pretension: float = described(
        "T_0", "N", "uniform tension at `qpos0` with nothing wound in", default=0.0
    )
    stribeck_friction: float = described(
        "Δμ",
        "-",
        "addition to μ at rest, fading with sliding speed",
        scale="stribeck_velocity",
        default=0.0,
    )
    stribeck_velocity: float = described(
        "v_s", "m/s", "speed at which Δμ has faded to 1/e, > 0 if Δμ is", default=0.0
    )
    viscous_friction: float = described(
        "c_v", "N s/m", "friction per sliding speed of the whole sheath", default=0.0
    )
    direction_asymmetry: float = described(
        "α",
        "-",
        "μ (1 + α) towards the input, μ (1 − α) back",
        Range(-1.0, False, 1.0),
        default=0.0,
    )
    friction_gradient: float = described(
        "γ", "1/m", "relative growth of μ per tendon that has passed a guide", ANY, default=0.0
    )
    load_gradient: float = described(
        "λ", "1/N", "relative growth of μ per tension at a guide beyond T_0", ANY, default=0.0
    )
    friction_drift: float = described(
        "β", "1/s", "relative growth of μ per simulation time", ANY, default=0.0
    )
    backlash: float = described(
        "b",
        "m",
        "play between the drive and the drum, as tendon, centred at the start",
        default=0.0,
    )
    stiffening: float = described("κ", "-", "T = EA ε (1 + κ ε), ε the elastic strain", default=0.0)
    creep: float = described(
        "χ", "-", "strain that comes later over the elastic one", scale="creep_time", default=0.0
    )
    creep_time: float = described(
        "τ_c", "s", "time constant in which it comes, > 0 if χ is", default=0.0
    )
    sheath_compliance: float = described(
        "C_s", "m/N", "yield of the sheath's mount at the input per tension beyond T_0", default=0.0
    )
    output_compliance: float = described(
        "C_o",
        "m/N",
        "yield of what holds the tendon or the sheath at the output, per tension beyond T_0",
        default=0.0,
    )
    tendon_mass: float = described("m", "kg", "mass of the tendon in the whole sheath", default=0.0)
    extra_bend: float = described(
        "φ_x",
        "rad",
        "bend that the drawn path does not show, shared by the guides; below 0: less",
        ANY,
        default=0.0,
    )
    slack: float = described(
        "s",
        "m",
        "length added to the tendon, by which it is slack at `qpos0` where T_0 is 0",
        default=0.0,
    )

    def __post_init__(self) -> None:
        values = asdict(self)
        for name, value in values.items():
            if value is not None:
                check_range(name, value)
        check_static(self.friction, self.mu_s)
        check_scales(values)

    @property
    def mu_s(self) -> float:
        """μ_s, the coefficient at rest [-]."""
        return self.friction if self.static_friction is None else self.static_friction


class OptionalParameters(TypedDict, total=False):
    """Parameters of `Law` that a call may leave out, for type checkers: they read no metadata."""

    static_friction: SupportsFloat | None
    constant_friction: SupportsFloat | None
    axial_damping: SupportsFloat | None
    stribeck_friction: SupportsFloat | None
    stribeck_velocity: SupportsFloat | None
    viscous_friction: SupportsFloat | None
    direction_asymmetry: SupportsFloat | None
    friction_gradient: SupportsFloat | None
    load_gradient: SupportsFloat | None
    friction_drift: SupportsFloat | None
    backlash: SupportsFloat | None
    stiffening: SupportsFloat | None
    creep: SupportsFloat | None
    creep_time: SupportsFloat | None
    sheath_compliance: SupportsFloat | None
    output_compliance: SupportsFloat | None
    tendon_mass: SupportsFloat | None
    extra_bend: SupportsFloat | None
    slack: SupportsFloat | None


LAW: Final[dict[str, Parameter]] = parameters_of(Law)
if Law.__doc__:  # python -OO has none
    Law.__doc__ += f"\n    Attributes:\n{attribute_lines(LAW, ' ' * 8)}\n    "


def check_range(name: str, value: float, where: str = "") -> None:
    """Refuse a law's parameter outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    check_in_range(LAW, name, value, where)


def check_scales(values: Mapping[str, float | None], where: str = "") -> None:
    """Refuse an effect whose scale is missing: a velocity for Stribeck's, a time for creep.

    Raises:
        InvalidValueError: names both values.
    """
    for effect, scale in ((name, parameter.scale) for name, parameter in LAW.items()):
        if scale and (values[effect] or 0.0) > 0.0 and not (values[scale] or 0.0) > 0.0:
            raise InvalidValueError(
                f"{in_place(where)}{effect} = {values[effect]:g} needs {scale} > 0 "
                f"[{LAW[scale].unit}]"
            )


def check_static(friction: float, static_friction: float, where: str = "") -> None:
    """Refuse μ_s < μ_d: a tendon would then speed up from a guide that still holds it.

    Raises:
        InvalidValueError: names both values.
    """
    if static_friction < friction:
        raise InvalidValueError(
            f"{in_place(where)}static_friction = {static_friction:g} must be ≥ friction = "
            f"{friction:g}"
        )
