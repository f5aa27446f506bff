"""Tables of time series: clocks of other programs, columns of several clocks, and their checks."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, TendonWarning
from tendon_mj.lab.recordings.description import Source
from tendon_mj.lab.recordings.units import LARGEST, TIME, claimed_unit, excess, name_fault, si_name
from tendon_mj.typing import FloatArray

Samples = tuple[NDArray[Any], FloatArray]  # times, and values at them

_LONG = 10.0  # times the usual interval: over such a gap values are not interpolated in silence
_OUTSIDE = 0.25  # share of the rows before and after the common time, above which that is said
_COARSE = 0.05  # share of equal times from which the clock is coarse, and none a row that is double


@dataclass(frozen=True)
class Stamps:
    """Times of the rows: (n,) stamps, of rows where ``there``; scale × stamp [the column's unit].

    dated: whether they are dates, times of day or durations, and not numbers.
    """

    stamps: NDArray[Any]
    there: NDArray[np.bool_]
    scale: float
    dated: bool

    def shown(self, stamp: np.number[Any]) -> str:
        """A stamp for messages."""
        return str(np.datetime64(int(stamp), "ns")) if self.dated else repr(stamp.item())


def read_clock(
    cells: NDArray[Any], clock: str, source: Source, rows: NDArray[np.int64], where: str
) -> Stamps:
    """Times as they are in a file: numbers, dates, or ISO 8601 and durations as text."""
    if cells.dtype.kind in "fiu":
        return Stamps(cells, ~np.isnan(cells), source.factor * source.ratio(clock), dated=False)
    nanoseconds = 1e-9 / si_name(clock)[1]
    if cells.dtype.kind in "mM":
        dates = cells.astype(f"{cells.dtype.kind}8[ns]")
        return Stamps(dates.astype(np.int64), ~np.isnat(dates), nanoseconds, dated=True)
    text = pd.Series(cells, dtype=object)
    there = text.notna().to_numpy()
    written = text[there].astype(str).str.strip()
    for kind in (np.int64, np.float64):
        with suppress(ValueError, OverflowError):
            stamps = np.zeros(there.size, kind)
            stamps[there] = [int(cell) if kind is np.int64 else float(cell) for cell in written]
            return Stamps(stamps, there, source.factor * source.ratio(clock), dated=False)
    as_dates = pd.to_datetime(written, format="ISO8601", utc=True, errors="coerce")
    as_spans = pd.to_timedelta(written, errors="coerce")
    best = min(as_dates, as_spans, key=lambda times: times.isna().sum())
    bad = best.isna().to_numpy()
    if bad.any():
        cell = f"{written.iloc[int(np.argmax(bad))]!r} is neither a number nor a time of ISO 8601"
        cell += ", such as 2026-03-02T10:15:02.871"
        raise RecordingError(at(where, rows[there][bad], source.column, cell))
    dates = np.zeros(there.size, np.int64)
    dates[there] = pd.Index(best).as_unit("ns").asi8
    return Stamps(dates, there, nanoseconds, dated=True)


def spread(time: FloatArray, rows: NDArray[np.int64], where: str) -> FloatArray:
    """Times of which some are equal, as of a clock that is coarser than the samples, apart."""
    steps = np.diff(time)
    equal = np.flatnonzero(steps == 0.0)
    if not equal.size:
        return time
    if equal.size == steps.size:
        raise RecordingError(f"{where}: all times are {time[0].item()!r}")
    resolution, k = float(steps[steps > 0.0].min()), np.arange(time.size)
    slope, start = np.polyfit(k, time - time[0], 1)
    even: FloatArray = time[0] + slope * k
    coarse = equal.size >= _COARSE * steps.size
    if coarse and np.abs(even + start - time).max() <= resolution:
        how = f"they are read as even, {slope:.6g} apart"
    else:
        begins = np.flatnonzero(np.append(True, steps > 0.0))
        counts = np.diff(np.append(begins, time.size))
        widths = np.append(np.diff(time[begins]), np.median(steps[steps > 0.0]))
        share = (k - np.repeat(begins, counts)) / np.repeat(counts, counts)
        even, how = time + share * np.repeat(widths, counts), "they are spread until the next one"
    _warn(
        f"{where}, row {rows[equal[0] + 1]}: {time[equal[0]].item()!r} is the time of the row"
        f" before{and_more(equal.size)}; the clock steps by {resolution:.6g}, and {how}"
    )
    return even


def at_common_times(
    series: Mapping[str, Samples], clock: str, scale: float, where: str, held: Collection[str]
) -> tuple[dict[str, FloatArray], NDArray[np.int64]]:
    """Columns at the times of the first one, from the first row on.

    Another one is linear between its values, or keeps the latest if it is ``held``. Rows before the
    first or after the last value of any column are left out; of two values at one time the later
    one counts.

    ``series``: column → (m,) times [any unit, ``scale`` of which is that of the clock] and values.

    Returns:
        The clock and the columns, each (n,), and the (n,) values of the first that are its rows.

    Raises:
        RecordingError: there are not two common times.

    Warns:
        TendonWarning: of values at one time, long gaps, and many rows that are left out.
    """
    joined: dict[str, FloatArray] = {}
    chosen = {column: _in_order(times) for column, (times, _) in series.items()}
    in_order = {c: (times[chosen[c]], values[chosen[c]]) for c, (times, values) in series.items()}
    main = next(iter(series))
    stamps = in_order[main][0]
    within = stamps >= max(times[0] for times, _ in in_order.values())
    within &= stamps <= min(times[-1] for times, _ in in_order.values())
    rows = stamps[within]
    if rows.size < 2:
        raise RecordingError(f"{where}: its columns have no two values at common times")
    if rows.size < (1.0 - _OUTSIDE) * stamps.size:
        late, early = (
            choose(in_order, key=lambda c: in_order[c][0][end])
            for choose, end in ((max, 0), (min, -1))
        )
        _warn(
            f"{where}: {stamps.size - rows.size} of {stamps.size} rows are left out: {late!r}"
            f" begins later, or {early!r} ends earlier"
        )
    joined[clock] = (rows - rows[0]) * scale
    for column, (times, values) in in_order.items():
        if lost := series[column][0].size - times.size:
            _warn(
                f"{where}: {lost} of {lost + times.size} values of {column!r} have the time of a"
                " later one and are left out"
            )
        if column in held:
            joined[column] = values[np.searchsorted(times, rows, side="right") - 1]
            continue
        joined[column] = np.interp(rows - rows[0], times - rows[0], values)
        steps = np.diff(times) * scale
        if column != main and steps.size and steps.max() > _LONG * np.median(steps):
            unit = claimed_unit(clock).removeprefix("_")
            begin = (times[np.argmax(steps)] - rows[0]) * scale
            _warn(
                f"{where}: {column!r} has no value for {steps.max():.4g} {unit} from"
                f" {begin:.6g} {unit} on, and else one each {np.median(steps):.4g} {unit}; in"
                " between it is taken as linear: hold = true in [drive] keeps the latest value"
            )
    return joined, chosen[main][within]


def _in_order(times: NDArray[Any]) -> NDArray[np.int64]:
    order = np.argsort(times, kind="stable")
    sorted_times = times[order]
    last: NDArray[np.int64] = order[np.append(sorted_times[1:] != sorted_times[:-1], True)]
    return last


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
    """A valid table of a file in the units and under the names of SI: ``x_mm`` becomes ``x_m``.

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
    """Number of rows after the first, in words."""
    others = count - 1
    return f" (and {others} more row{'s' if others > 1 else ''})" if others > 0 else ""


def too_few_rows(count: int, where: str) -> str:
    """Message that a table has not enough rows."""
    return f"{where}, row {count + 2}: missing; at least 2 rows are needed below the header"


def _warn(text: str) -> None:
    warnings.warn(text, TendonWarning, stacklevel=2)
