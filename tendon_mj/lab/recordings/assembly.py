"""The columns that a description names, out of the cells of a table; all faults in one message."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, TendonWarning, unknown
from tendon_mj.lab.recordings.description import UNSAID, Source, TableLayout
from tendon_mj.lab.units import (
    CURRENT,
    FOREIGN,
    FOREIGN_TIME,
    LARGEST,
    OF_CURRENT,
    TIME,
    TIMES,
    UNIT_FACTORS,
    claimed_unit,
    excess,
    name_fault,
    proposed_name,
    si_name,
)
from tendon_mj.typing import BoolArray, FloatArray

Columns = dict[str, NDArray[Any]]
Samples = tuple[NDArray[Any], FloatArray]  # times, and values at them

_LONG = 10.0  # times the usual interval: over such a gap values are not interpolated in silence
_OUTSIDE = 0.25  # share of the rows before and after the common time, above which that is said
_COARSE = 0.05  # share of equal times from which the clock is coarse, and none a row that is double
_SPARSE = 0.6  # share of complete rows below which a row is a message: half are, of 100 and 50 Hz
_DAY = 86400.0  # [s]
_WORD = 2**32  # after which a counter of milliseconds or microseconds begins again
_SINCE_1970 = 1e8  # [s]: a date, not a stopwatch
_DATE = re.compile(r"\d{4}-\d\d-\d\d")
DATUM = re.compile(r"\s*(?:[+-]?\.?\d.*|nan)?\s*", re.IGNORECASE)  # a number, a time, or empty
_CLOCK = re.compile(
    r"(.*[\W_])?(time|t|clock|stamp|timestamp|zeit|millis|micros)([\W_].*)?", re.IGNORECASE
)


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
    as_spans = pd.to_timedelta(written, errors="coerce")
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


def assemble(
    table: OpenTable,
    where: str,
    layout: TableLayout | None = None,
    described: Mapping[str, str] | None = None,
    *,
    held: Collection[str] = (),
    elements: Collection[str] = (),
    toml: str = "",
) -> Table:
    """Read the columns that a description names, and others with a valid name and valid numbers.

    Rows in which none of the named columns has a value are passed over, as of events. Where few of
    the others are complete, a row is a message, and `at_common_times` joins them; else a warning
    says which rows are left out, since they lack a value.

    ``where`` and ``toml`` are the files, for messages; ``described``: column → table of the
    description that names it (None: all columns are needed); ``held``: columns that keep their
    value until the next one; ``elements``: as of `unit_fault`. A `RecordingError` has all that is
    wrong with the table, a line each.
    """
    layout = layout or TableLayout()
    columns = {
        c: replace(s, column=table.full.get(s.column, s.column)) for c, s in layout.columns.items()
    }
    layout = replace(layout, columns=columns)
    names = _Names(table, where, layout, described or {}, described is None, toml)
    sources, faults = names.sources(elements)
    named = sources if described is None else [*columns, *described]
    needed = [c for c in dict.fromkeys(named) if c in sources.keys() - {*TIMES}]
    clock = _clock(sources)
    of_clock = sources[clock].column if clock else ""
    wanted = {s.column: c in needed or c == clock for c, s in sources.items()}
    cells, bad_cells = table.read(wanted, of_clock)
    faults += bad_cells
    if (period := layout.period or table.period) and not clock:
        clock, count = TIME, max((column.size for column in cells.values()), default=0)
        sources[clock], cells[of_clock] = Source(factor=period), np.arange(float(count))
    if of_clock not in cells:
        raise _refusal(faults)
    rows = table.first + np.arange(cells[of_clock].size)
    try:
        time = read_clock(cells[of_clock], clock, sources[clock], rows, where)
    except RecordingError as error:
        raise _refusal([*faults, str(error)]) from None
    samples = _samples(
        where, sources, clock, time, rows, cells, needed, faults, settled=layout.settled
    )
    if faults := [*faults, *samples.faults()]:
        raise _refusal(faults)
    return samples.joined(held) if _is_sparse(samples.filled) else samples.table(layout)


def _samples(
    where: str,
    sources: Mapping[str, Source],
    clock: str,
    time: Stamps,
    rows: NDArray[np.int64],
    cells: Columns,
    needed: Sequence[str],
    faults: list[str],
    *,
    settled: bool,
) -> _Samples:
    """Rows in which the needed columns have values; faults of which rows these are are added."""
    numbers = {
        c: cells[s.column] for c, s in sources.items() if c not in TIMES and s.column in cells
    }
    needed = [column for column in needed if column in numbers]
    filled = ~np.isnan(np.reshape([numbers[c] for c in needed], (len(needed), rows.size)))
    kept = filled.any(axis=0) if needed else time.there
    gaps = {clock: kept & ~time.there}
    kept = kept & time.there
    if not _is_sparse(filled[:, kept]):
        gaps |= {c: kept & ~there for c, there in zip(needed, filled, strict=True)}
        kept = kept & filled.all(axis=0)
    then = "friction remembers it: begin another recording" if settled else "the row is left out"
    for column, gap in gaps.items():
        if gap.any():
            fault = at(where, rows[gap], sources[column].column, f"empty cell or nan; {then}")
            (faults.append if settled else warn)(fault)
    if kept.sum() < 2 and not faults:
        faults.append(too_few_rows(int(kept.sum()), where))
    numbers = {column: values[kept] for column, values in numbers.items()}
    stamps, rows, filled = time.stamps[kept], rows[kept], filled[:, kept]
    if period := sources[clock].period:
        if fault := sources[clock].period_fault(stamps):
            faults.append(f"{where}, column {sources[clock].column!r}: {fault}")
        begun = np.append(False, stamps[1:] < stamps[:-1] - 0.5 * period)
        stamps = stamps + np.asarray(period * np.cumsum(begun), stamps.dtype)
    return _Samples(where, sources, clock, time, stamps, rows, numbers, needed, filled)


def _is_sparse(filled: BoolArray) -> bool:
    """Whether few rows are complete, so that each is a message of one of several sources."""
    return len(filled) > 1 and int(filled.all(axis=0).sum()) < _SPARSE * filled.shape[1]


@dataclass(frozen=True)
class _Samples:
    """Rows of a table that have a value; ``stamps`` are their (n,) times, see `Stamps`."""

    where: str
    sources: Mapping[str, Source]
    clock: str  # name of the column
    time: Stamps  # of all rows
    stamps: NDArray[Any]
    rows: NDArray[np.int64]  # (n,) in the file
    numbers: Mapping[str, FloatArray]  # as in the file
    needed: Sequence[str]  # columns that the description names
    filled: BoolArray  # (needed, n)

    @property
    def _scale(self) -> float:
        """Unit of the stamps [s]."""
        return self.time.scale * si_name(self.clock)[1]

    def faults(self) -> list[str]:
        """Numbers out of range, gaps, and times that decrease."""
        faults = list[str]()
        for column, there in zip(self.needed, self.filled, strict=True):
            source, values = self.sources[column], self.numbers[column]
            large = np.flatnonzero(np.abs(values) > LARGEST)
            if large.size:
                fault = excess(float(values[large[0]]))
                faults.append(at(self.where, self.rows[large], source.column, fault))
            if fault := source.period_fault(values[there]):
                faults.append(f"{self.where}, column {source.column!r}: {fault}")
            if there.size and not there.any():
                faults.append(at(self.where, self.rows, source.column, "empty cell or nan"))
        back = np.flatnonzero(self.stamps[1:] < self.stamps[:-1])
        if back.size:
            first, second = self.stamps[back[0] : back[0] + 2]
            fault = f"{self.time.shown(second)} does not come after {self.time.shown(first)} of"
            fault += " the row before"
            if 0.5 * _DAY < (float(first) - float(second)) * self._scale < 1.5 * _DAY:
                fault += (
                    "; a time of day begins again at midnight: write times with their date, such as"
                    " 2026-03-02T23:59:59, or add 24 h from that row on"
                )
            column = self.sources[self.clock].column
            if 0.5 * _WORD < float(first) - float(second) <= float(first) < _WORD:
                name = json.dumps(column, ensure_ascii=False)
                fault += (
                    f"; if it is a counter of 32 bits, write into [columns] {self.clock} ="
                    f" {{ column = {name}, period = {_WORD} }}"
                )
            faults.append(at(self.where, self.rows[back + 1], column, fault))
        return faults

    def joined(self, held: Collection[str]) -> Table:
        """Columns at the times of the first one."""
        series = {
            c: (self.stamps[there], self.sources[c].converted(self.numbers[c][there], c))
            for c, there in zip(self.needed, self.filled, strict=True)
        }
        joined, chosen = at_common_times(series, self.clock, self.time.scale, self.where, held)
        return Table(joined, self.rows[self.filled[0]][chosen])

    def table(self, layout: TableLayout) -> Table:
        """Columns row by row; dates, and a clock of [columns] since 1970, from the first one on."""
        converted = {
            c: self.sources[c].converted(values, c)
            for c, values in self.numbers.items()
            if c in self.needed or (np.abs(values) <= LARGEST).all()  # not if one is nan
        }
        stamps, scale = self.stamps, self.time.scale
        since_1970 = abs(float(stamps[0])) * self._scale >= _SINCE_1970
        if self.time.dated or (since_1970 and self.clock in layout.columns):
            stamps = stamps - stamps[0]
        times = np.asarray(stamps, np.float64)
        times = times if scale == 1.0 else times * scale
        place = f"{self.where}, column {self.sources[self.clock].column!r}"
        return Table({self.clock: spread(times, self.rows, place)} | converted, self.rows)


@dataclass(frozen=True)
class _Names:
    """Names of a table's columns, and those that a description uses; see `assemble`."""

    table: OpenTable
    where: str
    layout: TableLayout
    described: Mapping[str, str]
    all_needed: bool
    toml: str

    def sources(self, elements: Collection[str]) -> tuple[dict[str, Source], list[str]]:
        """Place of each column that is named, or has a valid name; and faults of the names."""
        used = {source.column: column for column, source in self.layout.columns.items()}
        header = f"{self.where}, row {max(self.table.first - 1, 1)}"
        sources, faults = self._mapped()
        for place, name in enumerate(self.table.names, start=1):
            fault = self._fault(place, name, used, elements)
            if fault == "":
                sources[name] = Source(column=name)
            elif fault:
                units = any(" (SI: " in other for other in faults)  # their list, once
                fault = fault.partition(" (SI: ")[0] if units else fault
                faults.append(f"{header}, column {place}: {fault}")
        faults += self._missing(used)
        clock = _clock(sources)
        if not clock and not (self.layout.period or self.table.period):
            faults.append(f"{header}: no column is named {', '.join(map(repr, TIMES))}")
        elif clock and self.layout.period:
            faults.append(
                f"{self.toml}, period = {self.layout.period:g}: is of a table without a clock, and"
                f" {clock!r} is one; take period out"
            )
        if faults and self.toml:
            faults += self._suggestion(sources, clock, used)
        return sources, faults

    def _fault(
        self, place: int, name: str, used: Mapping[str, str], elements: Collection[str]
    ) -> str | None:
        """Fault of a name in the table; empty if the column is to be read, None if it is not."""
        needed = self.all_needed or name in self.described
        if name in self.layout.columns or (name in used and not needed):
            return None
        fault, first = name_fault(name, elements=elements), self.table.names.index(name) + 1
        if fault and name in used:
            title = self.described.get(name)
            return f"in [{title}] write {used[name]!r}, as [columns] names it"
        if not fault and first != place:
            fault = f"{name!r} is already the name of column {first}"
        return fault if needed or not fault else None

    def _mapped(self) -> tuple[dict[str, Source], list[str]]:
        """The same of [columns]."""
        sources, faults = dict[str, Source](), list[str]()
        for column, source in self.layout.columns.items():
            if not source.column:
                fault = "is of a log; for a table write { column = … }"
            elif not self.table.has(source.column):
                fault = unknown("column", source.column, self.table.names)
                fault += f", in {self.where}"
            else:
                unit = claimed_unit(proposed_name(source.column))
                sources[column], fault = in_its_unit(column, source, unit)
                if _is_in_another(source, unit):
                    warn(
                        f"{self.toml}, [columns] {column!r}: unit = {source.unit!r} is taken, where"
                        f" {self.where} says {unit[1:]!r}; take unit out if the file is right"
                    )
            faults += [f"{self.toml}, [columns] {column!r}: {fault}"] if fault else []
        return sources, faults

    def _missing(self, used: Collection[str]) -> list[str]:
        """Columns that the description names and the table lacks; the list of names, once."""
        here = {*self.layout.columns, *self.table.names}
        missing = [name for name in self.described if name not in here]
        valid = here - {*self.described, *TIMES, *used, *self._texts}
        faults = [unknown("column", name, valid) for name in missing]
        return [
            f"{self.toml}, [{self.described[name]}] {name!r}:"
            f" {fault if k == 0 else fault.partition(' (there ')[0]}, in {self.where}"
            for k, (name, fault) in enumerate(zip(missing, faults, strict=True))
        ]

    def _suggestion(self, sources: Collection[str], clock: str, used: Collection[str]) -> list[str]:
        """The entries of [columns] with which a table would be read, as far as its names say."""
        names, described = self.table.names, self.described
        entries = [] if clock else [self._clock_entry(used)]
        misnamed = {*names} - {*sources, *used}
        entries += [(proposed_name(column), column) for column in described if column in misnamed]
        taken = {*described, *TIMES, *dict(entries).values(), *self._texts}
        rest = [name for name in names if name not in taken]
        there = {*names, *self.layout.columns, *TIMES}
        missing = [column for column in described if column not in there]
        alike = {
            c: [name for name in rest if _words(c) == _words(name)]
            or [name for name in rest if _words(c) < _words(name)]
            or (rest if len(rest) == len(missing) == 1 else [])
            for c in missing
        }
        near = all(get_close_matches(c, rest, 1, 0.5) for c in missing)
        if near and not entries and not any(alike.values()):
            return []  # misspelt, as the faults say
        lines = [f"{column} = {json.dumps(name, ensure_ascii=False)}" for column, name in entries]
        found = [name for of in alike.values() for name in of]
        for column, of in alike.items():
            name = of[0] if len(of) == 1 and found.count(of[0]) == 1 else "…"
            text = json.dumps(name, ensure_ascii=False)
            same = _words(column) == _words(name) and _quantity(column) == _quantity(name) != ""
            sure = name == "…" or same
            asked = f'{{ column = {text}, unit = "{UNSAID}" }}'
            lines.append(f"{column} = {text if sure else asked}")
        hints = {
            "…": f"# columns of the table: {', '.join(map(repr, rest))}",
            'time_UNIT = "…"': "# without a clock write above the tables: period = … # [s]",
            UNSAID: "# counts need a factor too: 0.087890625 [deg] if 4096 are a turn",
        }
        return [
            f"add to {self.toml}; [drive] and [measured] use the names on the left, with a unit for"
            f" UNIT and {UNSAID}, and a column for …:",
            "[columns]",
            *lines,
            *(hint for mark, hint in hints.items() if mark in "\n".join(lines)),
        ]

    @property
    def _texts(self) -> set[str]:
        """Columns that begin with a text, and so hold no numbers."""
        return {name for name, cell in self.table.sample.items() if not DATUM.fullmatch(cell)}

    def _clock_entry(self, used: Collection[str]) -> tuple[str, str]:
        """A name for the column of times, with the unit that its name or first value seems to have.

        Numbers grow from row to row; of several such columns it is one that is named as a clock.
        """
        sample = self.table.sample
        free = [
            n for n in self.table.names if n and n not in {*self.described, *used, *self._texts}
        ]
        cells = Columns()
        with suppress(RecordingError):
            cells, _ = self.table.read(dict.fromkeys(free, False), "")
        named = [n for n in free if _CLOCK.fullmatch(n) and (n not in cells or _grows(cells[n]))]
        dates = [n for n in free if _DATE.match(sample.get(n, ""))]
        growing = [n for n in cells if _grows(cells[n])]
        name = next(iter([*named, *dates, *(growing if len(growing) == 1 else [])]), "…")
        if (unit := claimed_unit(proposed_name(name))) in ("_s", "_ms", "_us", "_ns"):
            return f"time{unit}", name
        text = sample.get(name, "")
        try:
            since_1970 = float(text) >= _SINCE_1970 * 1e9  # not even a counter of ns is so large
        except ValueError:
            return TIME if text else "time_UNIT", name
        return "time_ns" if since_1970 else "time_UNIT", name


def _quantity(column: str) -> str:
    """The SI unit of what a column's name says that it is in; empty if it says none."""
    return UNIT_FACTORS.get(claimed_unit(proposed_name(column)), ("", 1.0))[0]


def _words(column: str) -> set[str]:
    """The words of a column's name, but for its unit."""
    name = proposed_name(column)
    return {*name.removesuffix(claimed_unit(name)).lower().split("_")}


def _grows(values: NDArray[Any]) -> bool:
    """True if numbers do not decrease and most increase, as a coarse clock's, or begin again."""
    steps = np.diff(values[~np.isnan(values)])
    again = steps < -0.5 * _WORD
    return bool(steps.size and ((steps >= 0.0) | again).all() and np.median(steps) > 0.0)


def in_its_unit(column: str, source: Source, theirs: str) -> tuple[Source, str]:
    """A source with the unit that its file says, such as ``_deg``; or the contradiction to that."""
    ours = claimed_unit(column)
    if CURRENT.search(source.column) and source.factor == 1.0:
        return source, f"{source.column!r} is a current; {OF_CURRENT}"
    if not source.unit and source.factor == 1.0 and theirs not in UNIT_FACTORS:
        foreign = FOREIGN_TIME if column in TIMES else FOREIGN
        if stated := foreign.search(source.column):
            return source, (
                f"{source.column!r} is in {stated[1]!r}, which is not a unit that is read; say"
                f" factor = …, {ours[1:]} for one of it, or unit = …"
            )
    if source.unit or theirs not in UNIT_FACTORS or theirs == ours:
        return source, ""
    alike = UNIT_FACTORS[ours][0] == UNIT_FACTORS[theirs][0]
    plain = source.factor == 1.0 and not source.offset
    if plain and alike:
        return replace(source, unit=theirs.removeprefix("_")), ""
    if alike or plain:
        name = source.column or source.field
        product = "factor × number + offset" if alike else f"a number of {name!r}"
        return source, f"which unit {product} is in is unclear; say unit = {ours[1:]!r} or another"
    return source, ""


def _is_in_another(source: Source, theirs: str) -> bool:
    """Whether a description says another unit than the file, ``theirs``, of the same quantity."""
    ours = f"_{source.unit}"
    if source.factor != 1.0 or not {ours, theirs} <= UNIT_FACTORS.keys() or ours == theirs:
        return False
    return UNIT_FACTORS[ours][0] == UNIT_FACTORS[theirs][0]


def _clock(columns: Collection[str]) -> str:
    return next((column for column in columns if column in TIMES), "")


def _refusal(faults: Sequence[str]) -> RecordingError:
    return RecordingError("\n".join(dict.fromkeys(faults)))
