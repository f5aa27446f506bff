"""Units of columns: a name ends in its unit, and every unit is converted to that of SI."""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import cache
from itertools import product

import pint

from tendon_mj.errors import unknown

UNITS = ("_s", "_m", "_N", "_rad", "_Nm", "_rad_per_s", "_m_per_s")  # of SI

_PER = ("s", "min")
_ANGLES = ("rad", "mrad", "deg", "arcmin", "rev")
_LENGTHS = ("m", "cm", "mm", "um", "inch")  # without nm, which is Nm misspelt
# unit of SI -> units that are converted to it. A list, and not all that pint knows, to which
# `last_hand`, `flexor_in` and `left_foot` are lengths.
_CONVERTED = {
    "_s": ("s", "ms", "us", "ns"),  # no minutes: `tension_min` is no time
    "_m": _LENGTHS,
    "_N": ("N", "uN", "mN", "kN", "gf", "kgf", "ozf", "lbf"),
    "_rad": _ANGLES,
    "_Nm": ("Nm", "uNm", "mNm", "kNm", "Ncm", "Nmm", "gfcm", "kgfcm"),
    "_rad_per_s": ("rpm", *("_per_".join(pair) for pair in product(_ANGLES, _PER))),
    "_m_per_s": tuple("_per_".join(pair) for pair in product(_LENGTHS, _PER)),
}
_IN_PINT = {
    "rev": "revolution",
    "gf": "gram_force",
    "kgf": "kilogram_force",
    "ozf": "ounce_force",
    "lbf": "pound_force",
}
_TORQUE = re.compile(r"([umk]?N|k?gf)([cm]?m)")
# words that stand for units in exports of others
_WORDS = {
    "_degrees": "_deg",
    "_degree": "_deg",
    "_radians": "_rad",
    "_radian": "_rad",
    "_newton": "_N",
    "_newtons": "_N",
    "_seconds": "_s",
    "_sec": "_s",
    "_meters": "_m",
    "_metres": "_m",
    "_millimeters": "_mm",
    "_millimetres": "_mm",
}
# the unit that a name claims, compound ones whole: `rate_deg_per_s` must not pass as seconds
_CLAIMED = re.compile(r"(?:(?:^|_)[^_]+_per)?_[^_]+$")


@cache
def unit_factors() -> dict[str, tuple[str, float]]:
    """Ending of a column's name → the ending in SI, and the factor that converts to it."""
    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    found = {}
    for target, units in _CONVERTED.items():
        for unit in units:
            one = registry.Quantity(1.0, _expression(unit))
            factor = float(one.to(_expression(target.removeprefix("_"))).magnitude)
            found[f"_{unit}"] = (target, 1.0 if f"_{unit}" == target else factor)
    return found


def si_name(column: str) -> tuple[str, float]:
    """A column's name in SI and the factor that converts it: ``x_mm`` is (``x_m``, 0.001)."""
    ending = claimed_unit(column)
    target, factor = unit_factors()[ending]
    return column.removesuffix(ending) + target, factor


def claimed_unit(column: str) -> str:
    """What stands in a column's name where its unit is, underscore included; or the whole name."""
    claimed = _CLAIMED.search(column)
    return claimed.group() if claimed else column


def unit_fault(column: str, *, si: bool, elements: Collection[str] = ()) -> str:
    """What is wrong with the unit in a column's name; empty if nothing.

    Args:
        column: its name.
        si: whether the unit has to be of SI, or may be one that is converted.
        elements: names that may stand before the unit although they end in one themselves.
    """
    ending, allowed = claimed_unit(column), UNITS if si else tuple(unit_factors())
    if ending not in allowed or ending == column:
        converted = [unit for unit in allowed if unit not in UNITS and "_per_" not in unit]
        also = (
            f"; converted: {', '.join(converted)} and rates such as _deg_per_s" if converted else ""
        )
        kind = "an SI unit" if si else "a unit that is read"
        return f"does not end in {kind}: {_nearest(ending, allowed)}{also}"
    if column.removesuffix(ending) in elements:
        return ""
    stem = f"_{column.removesuffix(ending)}"
    if stem.endswith(UNITS) or (ending in ("_s", "_ms", "_min") and stem.endswith(allowed)):
        return (
            f"ends in two units, {claimed_unit(stem)!r} and {ending!r}; write one of"
            f" {', '.join(UNITS)}"
        )
    return ""


def proposed_name(column: str) -> str:
    """A name for a column of another program: its unit as it is spelt here, or ``UNIT`` for it."""
    stem = re.sub(r"[^0-9A-Za-z]+", "_", column).strip("_")
    ending = claimed_unit(stem)
    unit = _spelt(ending) if ending != stem else ""
    return stem.removesuffix(ending) + unit if unit else f"{stem}_UNIT"


def _spelt(ending: str) -> str:
    """A unit that others spell in other letters or words, as it is spelt here; or nothing."""
    spelt = {unit.lower(): unit for unit in reversed(unit_factors())}
    return _WORDS.get(ending.lower(), "") or spelt.get(ending.lower(), "")


def _nearest(ending: str, allowed: tuple[str, ...]) -> str:
    """Message that a unit is unknown, with the nearest of all and those of SI."""
    near = unknown("unit", ending, allowed).partition(" (there are")[0]
    if (spelt := _spelt(ending)) in allowed:
        near = f"unknown unit {ending!r}; did you mean {spelt!r}?"
    of_si = ", ".join(map(repr, UNITS))
    offset = "; a unit with an offset is none" if ending in ("_degC", "_degF", "_C") else ""
    return f"{near}{offset} (SI: {of_si})"


def _expression(unit: str) -> str:
    """A unit as pint writes it."""
    above, per, below = unit.partition("_per_")
    torque = _TORQUE.fullmatch(above)
    parts = torque.groups() if torque else (above,)
    product_of = " * ".join(_IN_PINT.get(part, part) for part in parts)
    return f"{product_of} / {below}" if per else product_of
