"""The columns of a CSV: its names, preamble and separator; its cells are read through pandas."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import pandas as pd

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.assembly import Columns, OpenTable
from tendon_mj.lab.recordings.files import check_file, read_text
from tendon_mj.lab.recordings.times import and_more
from tendon_mj.lab.recordings.units import UNIT_FACTORS, proposed_name
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_AHEAD = 2**16  # characters that are searched for decimal commas
_EXACT = 15  # digits of an integer that a float holds; ns since 1970 have more
_EXTRA = "extra"  # the cells behind the last column
_DATUM = re.compile(r"\s*(?:[+-]?\.?\d.*|nan)?\s*", re.IGNORECASE)  # a number, a time, or empty


def open_csv(path: Path, header: Sequence[str] = ()) -> OpenTable:
    """The names of a CSV's columns, and how to read them.

    Lines that begin with ``#`` above the names are passed over. Without names below them, the last
    of these lines is the names, as `numpy.savetxt` writes them.

    Args:
        path: UTF-8, a byte-order mark is dropped.
        header: names of the columns of a file that has none.

    Raises:
        RecordingError: the file is empty, not UTF-8, too large, or its first row has no names.
    """
    check_file(path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            lines = _leading_lines(file)
            ahead = file.read(_AHEAD)
    except UnicodeDecodeError:
        read_text(path)  # raises with the place
        raise
    if not lines[-1].strip():
        raise RecordingError(f"{path}, row 1: the file is empty")
    separator = _separator(lines[-1])
    first, below = _cells(lines[-1], separator), _cells(ahead.partition("\n")[0], separator)
    no_names = all(map(_DATUM.fullmatch, first))
    names = _names(path, lines, separator, first, no_names, header)
    if not header and not no_names:
        _check_units_row(path, len(lines) + 1, first, below)
    decimal = "," if separator == ";" and "," in ahead else "."
    skipped = len(lines) - no_names
    sample = dict(zip(names, first if no_names else below, strict=False))
    body = _Body(path, names, skipped, separator, decimal)

    def read(wanted: Mapping[str, bool], clock: str) -> tuple[Columns, list[str]]:
        return body.read(wanted, clock, len(sample.get(clock, "")) in range(1, _EXACT + 1))

    return OpenTable(names, set(names).__contains__, skipped + 1, read, sample)


def write_csv(table: Mapping[str, FloatArray], path: Path) -> None:
    """Write columns, each (n,) [its unit], as a CSV that reads back bit for bit."""
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    with whole_file(path) as made, made.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(table) + "\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def _leading_lines(file: TextIO) -> list[str]:
    """Blank lines and comments at the top of a file, and the first line that is neither."""
    lines: list[str] = []
    while not lines or (lines[-1] and (lines[-1].startswith("#") or not lines[-1].strip())):
        lines.append(file.readline())
    return lines


def _separator(line: str) -> str:
    """The character between cells: a comma, or else a semicolon, a tab or blanks."""
    if ";" in line and line.count(";") >= line.count(","):
        return ";"
    return next((mark for mark in (",", "\t") if mark in line), " " if " " in line.strip() else ",")


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    rows = csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [cell.strip() for row in rows for cell in row]


def _names(
    path: Path,
    lines: Sequence[str],
    separator: str,
    first: list[str],
    no_names: bool,
    header: Sequence[str],
) -> list[str]:
    """Names of the columns: of the description, the first row, or the last comment above it."""
    here = f"{path}, row {len(lines)}"
    if header and not no_names:
        raise RecordingError(
            f"{here}: holds names, {first[0]!r} and so on; take header = … out of the description"
        )
    comment = _cells(lines[-2].lstrip("# "), separator) if len(lines) > 1 else []
    if header or not no_names:
        return list(header) or first
    if len(comment) == len(first):
        return comment
    raise RecordingError(
        f"{here}: holds numbers, not the names of the columns; write into the description, above"
        f' its tables: header = ["time_s", …], names of all {len(first)} columns'
    )


def _check_units_row(path: Path, row: int, names: Sequence[str], below: Sequence[str]) -> None:
    """Refuse a row of units, or words of which one is a unit, below the names."""
    units = [cell.strip("[]() ") for cell in below]
    some = any(f"_{cell}" in UNIT_FACTORS for cell in units)
    if len(below) != len(names) or not some or any(c and _DATUM.fullmatch(c) for c in units):
        return
    named = ", ".join(
        n if n.endswith(f"_{u}") else proposed_name(f"{n}_{u}")
        for n, u in zip(names, units, strict=True)
    )
    raise RecordingError(
        f"{path}, row {row}: holds units ({', '.join(below)}) and no values; delete the row and"
        f" name the columns with their units, such as {named}"
    )


@dataclass(frozen=True)
class _Body:
    """The rows of a CSV below its names, and the names of the columns."""

    path: Path
    names: Sequence[str]
    skipped: int  # rows above
    separator: str
    decimal: str

    def read(
        self, wanted: Mapping[str, bool], clock: str, exact: bool
    ) -> tuple[Columns, list[str]]:
        """Columns by name, and the faults of their cells; see `OpenTable`.

        Columns are numbers, with NaN for empty cells; the clock may be texts, and is unless it is
        ``exact`` as a number.
        """
        labels = {name: f"c{self.names.index(name)}" for name in wanted}
        frame = self._frame([*labels.values()], {} if exact or not clock else {labels[clock]: str})
        cells, faults, width = Columns(), list[str](), len(self.names)
        more = frame[_EXTRA].dropna()
        for name, label in labels.items():
            column = frame[label]
            if column.dtype.kind in "iuf":
                integer_clock = name == clock and column.dtype.kind == "i"
                cells[name] = column.to_numpy(np.int64 if integer_clock else np.float64)
            elif name == clock:
                cells[name] = column.to_numpy(object)
            else:
                fault = self._convert(column, name, cells)
                faults += [fault] if fault and wanted[name] else []
        if len(more):
            cell = frame[_EXTRA].astype(object)[more.index[0]]
            faults.append(
                f"{self.path}, row {self._row(more.index[0])}, column {width + 1}: {cell!r} is one"
                f" cell too many; the names end with column {width}, {self.names[-1]!r}"
            )
        return cells, faults

    def _row(self, place: int) -> int:
        return self.skipped + 1 + place

    def _frame(self, labels: Sequence[str], kinds: Mapping[str, type]) -> Any:
        separator = r"\s+" if self.separator == " " else self.separator
        with self.path.open(encoding="utf-8-sig") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # from pandas 3.1 on `float_precision` is deprecated
            for _ in range(self.skipped):
                file.readline()
            every = [*(f"c{k}" for k in range(len(self.names))), _EXTRA]
            try:
                return pd.read_csv(
                    _Named(self.separator.join(every) + "\n", file),
                    sep=separator,
                    decimal=self.decimal,
                    usecols=[*labels, _EXTRA],
                    index_col=False,  # else rows that are too long have one, and are shifted
                    dtype={**kinds, _EXTRA: str},
                    skipinitialspace=True,
                    skip_blank_lines=False,
                    float_precision="round_trip",  # to the last bit, also in older versions
                    low_memory=False,  # one type for the whole of a column
                )
            except UnicodeDecodeError:
                read_text(self.path)  # raises with the place
                raise
            except pd.errors.ParserError as error:  # such as a quote that does not end
                raise RecordingError(f"{self.path}: not a CSV: {error}") from None

    def _convert(self, column: Any, name: str, cells: Columns) -> str:
        """Add a column of texts to the cells if all are numbers; else return the fault."""
        texts = column.dropna().astype(str)
        point = texts.str.replace(",", ".") if self.decimal == "," else texts
        bad = texts[pd.to_numeric(point, errors="coerce").isna()]
        if bad.empty:
            cells[name] = point.astype(np.float64).reindex(column.index).to_numpy()
            return ""
        return (
            f"{self.path}, row {self._row(int(bad.index[0]))}, column {name!r}: {bad.iloc[0]!r} is"
            f" not a number{and_more(len(bad))}"
        )


class _Named:
    """A file for pandas below a row of names."""

    def __init__(self, names: str, file: TextIO) -> None:
        self._names, self._file = names, file

    def read(self, size: int = -1) -> str:
        names, self._names = self._names, ""
        return names or self._file.read(size)

    def __iter__(self) -> Iterator[str]:  # by which pandas recognises a file
        raise NotImplementedError
