"""Checks of a table of time series: names that carry units, finite values, rising times."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.magnitude import LARGEST, excess
from tendon_mj.lab.recordings.units import si_name, unit_fault
from tendon_mj.typing import FloatArray

Cells = dict[str, NDArray[Any]]

TIME = "time_s"
TIMES = (TIME, "time_ms", "time_us", "time_ns")  # as a file may have it


@dataclass(frozen=True)
class OpenTable:
    """A table of which the names are read, and its cells not yet.

    Attributes:
        names: of its columns, in order.
        has: whether a column can be read: one of these, or a part of one.
        first: row of its first values.
        read: (column → whether it is needed, the clock) → columns, each (n,), and faults of their
            cells. Columns are float64 with NaN for an empty cell; the clock may be of integers,
            dates or texts. Those that are not needed are left out where they hold no numbers.
        sample: column → a value as text, of some columns.
    """

    names: list[str]
    has: Callable[[str], bool]
    first: int
    read: Callable[[Mapping[str, bool], str], tuple[Cells, list[str]]]
    sample: Mapping[str, str]


def name_fault(name: str, *, si: bool = False, elements: Collection[str] = ()) -> str:
    """What is wrong with a column's name; empty if nothing.

    Args:
        name: of a column.
        si: whether its unit has to be of SI, or may be one that is converted.
        elements: names, as of actuators, that columns may have although they end in units.
    """
    if name != name.strip() or not name.isprintable() or {",", '"'} & set(name):
        return f"{name!r} is no column name; write a word such as 'tension_N', unquoted"
    fault = unit_fault(name, si=si, elements=elements)
    return f"{name!r} {fault}" if fault else ""


def check_table(table: Mapping[str, FloatArray], where: str, *, si: bool = False) -> None:
    """Raise `RecordingError` unless the columns, each (n,), are lawful; rows as in the CSV.

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
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise RecordingError(
                f"{where}, row {bad[0] + 2}, column {name!r}: {column[bad[0]]} is not finite"
            )
        bad = np.flatnonzero(np.abs(column) > LARGEST)
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
    """A lawful table of a file in the units and under the names of SI: ``x_mm`` becomes ``x_m``.

    Raises:
        RecordingError: two columns would have one name, or times differ by less than a number
            can hold.
    """
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
    """How many rows there are beside the first one."""
    others = count - 1
    return f" (and {others} more row{'s' if others > 1 else ''})" if others > 0 else ""


def too_few_rows(count: int, where: str) -> str:
    """Message that a table has not enough rows."""
    return f"{where}, row {count + 2}: missing; at least 2 rows are needed below the header"
