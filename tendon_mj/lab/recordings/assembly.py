"""The columns that a description names, out of the cells of a table; all faults in one message."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.clock import (
    SINCE_1970,
    Stamps,
    at_common_times,
    going_back,
    read_clock,
    spread,
)
from tendon_mj.lab.recordings.column_names import ColumnNames, clock_of
from tendon_mj.lab.recordings.description import Source, TableLayout
from tendon_mj.lab.recordings.table import OpenTable, Table, at, too_few_rows, warn
from tendon_mj.lab.units import LARGEST, TIME, TIMES, excess, si_name
from tendon_mj.typing import BoolArray, FloatArray

_SPARSE = 0.6  # share of complete rows below which a row is a message: half are, of 100 and 50 Hz


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
    names = ColumnNames(table, where, layout, described or {}, described is None, toml)
    sources, faults = names.sources(elements)
    named = sources if described is None else [*columns, *described]
    needed = [c for c in dict.fromkeys(named) if c in sources.keys() - {*TIMES}]
    clock = clock_of(sources)
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
    lost = "friction remembers it: begin another recording"
    then = lost if layout.settled else "the row is left out"
    for column, gap in gaps.items():
        if gap.any():
            fault = at(where, rows[gap], sources[column].column, f"empty cell or nan; {then}")
            (faults.append if layout.settled else warn)(fault)
    if kept.sum() < 2 and not faults:
        faults.append(too_few_rows(int(kept.sum()), where))
    numbers = {column: values[kept] for column, values in numbers.items()}
    stamps, rows, filled = time.stamps[kept], rows[kept], filled[:, kept]
    if period := sources[clock].period:
        if fault := sources[clock].period_fault(stamps):
            faults.append(f"{where}, column {sources[clock].column!r}: {fault}")
        begun = np.append(False, stamps[1:] < stamps[:-1] - 0.5 * period)
        stamps = stamps + np.asarray(period * np.cumsum(begun), stamps.dtype)
    samples = _Samples(where, sources, clock, time, stamps, rows, numbers, needed, filled)
    if faults := [*faults, *samples.faults()]:
        raise _refusal(faults)
    return samples.joined(held) if _is_sparse(filled) else samples.table(layout)


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
            column = self.sources[self.clock].column
            fault, out = going_back(self.time, self.stamps, self._scale, self.clock, column)
            faults.append(at(self.where, self.rows[back + 1], column, fault) + out)
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
        since_1970 = abs(float(stamps[0])) * self._scale >= SINCE_1970
        if self.time.dated or (since_1970 and self.clock in layout.columns):
            stamps = stamps - stamps[0]
        times = np.asarray(stamps, np.float64)
        times = times if scale == 1.0 else times * scale
        place = f"{self.where}, column {self.sources[self.clock].column!r}"
        return Table({self.clock: spread(times, self.rows, place)} | converted, self.rows)


def _refusal(faults: Sequence[str]) -> RecordingError:
    return RecordingError("\n".join(dict.fromkeys(faults)))
