"""The names of a table's columns, and those that a description uses for them."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings.clock import SINCE_1970, WORD
from tendon_mj.lab.recordings.description import UNSAID, Source, TableLayout
from tendon_mj.lab.recordings.table import DATUM, Columns, OpenTable, warn
from tendon_mj.lab.units import (
    CURRENT,
    FOREIGN,
    FOREIGN_TIME,
    OF_CURRENT,
    TIME,
    TIMES,
    UNIT_FACTORS,
    claimed_unit,
    name_fault,
    proposed_name,
)

_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_CLOCK = re.compile(
    r"(.*[\W_])?(time|t|clock|stamp|timestamp|zeit|millis|micros)([\W_].*)?", re.IGNORECASE
)
_NANOSECONDS = re.compile(r"(^|[\W_])n(ano)?sec(s|onds)?$", re.IGNORECASE)
_ASKED = f'{{{{ column = {{}}, unit = "{UNSAID}" }}}}'


@dataclass(frozen=True)
class ColumnNames:
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
        clock = clock_of(sources)
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
            elif list(self.table.names).count(source.column) > 1:
                fault = f"{self.where} has several columns {source.column!r}; name them apart there"
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
        lines, found = list[str](), [name for of in alike.values() for name in of]
        once = {c: of[0] if len(of) == 1 == found.count(of[0]) else "…" for c, of in alike.items()}
        for column, name in (*entries, *once.items()):
            text = json.dumps(name, ensure_ascii=False)
            same = _words(column) == _words(name) and _quantity(column) == _quantity(name) != ""
            sure = (name == "…" or same or (column, name) in entries) and not _other_unit(name)
            lines.append(f"{column} = {text if sure else _ASKED.format(text)}")
        hints = {
            "…": f"# columns of the table: {', '.join(map(repr, rest))}",
            'time_UNIT = "…"': "# without a clock write above the tables: period = … # [s]",
            UNSAID: "# counts need a factor too: 0.087890625 [deg] if 4096 are a turn",
        }
        for name in names:
            if _other_unit(name):
                hints[f'"{name}"'] = f"# the file says two units of {name!r}: in which is it?"
            if _NANOSECONDS.search(name) and not clock:
                hints['time_UNIT = "…"'] += (
                    "\n# if seconds are in another column, and no two rows are a second apart:"
                    f' time_ns = {{ column = "{name}", period = 1000000000 }}'
                )
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
            since_1970 = float(text) >= SINCE_1970 * 1e9  # not even a counter of ns is so large
        except ValueError:
            return TIME if text else "time_UNIT", name
        return "time_ns" if since_1970 else "time_UNIT", name


def _quantity(column: str) -> str:
    """The SI unit of what a column's name says that it is in; empty if it says none."""
    return UNIT_FACTORS.get(claimed_unit(proposed_name(column)), ("", 1.0))[0]


def _other_unit(column: str) -> str:
    """The unit, such as ``_deg``, that a column's name says before its last one; empty if none."""
    name = proposed_name(column)
    other = claimed_unit(name.removesuffix(claimed_unit(name)))
    return other if {other, claimed_unit(name)} <= UNIT_FACTORS.keys() else ""


def _words(column: str) -> set[str]:
    """The words of a column's name, but for its unit."""
    name = proposed_name(column)
    return {*name.removesuffix(claimed_unit(name)).lower().split("_")}


def _grows(values: NDArray[Any]) -> bool:
    """True if numbers do not decrease and most increase, as a coarse clock's, or begin again."""
    steps = np.diff(values[~np.isnan(values)])
    again = steps < -0.5 * WORD
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
    if plain and alike and ours != _other_unit(source.column):
        return replace(source, unit=theirs.removeprefix("_")), ""
    if alike or plain:
        name = source.column or source.field
        product = f"a number of {name!r}" if plain else "factor × number + offset"
        return source, f"which unit {product} is in is unclear; say unit = {ours[1:]!r} or another"
    return source, ""


def _is_in_another(source: Source, theirs: str) -> bool:
    """Whether a description says another unit than the file, ``theirs``, of the same quantity."""
    ours = f"_{source.unit}"
    if source.factor != 1.0 or ours in (theirs, _other_unit(source.column)):
        return False
    known = {ours, theirs} <= UNIT_FACTORS.keys()
    return known and UNIT_FACTORS[ours][0] == UNIT_FACTORS[theirs][0]


def clock_of(columns: Collection[str]) -> str:
    """The column of times among some; empty if there is none."""
    return next((column for column in columns if column in TIMES), "")
