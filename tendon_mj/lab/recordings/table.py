"""Tables of columns as files have them, before and after they are read; what makes one valid."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, TendonWarning
from tendon_mj.lab.units import LARGEST, TIME, excess, name_fault, si_name
from tendon_mj.typing import FloatArray

Columns = dict[str, NDArray[Any]]
DATUM = re.compile(r"\s*(?:[+-]?\.?\d.*|nan)?\s*", re.IGNORECASE)  # a number, a time, or empty


def at(where: str, rows: NDArray[np.int64], column: str, fault: str) -> str:
    """A fault of a column with the first of its rows, and how many more there are."""
    return f"{where}, row {rows[0]}, column {column!r}: {fault}{and_more(rows.size)}"


def check_table(table: Mapping[str, FloatArray], where: str, *, si: bool = False) -> None:
    """Raise `RecordingError` unless the columns, each (n,), are valid; rows as in the CSV.

    That is: names as in `name_fault`, equal lengths of at least 2, every value finite and at most
    `LARGEST` in size, and the time, the first of them, strictly increasing.
    """
    for position, name in enumerate(table, start=1):
        if fault := name_fault(name, si=si):
            raise RecordingError(f"{where}, row 1, column {position}: {fault}")
    clock = next(iter(table))
    time = table[clock]
    for name, column in table.items():
        if column.ndim != 1 or column.shape != time.shape:
            raise RecordingError(
                f"{where}, column {name!r}: shape {column.shape}, but {clock!r} has {time.shape}"
                " and (n,) is needed"
            )
    if time.size < 2:
        raise RecordingError(too_few_rows(time.size, where))
    for name, column in table.items():
        bad = np.flatnonzero(~(np.abs(column) <= LARGEST))
        if bad.size:
            raise RecordingError(
                f"{where}, row {bad[0] + 2}, column {name!r}: {excess(float(column[bad[0]]))}"
            )
    back = np.flatnonzero(time[1:] <= time[:-1])
    if back.size:
        before, after = time[back[0]].item(), time[back[0] + 1].item()
        raise RecordingError(
            f"{where}, row {back[0] + 3}, column {clock!r}: {after!r} does not come after"
            f" {before!r} of the row before; time strictly increases"
        )


def in_si(table: Mapping[str, FloatArray], where: str) -> dict[str, FloatArray]:
    """A valid table of a file in the units and under the names of SI: ``x_mm`` becomes ``x_m``."""
    converted: dict[str, FloatArray] = {}
    before: dict[str, str] = {}
    for name, values in table.items():
        target, factor = si_name(name)
        if target in before:
            raise RecordingError(
                f"{where}, column {name!r}: in SI it is {target!r}, as {before[target]!r} is; give"
                " one of them another name"
            )
        before[target] = name
        converted[target] = values if factor == 1.0 else values * factor
    if not (np.diff(converted[TIME]) > 0.0).all():
        raise RecordingError(f"{where}, column {before[TIME]!r}: times too close in seconds")
    return converted


def and_more(count: int) -> str:
    """Number of rows after the first, in words."""
    others = count - 1
    return f" (and {others} more row{'s' if others > 1 else ''})" if others > 0 else ""


def too_few_rows(count: int, where: str) -> str:
    """Message that a table has not enough rows."""
    return f"{where}, row {count + 2}: missing; at least 2 rows are needed below the header"


def warn(text: str) -> None:
    """Warn of a table that deviates from the expected."""
    warnings.warn(text, TendonWarning, stacklevel=2)


@dataclass(frozen=True)
class OpenTable:
    """A table of which the names are read, and its cells not yet."""

    names: list[str]  # of its columns, in order
    has: Callable[[str], bool]  # whether a column can be read: one of these, or a part of one
    first: int  # row of its first values
    # (column → whether it is needed, the clock) → columns, each (n,), and faults of their cells.
    # Columns are float64 with NaN for an empty cell; the clock may be of integers, dates or texts.
    # Those that are not needed are left out where they hold no numbers
    read: Callable[[Mapping[str, bool], str], tuple[Columns, list[str]]]
    sample: Mapping[str, str]  # column → a value as text, of some columns
    # name of a first header → the column, which has the unit of a second one
    full: Mapping[str, str] = field(default_factory=dict)
    period: float = 0.0  # between rows without a clock, as the file says [s]


class Table(NamedTuple):
    """Columns of a table, the time first, each (n,) [the unit in its name]; their (n,) rows."""

    columns: dict[str, FloatArray]
    rows: NDArray[np.int64] | None = None
