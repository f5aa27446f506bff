"""The columns that a description names, out of the cells of a table; all faults in one message."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings.description import Source, TableLayout
from tendon_mj.lab.recordings.times import (
    at,
    at_common_times,
    read_clock,
    read_numbers,
    spread,
    too_few_rows,
)
from tendon_mj.lab.recordings.units import (
    LARGEST,
    TIME,
    TIMES,
    UNIT_FACTORS,
    claimed_unit,
    excess,
    name_fault,
    si_name,
)
from tendon_mj.typing import BoolArray, FloatArray

_SPARSE = 0.6  # share of complete rows below which a row is a message: half are, of 100 and 50 Hz
_SINCE_1970 = 1e8  # [s]: a date, not a stopwatch


@dataclass(frozen=True)
class RawTable:
    """A table as it is in its file.

    Attributes:
        names: of its columns, in order.
        columns: their cells, each a `pandas.Series`.
        first: row of the first values.
        fault: of the whole; empty if there is none.
    """

    names: list[str]
    columns: list[Any]
    first: int
    fault: str = ""

    def root(self, name: str) -> str | None:
        """The column that a name with dots is a part of; the name itself where it is a column."""
        parts = name.split(".")
        roots = (".".join(parts[:k]) for k in range(len(parts), 0, -1))
        return next((root for root in roots if root in self.names), None)

    def cells(self, name: str, where: str) -> Any:
        """A column, or the part of its lists and objects to which dots lead: ``position.1``."""
        root = self.root(name) or ""
        column, path = self.columns[self.names.index(root)], name[len(root) + 1 :]
        if not path:
            return column
        here = f"{where}, column {name!r}"
        return column.map(lambda cell: element(cell, path, here), na_action="ignore")


class Table(NamedTuple):
    """Columns of a table, the time first, each (n,) [the unit in its name]; their (n,) rows."""

    columns: dict[str, FloatArray]
    rows: NDArray[np.int64] | None = None


def element(value: Any, path: str, here: str) -> Any:
    """The part of nested lists and objects to which names and places with dots between lead.

    Raises:
        RecordingError: there is none; the message begins with ``here``.
    """
    for part in path.split("."):
        if isinstance(value, dict) and part in value:
            value = value[part]
        elif isinstance(value, list | np.ndarray) and part.isdecimal() and int(part) < len(value):
            value = value[int(part)]
        else:
            there = value if isinstance(value, dict) else ()
            raise RecordingError(f"{here}: {unknown('field', part, map(str, there))} in {path!r}")
    return value


def assemble(
    raw: RawTable, where: str, layout: TableLayout | None = None, elements: Collection[str] = ()
) -> Table:
    """Read the columns that a description names, and others with a valid name and valid numbers.

    Rows in which none of the named columns has a value are passed over, as of events. Where few of
    the others are complete, a row is a message, and `at_common_times` joins them.

    ``where`` is the file, for messages; without a ``layout`` all columns are needed; ``elements``
    as of `unit_fault`.

    Raises:
        RecordingError: all that is wrong with the table, a line each.
    """
    sources, faults = _sources(raw, where, layout, elements)
    clock = next((column for column in sources if column in TIMES), "")
    named = sources if layout is None else [*layout.columns, *layout.roles]
    layout = layout or TableLayout()
    rows = raw.first + np.arange(len(raw.columns[0]))
    series = dict[str, FloatArray]()
    for column, source in sources.items():
        if column not in TIMES:
            try:
                cells = raw.cells(source.column, where)
                series[column] = read_numbers(cells, source.column, rows, where)
            except RecordingError as error:
                faults += [str(error)] if column in named else []
    if not clock:
        raise _refusal(faults)
    try:
        time = read_clock(
            raw.cells(sources[clock].column, where), clock, sources[clock], rows, where
        )
    except RecordingError as error:
        raise _refusal([*faults, str(error)]) from None
    needed = [column for column in dict.fromkeys(named) if column in series]
    filled = {column: ~np.isnan(series[column]) for column in needed}
    kept = np.any([*filled.values()], axis=0) if needed else time.there
    if not time.there[kept].all():
        lost = rows[kept & ~time.there]
        faults.append(at(where, lost, sources[clock].column, "empty cell"))
        kept = kept & time.there
    if kept.sum() < 2:
        raise _refusal(faults or [too_few_rows(int(kept.sum()), where)])
    rows, stamps = rows[kept], time.stamps[kept]
    series = {column: values[kept] for column, values in series.items()}
    filled = {column: there[kept] for column, there in filled.items()}
    sparse = len(needed) > 1 and np.all([*filled.values()], axis=0).mean() < _SPARSE
    for column, there in filled.items():
        faults += _column_faults(sources[column], series[column], there, rows, sparse, where)
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    if back.size:
        first, second = (time.shown(stamp) for stamp in stamps[back[0] : back[0] + 2])
        fault = f"{second} does not come after {first} of the row before"
        faults.append(at(where, rows[back + 1], sources[clock].column, fault))
    if faults:
        raise _refusal(faults)
    if sparse:
        messages = {
            column: (stamps[there], sources[column].converted(series[column][there], column))
            for column, there in filled.items()
        }
        joined, chosen = at_common_times(messages, clock, time.scale, where, layout.held)
        return Table(joined, rows[filled[needed[0]]][chosen])
    converted = {
        column: sources[column].converted(values, column)
        for column, values in series.items()
        if column in needed or (np.abs(values) <= LARGEST).all()  # not if one is nan
    }
    since_1970 = abs(float(stamps[0])) * time.scale * si_name(clock)[1] >= _SINCE_1970
    if time.dated or (since_1970 and clock in layout.columns):
        stamps = stamps - stamps[0]
    times = np.asarray(stamps, np.float64)
    times = times if time.scale == 1.0 else times * time.scale
    place = f"{where}, column {sources[clock].column!r}"
    return Table({clock: spread(times, rows, place)} | converted, rows)


def _column_faults(
    source: Source,
    values: FloatArray,
    there: BoolArray,
    rows: NDArray[np.int64],
    sparse: bool,
    where: str,
) -> Iterator[str]:
    """Numbers out of range, beyond their period, and gaps."""
    large = np.flatnonzero(np.abs(values) > LARGEST)
    if large.size:
        yield at(where, rows[large], source.column, excess(float(values[large[0]])))
    if fault := source.period_fault(values[there]):
        yield f"{where}, column {source.column!r}: {fault}"
    if not there.all() and not (sparse and there.any()):
        gap = "empty cell or nan; leave out rows that have a gap"
        yield at(where, rows[~there], source.column, gap)


def _sources(
    raw: RawTable, where: str, layout: TableLayout | None, elements: Collection[str]
) -> tuple[dict[str, Source], list[str]]:
    """Place of each column that is named, or has a valid name; and faults of the names."""
    sources, faults = dict[str, Source](), list[str]()
    all_needed, layout = layout is None, layout or TableLayout()
    for column, source in layout.columns.items():
        try:
            sources[column] = _in_its_unit(column, source, raw)
        except RecordingError as error:
            faults.append(f"{layout.toml}, [columns] {column!r}: {error}")
    used = {source.column: column for column, source in layout.columns.items()}
    header = f"{where}, row {max(raw.first - 1, 1)}"
    for place, name in enumerate(raw.names, start=1):
        needed = all_needed or name in layout.roles
        if name in layout.columns or (name in used and not needed):
            continue
        fault, first = name_fault(name, elements=elements), raw.names.index(name) + 1
        if fault and name in used:
            fault = f"in [{layout.roles[name]}] write {used[name]!r}, as [columns] names it"
        elif not fault and first != place:
            fault = f"{name!r} is already the name of column {first}"
        if not fault:
            sources[name] = Source(column=name)
        elif needed:
            faults.append(f"{header}, column {place}: {fault}")
    here = {*layout.columns, *raw.names}
    for name, title in layout.roles.items():
        if name not in here:
            fault = unknown("column", name, here - {*layout.roles, *TIMES, *used})
            faults.append(f"{layout.toml}, [{title}] {name!r}: {fault}, in {where}")
    if raw.fault:
        faults.append(raw.fault)
    if not {*TIMES} & {*sources}:
        fault = unknown("column", TIME, raw.names)
        if not all_needed:
            fault += f'; under [columns] of {layout.toml} name yours, as in time_s = "stamp"'
        faults.append(f"{header}: {fault}")
    return sources, faults


def _in_its_unit(column: str, source: Source, raw: RawTable) -> Source:
    """A source of a table with the unit in which its own name ends."""
    if not source.column:
        raise RecordingError("is of a log; for a table write { column = … }")
    if raw.root(source.column) is None:
        raise RecordingError(unknown("column", source.column, raw.names))
    ours, theirs = claimed_unit(column), claimed_unit(source.column)
    if source.unit or theirs not in UNIT_FACTORS or theirs == ours:
        return source
    plain = source.factor == 1.0 and not source.offset
    if plain and UNIT_FACTORS[ours][0] == UNIT_FACTORS[theirs][0]:
        return replace(source, unit=theirs.removeprefix("_"))
    raise RecordingError(
        f"the unit of factor × {source.column!r} + offset is unclear; say unit = {ours[1:]!r} or"
        " another"
    )


def _refusal(faults: Collection[str]) -> RecordingError:
    return RecordingError("\n".join(dict.fromkeys(faults)))
