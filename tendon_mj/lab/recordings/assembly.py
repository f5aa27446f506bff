"""The columns that a description names, out of the cells of a table: all its faults at once."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings.description import Layout, Source
from tendon_mj.lab.recordings.magnitude import LARGEST, excess
from tendon_mj.lab.recordings.table_checks import TIME, TIMES, OpenTable, name_fault, too_few_rows
from tendon_mj.lab.recordings.times import at, at_common_times, read_clock, spread
from tendon_mj.lab.recordings.units import claimed_unit, proposed_name, si_name, unit_factors
from tendon_mj.typing import FloatArray

_SPARSE = 0.6  # share of complete rows below which a row is a message: half are, of 100 and 50 Hz
_DAY = 86400.0  # [s]
_SINCE_1970 = 1e8  # [s]: a date, and not a stopwatch
_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_CLOCK = re.compile(r"(.*[\W_])?(time|t|stamp|timestamp|zeit)([\W_].*)?", re.IGNORECASE)


class Table(NamedTuple):
    """Columns of a table, the time first, each (n,) [the unit in its name]; their (n,) rows."""

    columns: dict[str, FloatArray]
    rows: NDArray[np.int64] | None = None


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

    Rows in which none of the named columns has a value are passed over, as of events. Where few of
    the others are complete, a row is a message, and `at_common_times` joins them.

    Args:
        table: opened.
        where: the file, for messages.
        layout: where the named columns are.
        described: column → table of the description that names it; None: all columns are needed.
        held: columns that keep their value until the next one.
        elements: as of `name_fault`.
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
        header = max(table.first - 1, 1)
        faults.append(f"{where}, row {header}: no column is named {', '.join(map(repr, TIMES))}")
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
        time = read_clock(cells[of_clock], clock, sources[clock], rows, where)
    except RecordingError as error:
        raise _refusal([*faults, str(error)]) from None
    kept = filled.any(axis=0) if columns else time.there
    if not time.there[kept].all():
        faults.append(at(where, rows[kept & ~time.there], of_clock, "empty cell"))
        kept &= time.there
    if kept.sum() < 2 and not faults:
        faults.append(too_few_rows(int(kept.sum()), where))
    rows, stamps, filled = rows[kept], time.stamps[kept], filled[:, kept]
    numbers = {column: values[kept] for column, values in numbers.items()}
    sparse = len(columns) > 1 and filled.all(axis=0).sum() < _SPARSE * rows.size
    for column, there in zip(columns, filled, strict=True):
        source = sources[column].column
        faults += _size_faults(numbers[column], rows, source, where)
        fault = sources[column].period_fault(numbers[column][there])
        faults += [f"{where}, column {source!r}: {fault}"] if fault else []
        if not there.all() and not (sparse and there.any()):
            gap = "empty cell or nan; leave out rows that have a gap"
            faults.append(at(where, rows[~there], source, gap))
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    if back.size:
        before, after = map(time.shown, stamps[back[0] : back[0] + 2])
        step = f"{after} does not come after {before} of the row before"
        dropped = float(stamps[back[0]] - stamps[back[0] + 1]) * time.scale * si_name(clock)[1]
        if 0.5 * _DAY < dropped < 1.5 * _DAY:
            step += (
                "; a time of day begins again at midnight: write times with their date, such as"
                " 2026-03-02T23:59:59, or add 24 h from that row on"
            )
        faults.append(at(where, rows[back + 1], of_clock, step))
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
    since_1970 = abs(float(stamps[0])) * time.scale * si_name(clock)[1] >= _SINCE_1970
    if time.dated or (since_1970 and clock in layout.columns):
        stamps = stamps - stamps[0]
    times = np.asarray(stamps, np.float64)
    times = times if time.scale == 1.0 else times * time.scale
    return Table({clock: spread(times, rows, f"{where}, column {of_clock!r}")} | converted, rows)


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
    used = {source.column: column for column, source in mapped.items()}
    for place, name in enumerate(table.names, start=1):
        needed = described is None or name in described
        if name in mapped or (name in used and not needed):
            continue
        here, first = f"{header}, column {place}", table.names.index(name) + 1
        fault = name_fault(name, elements=elements)
        if fault and described and name in used:
            table_of = f"{toml}, [{described[name]}] {name!r}"
            faults.append(f"{table_of}: write {used[name]!r}, as [columns] names it")
        elif fault and needed:
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
        faults.append(f"{toml}, [{named[name]}] {name!r}: {fault}, in {where}")
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
        dates = (n for n in table.names if _DATE.match(table.sample.get(n, "")))
        name = next((n for n in table.names if _CLOCK.fullmatch(n)), next(dates, "…"))
        entries.append((_clock_name(name, table.sample.get(name, "")), name))
    mapped = {source.column for source in layout.columns.values()}
    entries += [
        (proposed_name(c), c)
        for c in described
        if c in table.names and c not in sources and c not in mapped
    ]
    rest = [n for n in table.names if n not in (*described, *TIMES, *(e[1] for e in entries))]
    missing = [c for c in described if c not in (*table.names, *layout.columns, *TIMES)]
    near = {column: get_close_matches(column, rest, 1, 0.5) for column in missing}
    if not entries and all(near.values()):
        return []  # misspelt, as the faults say
    only = rest if len(rest) == len(missing) == 1 else ["…"]
    entries += [(column, (names or only)[0]) for column, names in near.items()]
    lines = [f"{column} = {json.dumps(name, ensure_ascii=False)}" for column, name in entries]
    others = [entry for entry in entries if entry[0] not in TIMES]
    angles = [entry for entry in others if entry[0].endswith(("_deg", "_rad"))]
    column, name = (*angles, *others, ("lever_deg", "…"))[0]
    factor, of = (
        ('0.087890625, unit = "deg"', ", as counts of 4096 a turn") if angles else ("…", "")
    )
    example = f"{column} = {{ column = {json.dumps(name, ensure_ascii=False)}, factor = {factor} }}"
    return [
        f"add to {toml}; [drive] and [measured] use the names on the left, with a unit for UNIT:",
        "[columns]",
        *lines,
        f"where numbers are in no unit{of}: {example}",
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


def _size_faults(
    values: FloatArray, rows: NDArray[np.int64], column: str, where: str
) -> Sequence[str]:
    """That numbers are infinite, or too large to be computed with."""
    bad = np.flatnonzero(np.abs(values) > LARGEST)
    if not bad.size:
        return ()
    value = float(values[bad[0]])
    fault = excess(value) if np.isfinite(value) else f"{value} is not finite"
    return (at(where, rows[bad], column, fault),)


def _refusal(faults: Sequence[str]) -> RecordingError:
    return RecordingError("\n".join(dict.fromkeys(faults)))
