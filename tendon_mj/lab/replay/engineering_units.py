"""Values in the units in which engineers read them: 12 mN m, 0.3 mm and 4°, not powers of ten."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, NamedTuple

_PREFIXES: Final = (("M", 1e6), ("k", 1e3), ("", 1.0), ("m", 1e-3), ("µ", 1e-6))
# SI units whose first symbol takes these prefixes, as in mN m
_PREFIXED: Final = {
    "m": "mµ",
    "s": "mµ",
    "m/s": "mµ",
    "N": "kmµ",
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
    "kg m²": ("g cm²", 1e7),
}
_UNITLESS: Final = ("", "-", "1")


class EngineeringUnit(NamedTuple):
    """A unit to read values in.

    Attributes:
        symbol: as it is written; empty for a ratio.
        factor: by which a value in the SI unit is multiplied.
    """

    symbol: str
    factor: float


def engineering_unit(unit: str, values: Iterable[float]) -> EngineeringUnit:
    """The unit in which the largest of some values has one to three digits before the point.

    Args:
        unit: of the values: an SI unit; others, as "noise", stay as they are.
        values: [unit], those that are written in one table row or on one axis; what is not finite
            does not count.
    """
    if unit in _UNITLESS:
        return EngineeringUnit("", 1.0)
    if unit in _REPLACED:
        return EngineeringUnit(*_REPLACED[unit])
    largest = max((abs(v) for v in values if math.isfinite(v)), default=0.0)
    if unit == "kg":
        return EngineeringUnit("g", 1e3) if 0.0 < largest < 1.0 else EngineeringUnit("kg", 1.0)
    usable = [p for p in _PREFIXES if not p[0] or p[0] in _PREFIXED.get(unit, "")]
    if largest > 0.0:
        rounded = float(f"{largest:.3g}")  # 999.9 µm is 1 mm
        fitting = [p for p in usable if rounded >= p[1] * (1.0 - 1e-9)] or usable[-1:]
    else:
        fitting = [("", 1.0)]
    prefix, size = fitting[0]
    return EngineeringUnit(prefix + unit, 1.0 / size)


def plain(value: float, digits: int = 3) -> str:
    """A number with so many digits, without an exponent where that reads as well."""
    return f"{float(f'{value:.{digits}g}'):g}"


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, as in "12 mN m", "4°" or "0.18".

    Args:
        value: [unit].
        unit: an SI unit; "-" or empty for a ratio.
        digits: significant ones.
    """
    chosen = engineering_unit(unit, [value])
    return with_unit(plain(value * chosen.factor, digits), chosen)


def from_to(
    before: float, after: float, unit: str, between: str = " → ", beside: Iterable[float] = ()
) -> str:
    """Two values in one unit, as in "4° → 0.11°" or "0.36 → 0.026 mm".

    Args:
        before, after: [unit].
        unit: as in `quantity`.
        between: written between the two.
        beside: values [unit] that are written in the same unit elsewhere.
    """
    chosen = engineering_unit(unit, [before, after, *beside])
    first, second = (plain(value * chosen.factor) for value in (before, after))
    first = with_unit(first, chosen) if chosen.symbol.startswith("°") else first
    return first + between + with_unit(second, chosen)


def with_unit(number: str, unit: EngineeringUnit) -> str:
    """A written number with its unit; degrees follow without a space."""
    if not unit.symbol:
        return number
    return f"{number}{'' if unit.symbol.startswith('°') else ' '}{unit.symbol}"


def percent(share: float) -> str:
    """A share in whole percents; 100 % only where it is exactly 1."""
    if not math.isfinite(share):
        return "–"
    return "more than 99 %" if 0.995 <= share < 1.0 else f"{100.0 * share:.0f} %"


def estimated_percent(share: float) -> str:
    """An estimate of a share in whole percents; none is so sure that it is 100 %."""
    return percent(min(share, 0.999))
