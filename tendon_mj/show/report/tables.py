"""Rows of a report's tables, in the units in which engineers read them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from tendon_mj.lab.diagnosis import ErrorReduction, Value
from tendon_mj.lab.replay import column_name, column_unit, engineering_unit, plain

ABSENT = "–"


class ErrorRow(NamedTuple):
    """Errors of a signal, each written in ``unit``."""

    signal: str
    before: str
    after: str
    sysid: str
    noise: str
    between: str
    unit: str


class ValueRow(NamedTuple):
    """A fitted parameter, written in ``unit``."""

    name: str
    value: str
    low: str
    high: str
    before: str
    unit: str
    note: str


def error_rows(
    errors: ErrorReduction,
    sysid: Mapping[str, float] | None = None,
    reproducibility: Mapping[str, float] | None = None,
) -> list[ErrorRow]:
    """A row for each signal.

    Args:
        errors: before and after.
        sysid: column → error of `mujoco.sysid` alone [the column's unit].
        reproducibility: column → standard deviation between sessions [the column's unit].
    """
    rows = []
    for column, (before, after, noise) in errors.signals.items():
        rival = (sysid or {}).get(column, math.nan)
        unit = engineering_unit(column_unit(column), (before, after, rival))
        rows.append(
            ErrorRow(
                signal=column_name(column),
                before=_written(before, unit.factor),
                after=_written(after, unit.factor),
                sysid=_written(rival, unit.factor),
                noise=_written(noise, unit.factor),
                between=_written((reproducibility or {}).get(column, math.nan), unit.factor),
                unit=unit.symbol,
            )
        )
    return rows


def value_rows(values: Mapping[str, Value]) -> list[ValueRow]:
    """A row for each parameter."""
    rows = []
    for name, v in values.items():
        unit = engineering_unit(v.unit, (v.value, v.before))
        note = "" if v.determined else "not determined: its whole range"
        note = "at an end of its range" if v.at_end else note
        rows.append(
            ValueRow(
                name=name,
                value=_written(v.value, unit.factor, 4),
                low=_written(v.low, unit.factor, 4),
                high=_written(v.high, unit.factor, 4),
                before=_written(v.before, unit.factor, 4),
                unit=unit.symbol or ABSENT,
                note=note,
            )
        )
    return rows


def _written(value: float, factor: float, digits: int = 3) -> str:
    return plain(value * factor, digits) if math.isfinite(value) else ABSENT


def short(value: float) -> str:
    """A number to four significant digits."""
    if not math.isfinite(value):
        return ABSENT
    if 1e4 <= abs(value) < 1e7:
        return f"{value:,.0f}".replace(",", "\u202f")
    return f"{value:.4g}"
