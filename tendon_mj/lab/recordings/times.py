"""Tables of time series: clocks of other programs, columns of several clocks, and their checks."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping
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


def read_numbers(cells: Any, column: str, rows: NDArray[np.int64], where: str) -> FloatArray:
    """Numbers of a column with NaN for empty cells.

    Raises:
        RecordingError: a cell is not a number.
    """
    numbers = _numbers(cells)
    bad = np.flatnonzero(numbers.isna() & cells.notna())
    if bad.size:
        raise RecordingError(at(where, rows[bad], column, f"{cells[bad[0]]!r} is not a number"))
    return np.asarray(numbers.to_numpy(np.float64, na_value=np.nan))


def _numbers(cells: Any) -> Any:
    """A column of integers or floats, which are missing where a cell is empty or not a number."""
    if cells.dtype.kind not in "iuf":
        cells = cells.astype("string")  # else True would be 1
    return pd.to_numeric(cells, errors="coerce")


def read_clock(
    cells: Any, clock: str, source: Source, rows: NDArray[np.int64], where: str
) -> Stamps:
    """Times as they are in a file: numbers, dates, or ISO 8601 and durations as text."""
    there = cells.notna().to_numpy()
    given = cells[there]
    best = given if given.dtype.kind in "mM" else _numbers(given)
    if best.isna().any():
        texts = given.astype("string").str.strip()
        dates = pd.to_datetime(texts, format="ISO8601", utc=True, errors="coerce")
        spans = pd.to_timedelta(texts, errors="coerce")
        best = min((best, dates, spans), key=lambda times: times.isna().sum())
    bad = best.isna().to_numpy()
    if bad.any():
        cell = f"{given.iloc[int(np.argmax(bad))]!r} is neither a number nor a time of ISO 8601"
        cell += ", such as 2026-03-02T10:15:02.871"
        raise RecordingError(at(where, rows[there][bad], source.column, cell))
    dated = best.dtype.kind in "mM"
    values = pd.Index(best).as_unit("ns").asi8 if dated else best.to_numpy()
    stamps = np.zeros(there.size, np.int64 if values.dtype.kind == "i" else np.float64)
    stamps[there] = values
    scale = 1e-9 / si_name(clock)[1] if dated else source.factor * source.ratio(clock)
    return Stamps(stamps, there, scale, dated)


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
    """Clock and columns at the times of the first one, and the indices of its values there.

    Another one is linear between its values, or keeps the latest if it is ``held``. Rows before the
    first or after the last value of any column are left out; of two values at one time the later
    one counts. A `TendonWarning` tells of such values, long gaps, and many rows that are left out.

    ``series``: column → (m,) times [any unit, ``scale`` of which is that of the clock] and values.

    Raises:
        RecordingError: there are not two common times.
    """
    chosen, in_order = dict[str, NDArray[np.int64]](), dict[str, Samples]()
    for column, (times, values) in series.items():
        order = np.argsort(times, kind="stable")
        last = np.append(np.diff(times[order]) != 0, True)
        chosen[column] = order[last]
        in_order[column] = times[order[last]], values[order[last]]
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
    joined = {clock: np.asarray((rows - rows[0]) * scale)}
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


def at(where: str, rows: NDArray[np.int64], column: str, fault: str) -> str:
    """A fault of a column with the first of its rows, and how many more there are."""
    return f"{where}, row {rows[0]}, column {column!r}: {fault}{and_more(rows.size)}"


def check_table(table: Mapping[str, FloatArray], where: str, *, si: bool = False) -> None:
    """Raise `RecordingError` unless the columns, each (n,), are valid; rows as in the CSV.

    That is: names as in `name_fault`, equal lengths of at least 2, every value finite and at most
    `LARGEST` in size, and the time, the first of them, strictly increasing.
    """
    clock = next(iter(table))
    time = table[clock]
    if time.size < 2:
        raise RecordingError(too_few_rows(time.size, where))
    for position, (name, column) in enumerate(table.items(), start=1):
        if fault := name_fault(name, si=si):
            raise RecordingError(f"{where}, row 1, column {position}: {fault}")
        if column.ndim != 1 or column.shape != time.shape:
            raise RecordingError(
                f"{where}, column {name!r}: shape {column.shape}, but {clock!r} has {time.shape}"
                " and (n,) is needed"
            )
        if (bad := np.flatnonzero(~(np.abs(column) <= LARGEST))).size:
            fault = excess(float(column[bad[0]]))
            raise RecordingError(f"{where}, row {bad[0] + 2}, column {name!r}: {fault}")
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
