"""The columns that a description names, out of the cells of a table: all its faults at once."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, TendonWarning, unknown
from tendon_mj.recordings.description import Layout, Source
from tendon_mj.recordings.magnitude import LARGEST, excess
from tendon_mj.recordings.table_checks import (
    A_DATE,
    TIME,
    TIMES,
    FloatArray,
    OpenTable,
    and_more,
    name_fault,
    too_few_rows,
    way_out,
)
from tendon_mj.recordings.units import claimed_unit, proposed_name, si_name, unit_factors

Series = tuple[NDArray[Any], FloatArray]  # times, and values at them

_SPARSE = 0.5  # share of complete rows below which a row is a message of one source
_LONG = 10.0  # times the usual interval: over such a gap values are not interpolated in silence
_COARSE = 0.05  # share of equal times from which the clock is coarse, and none a row that is double
_SINCE_1970 = 1e8  # [s]: a date, and not a stopwatch
_CLOCK = re.compile(r"(.*[\W_])?(time|t|stamp|timestamp|zeit)([\W_].*)?", re.IGNORECASE)


class Table(NamedTuple):
    """Columns of a table, the time first, each (n,) [the unit in its name]; their (n,) rows."""

    columns: dict[str, FloatArray]
    rows: NDArray[np.int64] | None = None


@dataclass(frozen=True)
class _Clock:
    """Times of the rows: (n,) stamps, which are of rows where ``there``; units of the column each.

    dated: whether they count from 1970, and not from a time that the file chose.
    """

    stamps: NDArray[Any]
    there: NDArray[np.bool_]
    scale: float
    dated: bool


def assemble(
    table: OpenTable,
    where: str,
    layout: Layout | None = None,
    described: Mapping[str, str] | None = None,
    *,
    held: Collection[str] = (),
    elements: Collection[str] = (),
    toml: str = "",
) -> Table:
    """Read the columns that a description names, and others that are as a column must be.

    Rows in which none of the named columns has a value are passed over, as of events. Where fewer
    than half of the others are complete, a row is a message, and `at_common_times` joins them.

    Args:
        table: opened.
        where: the file, for messages.
        layout: where the named columns are.
        described: column → table of the description that names it; None: all columns are needed.
        held: columns that keep their value until the next one.
        elements: as of `check_names`.
        toml: the description, for messages.

    Raises:
        RecordingError: all that is wrong with the table, a line each.
    """
    layout = layout or Layout()
    sources, faults = _sources(table, where, layout, described, elements, toml)
    clock = next((column for column in sources if column in TIMES), "")
    named = sources if described is None else [*layout.columns, *described]
    needed = [c for c in dict.fromkeys(named) if c in sources and c not in TIMES]
    if not clock:
        hint = way_out(table.names[0]) if table.names else ""
        faults.append(
            f"{where}, row {max(table.first - 1, 1)}: has no column {TIME!r}, nor 'time_ms' and the"
            f" like{hint}"
        )
    if faults and toml:
        faults += _suggestion(table, layout, described or {}, sources, clock, toml)
    of_clock = sources[clock].column if clock else ""
    wanted = {s.column: c in needed or c == clock for c, s in sources.items()}
    cells, bad_cells = table.read(wanted, of_clock)
    faults += bad_cells
    rows = table.first + np.arange(len(next(iter(cells.values()), ())))
    numbers = {
        c: cells[s.column] for c, s in sources.items() if c not in TIMES and s.column in cells
    }
    columns = [column for column in needed if column in numbers]
    filled = ~np.isnan(np.reshape([numbers[c] for c in columns], (len(columns), rows.size)))
    if of_clock not in cells:
        raise _refusal(faults)
    try:
        time = _clock(cells[of_clock], clock, sources[clock], rows, where)
    except RecordingError as error:
        raise _refusal([*faults, str(error)]) from None
    kept = filled.any(axis=0) if columns else time.there
    if not time.there[kept].all():
        faults.append(_at(where, rows[kept & ~time.there], of_clock, "empty cell"))
        kept &= time.there
    if kept.sum() < 2 and not faults:
        faults.append(too_few_rows(int(kept.sum()), where))
    rows, stamps, filled = rows[kept], time.stamps[kept], filled[:, kept]
    numbers = {column: values[kept] for column, values in numbers.items()}
    sparse = len(columns) > 1 and filled.all(axis=0).sum() < _SPARSE * rows.size
    for column, there in zip(columns, filled, strict=True):
        source = sources[column].column
        faults += _size_faults(numbers[column], rows, source, where)
        if not there.all() and not (sparse and there.any()):
            gap = "empty cell or nan; leave out rows that have a gap"
            faults.append(_at(where, rows[~there], source, gap))
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    if back.size:
        before, after = stamps[back[0]].item(), stamps[back[0] + 1].item()
        step = f"{after!r} does not come after {before!r} of the row before"
        faults.append(_at(where, rows[back + 1], of_clock, step))
    if faults:
        raise _refusal(faults)
    if sparse:
        series = {
            c: (stamps[there], sources[c].converted(numbers[c][there], c))
            for c, there in zip(columns, filled, strict=True)
        }
        joined, chosen = at_common_times(series, clock, time.scale, where, held)
        return Table(joined, rows[filled[0]][chosen])
    converted = {
        c: sources[c].converted(values, c)
        for c, values in numbers.items()
        if c in columns or (np.abs(values) <= LARGEST).all()  # not if one is nan
    }
    since = abs(float(stamps[0])) * time.scale * si_name(clock)[1] >= _SINCE_1970
    if since and (time.dated or clock in layout.columns):
        stamps = stamps - stamps[0]
    times = np.asarray(stamps, np.float64)
    times = times if time.scale == 1.0 else times * time.scale
    return Table({clock: _spread(times, rows, f"{where}, column {of_clock!r}")} | converted, rows)


def at_common_times(
    series: Mapping[str, Series], clock: str, scale: float, where: str, held: Collection[str]
) -> tuple[dict[str, FloatArray], NDArray[np.int64]]:
    """Columns at the times of the first one, from the first row on.

    Another one is linear between its values, or keeps the latest where it is ``held``. Rows before
    the first or after the last value of any of them are left out; of two values at one time the
    later one counts.

    Args:
        series: column → (m,) times [any unit] and (m,) values.
        clock: name of the column of times.
        scale: of the unit of times to that of the clock.
        where: the file, for messages.
        held: columns that keep their value until the next.

    Returns:
        The clock and the columns, each (n,), and the (n,) values of the first that are its rows.

    Raises:
        RecordingError: there are not two common times.

    Warns:
        TendonWarning: of values over each other, and of gaps over which values are interpolated.
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


def _sources(
    table: OpenTable,
    where: str,
    layout: Layout,
    described: Mapping[str, str] | None,
    elements: Collection[str],
    toml: str,
) -> tuple[dict[str, Source], list[str]]:
    """Where each column is that is named, or whose name is lawful; and what is wrong with names."""
    sources, faults = dict[str, Source](), list[str]()
    mapped, header = layout.columns, f"{where}, row {max(table.first - 1, 1)}"
    for column, source in mapped.items():
        here = f"{toml}, [columns] {column!r}"
        if not source.column:
            faults.append(f"{here}: is of a log; for a table write {{ column = … }}")
        elif not table.has(source.column):
            faults.append(f"{here}: {unknown('column', source.column, table.names)}")
        else:
            sources[column], fault = _in_its_unit(column, source)
            faults += [f"{here}: {fault}"] if fault else []
    used = {source.column for source in mapped.values()}
    for place, name in enumerate(table.names, start=1):
        needed = described is None or name in described
        if name in mapped or (name in used and not needed):
            continue
        here, first = f"{header}, column {place}", table.names.index(name) + 1
        fault = name_fault(name, elements=elements)
        if fault and needed:
            known = any(" (SI: " in said for said in faults)  # the units that there are, once
            faults.append(f"{here}: {fault.partition(' (SI: ')[0] if known else fault}")
        elif first != place and (needed or name in used):
            faults.append(f"{here}: {name!r} is already the name of column {first}")
        elif not fault and first == place:
            sources[name] = Source(column=name)
    named = described or {}
    missing = [name for name in named if name not in (*mapped, *table.names)]
    valid = [n for n in (*mapped, *table.names) if n not in (*named, *TIMES, *used)]
    for name in missing:
        fault = unknown("column", name, valid)
        if name != missing[0]:
            fault = fault.partition(" (there ")[0]
        faults.append(f"{toml}, [{named[name]}] {name!r}: {fault}")
    return sources, faults


def _in_its_unit(column: str, source: Source) -> tuple[Source, str]:
    """A source with the unit that the file's own name for it ends in; or what contradicts that."""
    ours, theirs = claimed_unit(column), claimed_unit(source.column)
    units = unit_factors()
    if source.unit or theirs not in units or theirs == ours:
        return source, ""
    plain, alike = source.factor == 1.0 and not source.offset, units[ours][0] == units[theirs][0]
    if plain and alike:
        return replace(source, unit=theirs.removeprefix("_")), ""
    if alike or plain:
        product = "factor × number + offset" if alike else f"a number of {source.column!r}"
        return source, f"which unit {product} is in is unclear; say unit = {ours[1:]!r} or another"
    return source, ""


def _suggestion(
    table: OpenTable,
    layout: Layout,
    described: Mapping[str, str],
    sources: Mapping[str, Source],
    clock: str,
    toml: str,
) -> list[str]:
    """The entries of [columns] with which a table would be read, as far as its names say."""
    entries = []
    if not clock:
        dates = (n for n in table.names if table.sample.get(n) == A_DATE)
        name = next((n for n in table.names if _CLOCK.fullmatch(n)), next(dates, "…"))
        entries.append((_clock_name(name, table.sample.get(name, "")), name))
    rest = [n for n in table.names if n not in (*described, *TIMES, *(e[1] for e in entries))]
    missing = [c for c in described if c not in (*table.names, *layout.columns, *TIMES)]
    for column in missing:
        near = get_close_matches(column, rest, 1) or (
            rest if len(rest) == len(missing) == 1 else []
        )
        entries.append((column, (near or ["…"])[0]))
    entries += [(proposed_name(c), c) for c in described if c in table.names and c not in sources]
    lines = [f"{column} = {json.dumps(name, ensure_ascii=False)}" for column, name in entries]
    unit = ", with units such as deg in the place of UNIT" if "UNIT" in " ".join(lines) else ""
    return [
        f"{toml} says in a table [columns] which columns are meant; [drive] and [measured] take the"
        f" names on its left{unit}:",
        "[columns]",
        *lines,
        'or, of other numbers, such as counts: … = { column = "…", factor = …, offset = …, unit ='
        ' "…" }',
    ]


def _clock_name(name: str, sample: str) -> str:
    """Name for a column of times, with the unit that its first value seems to have."""
    if (unit := claimed_unit(name)) in ("_s", "_ms", "_us", "_ns"):
        return f"time{unit}"
    try:
        size = float(sample)
    except ValueError:
        return TIME if sample else "time_UNIT"
    # since 1970
    units = {"time_ns": 1e17, "time_us": 1e14, "time_ms": 1e11, "time_s": _SINCE_1970}
    return next((unit for unit, least in units.items() if size >= least), "time_UNIT")


def _clock(
    cells: NDArray[Any], clock: str, source: Source, rows: NDArray[np.int64], where: str
) -> _Clock:
    """Times as they are in a file: numbers, dates, or ISO 8601 and durations as text."""
    if cells.dtype.kind in "fiu":
        return _Clock(cells, ~np.isnan(cells), source.factor * source.ratio(clock), dated=False)
    nanoseconds = 1e-9 / si_name(clock)[1]
    if cells.dtype.kind in "mM":
        dates = cells.astype(f"{cells.dtype.kind}8[ns]")
        return _Clock(dates.astype(np.int64), ~np.isnat(dates), nanoseconds, dated=True)
    text = pd.Series(cells, dtype=object)
    there = text.notna().to_numpy()
    written = text[there].astype(str).str.strip()
    for kind in (np.int64, np.float64):
        with suppress(ValueError, OverflowError):
            stamps = np.zeros(there.size, kind)
            stamps[there] = [int(cell) if kind is np.int64 else float(cell) for cell in written]
            return _Clock(stamps, there, source.factor * source.ratio(clock), dated=False)
    as_dates = pd.to_datetime(written, format="ISO8601", utc=True, errors="coerce")
    as_spans = pd.to_timedelta(written, errors="coerce")
    best = min(as_dates, as_spans, key=lambda times: times.isna().sum())
    bad = best.isna().to_numpy()
    if bad.any():
        cell = f"{written.iloc[int(np.argmax(bad))]!r} is neither a number nor a time of ISO 8601"
        raise RecordingError(_at(where, rows[there][bad], source.column, cell))
    dates = np.zeros(there.size, np.int64)
    dates[there] = pd.Index(best).as_unit("ns").asi8
    return _Clock(dates, there, nanoseconds, dated=True)


def _spread(time: FloatArray, rows: NDArray[np.int64], where: str) -> FloatArray:
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


def _size_faults(
    values: FloatArray, rows: NDArray[np.int64], column: str, where: str
) -> Sequence[str]:
    """That numbers are infinite, or too large to be computed with."""
    bad = np.flatnonzero(np.abs(values) > LARGEST)
    if not bad.size:
        return ()
    value = float(values[bad[0]])
    fault = excess(value) if np.isfinite(value) else f"{value} is not finite"
    return (_at(where, rows[bad], column, fault),)


def _at(where: str, rows: NDArray[np.int64], column: str, fault: str) -> str:
    return f"{where}, row {rows[0]}, column {column!r}: {fault}{and_more(rows.size)}"


def _refusal(faults: Sequence[str]) -> RecordingError:
    return RecordingError("\n".join(dict.fromkeys(faults)))


def _warn(text: str) -> None:
    warnings.warn(text, TendonWarning, stacklevel=2)
