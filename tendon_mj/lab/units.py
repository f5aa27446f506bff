"""Units: of columns, whose names end in them; of parameters; and those in which values are read.

Every unit of a column is converted to that of SI. Also the ranges of numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable
from typing import Final, NamedTuple

from tendon_mj.errors import InvalidValueError, unknown

# ending of a column's name in SI → that unit
UNITS: Final = {
    "_s": "s",
    "_m": "m",
    "_N": "N",
    "_rad": "rad",
    "_Nm": "N m",
    "_rad_per_s": "rad/s",
    "_m_per_s": "m/s",
}
UNIT = "_UNIT"  # in a proposed name, for one that is not known
TIME = "time_s"
TIMES = (TIME, "time_ms", "time_us", "time_ns")  # names of the clock in a file

UNKNOWN: Final = "1"  # of a reading or a control that no column names
# parameter -> (unit on a hinge, unit on a slide)
JOINT: Final[dict[str, tuple[str, str]]] = {
    "stiffness": ("N m/rad", "N/m"),
    "damping": ("N m s/rad", "N s/m"),
    "frictionloss": ("N m", "N"),
    "armature": ("kg m²", "kg"),
    "springref": ("rad", "m"),
}

ROUNDING: Final = 1e-6  # of a step, an interval or a length, and loads [N or N m] and angles [rad]
LARGEST: Final = 1e30  # beyond, sums of squares may overflow
SMALLEST: Final = 1.0 / LARGEST  # except 0

_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 1e-3, "um": 1e-6, "inch": 0.0254}  # nm is a misspelt Nm
_ANGLES = {
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": math.pi / 180.0,
    "arcmin": math.pi / 180.0 / 60.0,
    "rev": 2.0 * math.pi,
}
_FORCES = {"N": 1.0, "uN": 1e-6, "mN": 1e-3, "kN": 1e3}
_FORCES |= {"gf": 0.00980665, "kgf": 9.80665, "ozf": 0.2780138509537813, "lbf": 4.4482216152605005}
_TORQUES = {"Nm": 1.0, "uNm": 1e-6, "mNm": 1e-3, "kNm": 1e3, "Ncm": 0.01, "Nmm": 1e-3}
_TORQUES |= {"gfcm": 9.80665e-05, "kgfcm": 0.0980665}


def _rates(units: dict[str, float]) -> dict[str, float]:
    per = (("s", 1.0), ("min", 60.0))
    return {f"{u}_per_{name}": f / seconds for u, f in units.items() for name, seconds in per}


# ending of a column's name → the ending in SI, and the factor that converts to it
UNIT_FACTORS: dict[str, tuple[str, float]] = {
    f"_{unit}": (si, factor)
    for si, units in (
        ("_s", {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}),  # `tension_min` is not a time
        ("_m", _LENGTHS),
        ("_N", _FORCES),
        ("_rad", _ANGLES),
        ("_Nm", _TORQUES),
        ("_rad_per_s", {"rpm": math.pi / 30.0, **_rates(_ANGLES)}),
        ("_m_per_s", _rates(_LENGTHS)),
    )
    for unit, factor in units.items()
}
# words for units in exports of other programs
_WORDS = {
    **dict.fromkeys(("_degrees", "_degree"), "_deg"),
    **dict.fromkeys(("_radians", "_radian"), "_rad"),
    **dict.fromkeys(("_newton", "_newtons"), "_N"),
    **dict.fromkeys(("_seconds", "_sec"), "_s"),
    **dict.fromkeys(("_meters", "_metres"), "_m"),
    **dict.fromkeys(("_millimeters", "_millimetres"), "_mm"),
}
CURRENT = re.compile(r"[\W_][mu]?A\W*$")  # end of a column's name, of which no unit is one
OF_CURRENT = (
    "write into [columns] the torque, or the pull of a cable, that one is:"
    ' motor_Nm = { column = "…", factor = … }'
)
# units that are not read, in brackets; of a time also behind an underscore
_TIMES = "min|minutes?|h|hrs?|hours?"
FOREIGN = re.compile(
    rf"[\[(]\s*({_TIMES}|in|ft|lbs?|kg|g|m?V|volts?|counts?|ticks?|steps|psi|bar|[kM]?Pa|MN|%)"
    r"\s*[\])]\s*$"
)
FOREIGN_TIME = re.compile(rf"[\W_]({_TIMES})\W*$")
# compound units whole: `rate_deg_per_s` must not pass as seconds
_CLAIMED = re.compile(r"(?:(?:^|_)[^_]+_per)?_[^_]+$")


class NumberRange(NamedTuple):
    """Allowed values of a number: from ``low`` to ``high``, and 0 or from 1e-30 to 1e30 in size."""

    # ends, which are allowed
    low: float = -LARGEST
    high: float = LARGEST
    zero: bool = True  # whether 0 is allowed

    def admits(self, value: float) -> bool:
        """Return whether a value is allowed; nan never is."""
        size = abs(value) >= SMALLEST or (self.zero and value == 0.0)
        return self.low <= value <= self.high and size

    def check(self, name: str, value: float, unit: str = "") -> None:
        """Raise `InvalidValueError` unless a value is allowed."""
        if fault := self.fault(name, value, unit):
            raise InvalidValueError(fault)

    def fault(self, name: str, value: float, unit: str = "") -> str:
        """The message of `check`; empty if the value is allowed."""
        if self.admits(value):
            return ""
        return f"{name} = {float(value)!r}{f' [{unit}]' if unit else ''} is outside {self}"

    def __str__(self) -> str:
        zero = "0 or " if self.zero else ""
        if self.low < 0.0:
            return f"{self.low:g} … {self.high:g} ({zero}at least {SMALLEST:g} in size)"
        return f"{zero}{max(self.low, SMALLEST):g} … {self.high:g}"


ANY_NUMBER = NumberRange()
NOT_NEGATIVE = NumberRange(0.0)
POSITIVE_NUMBER = NumberRange(0.0, zero=False)


def excess(value: float) -> str:
    """Message that a number is not finite, or too large whatever its sign; empty if it is not."""
    if not math.isfinite(value):
        return f"{value} is not finite"
    return f"{value:g} is outside ±{LARGEST:g}" if abs(value) > LARGEST else ""


def si_name(column: str) -> tuple[str, float]:
    """A column's name in SI and the factor that converts it: ``x_mm`` is (``x_m``, 0.001)."""
    ending = claimed_unit(column)
    target, factor = UNIT_FACTORS[ending]
    return column.removesuffix(ending) + target, factor


def claimed_unit(column: str) -> str:
    """The end of a column's name that is its unit, underscore included; or the whole name."""
    claimed = _CLAIMED.search(column)
    return claimed.group() if claimed else column


def name_fault(name: str, *, si: bool = False, elements: Collection[str] = ()) -> str:
    """Message that a column's name cannot be used, as of `unit_fault`; empty if it can."""
    if name != name.strip() or not name.isprintable() or {",", '"'} & set(name):
        return f"{name!r} is not a column name; write a word such as 'tension_N', unquoted"
    fault = unit_fault(name, si=si, elements=elements)
    return f"{name!r} {fault}" if fault else ""


def unit_fault(column: str, *, si: bool, elements: Collection[str] = ()) -> str:
    """Message that the unit in a column's name cannot be used; empty if it can.

    With ``si`` units that are converted cannot. ``elements`` are names, as of actuators, that may
    precede the unit although they end in one.
    """
    ending, allowed = claimed_unit(column), tuple(UNITS if si else UNIT_FACTORS)
    stem = f"_{column.removesuffix(ending)}"
    if CURRENT.search(ending):
        return f"is of a current; {OF_CURRENT}"
    if ending not in allowed or ending == column:
        converted = [unit for unit in allowed if unit not in UNITS and "_per_" not in unit]
        kind, also = "an SI unit", ""
        if not si:
            kind, also = "a unit that is read", f"; converted: {', '.join(converted)} and rates"
        return f"does not end in {kind}: {_nearest(ending, allowed)}{also}"
    both = allowed if ending in ("_s", "_ms", "_min") else tuple(UNITS)
    if stem.endswith(both) and stem[1:] not in elements:
        return (
            f"ends in two units, {claimed_unit(stem)!r} and {ending!r}; write one of"
            f" {', '.join(UNITS)}"
        )
    return ""


def proposed_name(column: str) -> str:
    """A name for a column of another program: its unit as it is spelt here, or ``UNIT`` for it."""
    for sign, spelt in (("°", " deg "), ("µ", "u"), ("μ", "u")):
        column = column.replace(sign, spelt)
    stem = re.sub(r"[^0-9A-Za-z]+", "_", column).strip("_")
    ending = claimed_unit(stem)
    unit = _spelt(ending) if ending != stem else ""
    return stem.removesuffix(ending) + unit if unit else stem + UNIT


def _spelt(ending: str) -> str:
    """A unit in other letters or words, as it is spelt here; or nothing, as for a mega of one."""
    spelt = {unit.lower(): unit for unit in reversed(UNIT_FACTORS)}
    if ending.startswith("_M") and ending not in ("_MM", "_MS", "_M"):
        return ""
    return _WORDS.get(ending.lower(), "") or spelt.get(ending.lower(), "")


def _nearest(ending: str, allowed: tuple[str, ...]) -> str:
    """Message that a unit is unknown, with the nearest of all and those of SI."""
    near = unknown("unit", ending, allowed).partition(" (there are")[0]
    if (spelt := _spelt(ending)) in allowed:
        near = f"unknown unit {ending!r}; did you mean {spelt!r}?"
    offset = "; units with an offset are not read" if ending in ("_degC", "_degF", "_C") else ""
    return f"{near}{offset} (SI: {', '.join(map(repr, UNITS))})"


# --- units in which values are read

_PREFIXES: Final = (("M", 1e6), ("k", 1e3), ("", 1.0), ("m", 1e-3), ("µ", 1e-6))
# SI unit → prefixes of its first symbol, as in mN m
_PREFIXED: Final = {
    "m": "mµ",
    "s": "mµ",
    "m/s": "mµ",
    "N": "Mkmµ",
    "N/m": "Mkm",
    "N/s": "kmµ",
    "N s": "kmµ",
    "N s/m": "kmµ",
    "m/N": "mµ",
    "N m": "kmµ",
    "N m/rad": "kmµ",
    "N m s/rad": "kmµ",
}
# SI unit → another one, and how many of it make one of the first
_REPLACED: Final = {
    "rad": ("°", 180.0 / math.pi),
    "rad/s": ("°/s", 180.0 / math.pi),
    "rad/s²": ("°/s²", 180.0 / math.pi),
    "1/s": ("%/s", 100.0),
    "1/m": ("%/m", 100.0),
    "1/N": ("%/N", 100.0),
}
# SI unit → value below which another one is used, that one, and how many of it make one
_SMALLER: Final = {"kg": (1.0, "g", 1e3), "kg m²": (1e-4, "g cm²", 1e7)}
_UNITLESS: Final = ("", "-", "1")


def column_unit(column: str) -> str:
    """The unit that a column's name ends in: ``joint_rad`` is in `rad`; empty without one."""
    return UNITS.get(unit_ending(column), "")


def column_name(column: str) -> str:
    """A column's name in words, without its unit: ``tip_speed_m_per_s`` is `tip speed`."""
    return column.removesuffix(unit_ending(column)).replace("_", " ")


def ending_of(unit: str) -> str:
    """Ending of the name of a column in an SI unit; empty if names have no such unit."""
    return {si: ending for ending, si in UNITS.items()}.get(unit, "")


def name_in(unit: str, column: str) -> str:
    """A column's name in another unit; empty if names have no such unit."""
    ending = ending_of(unit)
    return column.removesuffix(unit_ending(column)) + ending if ending else ""


def unit_ending(column: str) -> str:
    """The longest unit in which a column's name ends."""
    return max((ending for ending in UNITS if column.endswith(ending)), key=len, default="")


def rate(unit: str) -> str:
    """A unit per second; one already per second gets a square."""
    return f"{unit}²" if unit.endswith("/s") else f"{unit}/s"


class EngineeringUnit(NamedTuple):
    """A unit to read values in."""

    symbol: str  # as it is written; empty for a ratio
    factor: float  # by which a value in the SI unit is multiplied

    def write(self, value: float, digits: int = 3) -> str:
        """A value [SI unit] with this unit, as in "12 mN m" or "0.18"; degrees follow at once."""
        space = " " if self.symbol and not self.symbol.startswith("°") else ""
        return f"{plain(value * self.factor, digits)}{space}{self.symbol}"


NEWTON: Final = EngineeringUnit("N", 1.0)


def engineering_unit(unit: str, values: Iterable[float]) -> EngineeringUnit:
    """The unit in which the largest of some values has one to three digits before the point.

    Units that are not SI, as "noise", stay as they are; values that are not finite do not count.
    """
    if unit in _UNITLESS:
        return EngineeringUnit("", 1.0)
    if unit in _REPLACED:
        return EngineeringUnit(*_REPLACED[unit])
    largest = max((abs(v) for v in values if math.isfinite(v)), default=0.0)
    if unit in _SMALLER and 0.0 < largest < _SMALLER[unit][0]:
        return EngineeringUnit(*_SMALLER[unit][1:])
    usable = [p for p in _PREFIXES if not p[0] or p[0] in _PREFIXED.get(unit, "")]
    if largest > 0.0:
        rounded = float(f"{largest:.3g}")  # 999.9 µm is 1 mm
        fitting = [p for p in usable if rounded >= p[1] * (1.0 - 1e-9)] or usable[-1:]
    else:
        fitting = [("", 1.0)]
    prefix, size = fitting[0]
    return EngineeringUnit(prefix + unit, 1.0 / size)


def force_unit(forces: Iterable[float]) -> EngineeringUnit:
    """The unit of all forces [N] that are shown together, by the largest of them.

    It is smaller than N below 1 N, kN from 10 kN on and MN from 10 MN on.
    """
    seen = list(forces)
    unit = engineering_unit("N", seen)
    return unit if unit.factor >= 1.0 else engineering_unit("N", (0.1 * force for force in seen))


def plain(value: float, digits: int = 3) -> str:
    """A number with so many digits, without an exponent where that reads as well."""
    return f"{float(f'{value:.{digits}g}'):g}"


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value [unit] with its unit, as in "12 mN m", "4°" or "0.18"; "-" or empty for a ratio."""
    return engineering_unit(unit, [value]).write(value, digits)


def from_to(
    before: float, after: float, unit: str, between: str = " → ", beside: Iterable[float] = ()
) -> str:
    """Two values [unit] in one unit, as in "4° → 0.11°" or "0.36 → 0.026 mm".

    ``beside`` are values that are written in the same unit elsewhere.
    """
    chosen = engineering_unit(unit, [before, after, *beside])
    has_degrees = chosen.symbol.startswith("°")
    first = chosen.write(before) if has_degrees else plain(before * chosen.factor)
    return first + between + chosen.write(after)


def percent(share: float) -> str:
    """A share in whole percents; 100 % only where it is exactly 1."""
    if not math.isfinite(share):
        return "–"
    return "more than 99 %" if 0.995 <= share < 1.0 else f"{100.0 * share:.0f} %"


def estimated_percent(share: float) -> str:
    """An estimate of a share in whole percents; none is so sure that it is 100 %."""
    return percent(min(share, 0.999))
