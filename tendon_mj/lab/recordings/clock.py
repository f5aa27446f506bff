"""Times of the rows of a table: numbers, dates or counters, coarse, or of several sources."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.description import Source
from tendon_mj.lab.recordings.table import and_more, at, warn
from tendon_mj.lab.units import claimed_unit, si_name
from tendon_mj.typing import FloatArray

Samples = tuple[NDArray[Any], FloatArray]  # times, and values at them
_LONG = 10.0  # times the usual interval: over such a gap values are not interpolated in silence
_OUTSIDE = 0.25  # share of the rows before and after the common time, above which that is said
_COARSE = 0.05  # share of equal times from which the clock is coarse, and none a row that is double
WORD = 2**32  # after which a counter of milliseconds or microseconds begins again
SINCE_1970 = 1e8  # [s]: a date, not a stopwatch
_DAY = 86400.0  # [s]


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
    as_numbers = pd.to_numeric(written, errors="coerce")
    as_dates = pd.to_datetime(written, format="ISO8601", utc=True, errors="coerce")
    spans = written.where(written.str.contains("[a-zA-Z:]"))  # pandas takes "1,000" for one of ns
    as_spans = pd.to_timedelta(spans, errors="coerce")
    best = min(as_dates, as_spans, as_numbers, key=lambda times: times.isna().sum())
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
    warn(
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
        warn(
            f"{where}: {stamps.size - rows.size} of {stamps.size} rows are left out: {late!r}"
            f" begins later, or {early!r} ends earlier"
        )
    joined[clock] = (rows - rows[0]) * scale
    for column, (times, values) in in_order.items():
        if lost := series[column][0].size - times.size:
            warn(
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
            warn(
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


def going_back(
    time: Stamps, stamps: NDArray[Any], scale: float, clock: str, column: str
) -> tuple[str, str]:
    """Fault of (n,) stamps that decrease, with the first that does, and what to write or to do.

    ``scale`` of a stamp is a second; the ``clock`` is read from a ``column`` of the file.
    """
    back = int(np.argmax(stamps[1:] < stamps[:-1]))
    first, second = stamps[back : back + 2]
    fault = f"{time.shown(second)} does not come after {time.shown(first)} of the row before"
    fell, period = float(first) - float(second), 0
    if 0.5 * _DAY < fell * scale < 1.5 * _DAY:
        return fault, (
            "; a time of day begins again at midnight: write times with their date, such as"
            " 2026-03-02T23:59:59, or add 24 h from that row on"
        )
    if 0.5 * WORD < fell <= float(first) < WORD:
        period, counter = WORD, "is a counter of 32 bits"
    elif scale < 1e-3 and fell * scale > 0.5 and float(stamps.max()) * scale < 1.0:
        period, counter = round(1.0 / scale), "begins again with each second"
    if period:
        name = json.dumps(column, ensure_ascii=False)
        entry = f"{clock} = {{ column = {name}, period = {period} }}"
        return fault, f"; if it {counter}, write into [columns] {entry}"
    if float(second) - float(stamps[0]) < 0.5 * fell and stamps[back + 1 :][:2].max() < first:
        return fault, "; a clock that starts again: make the rows from there on another recording"
    return fault, (
        "; sort the rows by their times; or, if the clock was set back, make those from there on"
        " another recording"
    )
