"""The columns of a CSV, read through pandas; names, preamble and faults of cells with their row."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import pandas as pd

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.table_checks import Cells, OpenTable, and_more
from tendon_mj.lab.recordings.text_file import LARGEST, check_file, read_text
from tendon_mj.lab.recordings.units import proposed_name, unit_factors
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_LONGEST_ROW = 2**20  # characters: thousands of columns
_CHUNK = 2**24  # characters that are taken apart at a time, about
_AHEAD = 2**16  # characters that are looked at for decimal commas and the length of rows
_LONG = re.compile("[+-]?[0-9]{16,}")  # an integer, as ns since 1970, that a float may not hold
_EXTRA = "extra"  # the cells behind the last column
_DATUM = re.compile(r"\s*(?:[+-]?\.?\d.*|nan)?\s*", re.IGNORECASE)  # a number, a time, or empty


def open_csv(path: Path, header: Sequence[str] = ()) -> OpenTable:
    """The names of a CSV's columns, and how to read them.

    Lines that begin with ``#`` above the names are passed over. Where there are none below them,
    the last is the names, as `numpy.savetxt` writes them.

    Args:
        path: UTF-8, a byte-order mark is dropped.
        header: names of the columns of a file that has none.

    Raises:
        RecordingError: the file is empty, not UTF-8, too large, or its first row has no names.
    """
    check_file(path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            lines = _leading_lines(file, path)
            ahead = file.read(_AHEAD)
    except UnicodeDecodeError:
        read_text(path)  # which says where
        raise
    if not "".join(lines).strip():
        raise RecordingError(f"{path}, row 1: the file is empty")
    separator = _separator(lines[-1])
    above, first = lines[:-1], _cells(lines[-1], separator)
    below = _cells(ahead.partition("\n")[0], separator)
    decimal = "," if separator == ";" and "," in ahead else "."
    no_names = all(map(_DATUM.fullmatch, first))
    comment = _cells(above[-1].lstrip("# "), separator) if above else []
    if header:
        names, skipped = list(header), len(above)
        if not no_names:
            raise RecordingError(
                f"{path}, row {len(lines)}: holds names, {first[0]!r} and so on; take header = …"
                " out of the description"
            )
    elif not no_names:
        names, skipped = first, len(lines)
    elif len(comment) == len(first):
        names, skipped = comment, len(above)
    else:
        raise RecordingError(
            f"{path}, row {len(lines)}: holds numbers, not the names of the columns; write into the"
            f' description, above its tables: header = ["time_s", …], names of all {len(first)}'
            " columns"
        )
    units = [cell.strip("[]() ") for cell in below]
    if not header and not no_names and len(below) == len(first) and _are_units(units):
        named = ", ".join(
            n if n.endswith(f"_{u}") else proposed_name(f"{n}_{u}")
            for n, u in zip(names, units, strict=True)
        )
        raise RecordingError(
            f"{path}, row {len(lines) + 1}: holds units ({', '.join(below)}) and no values; delete"
            f" the row and name the columns with their units, such as {named}"
        )
    sample = dict(zip(names, first if no_names else below, strict=False))

    def read(wanted: Mapping[str, bool], clock: str) -> tuple[Cells, list[str]]:
        rows = _CHUNK * (ahead.count("\n") + 1) // (len(ahead) + 1)
        body = _Body(path, names, skipped, separator, decimal, max(rows, 2))
        return _read(body, wanted, clock)

    return OpenTable(names, set(names).__contains__, skipped + 1, read, sample)


def write_csv(table: Mapping[str, FloatArray], path: Path) -> None:
    """Write columns, each (n,) [its unit], as a CSV that reads back bit for bit."""
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    with whole_file(path) as made, made.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(table) + "\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def _leading_lines(file: TextIO, path: Path) -> list[str]:
    """Blank lines and comments at the top of a file, and the first line that is neither."""
    lines: list[str] = []
    while not lines or (lines[-1] and (lines[-1].startswith("#") or not lines[-1].strip())):
        lines.append(file.readline(_LONGEST_ROW))
        if len(lines[-1]) == _LONGEST_ROW or sum(map(len, lines)) > _LONGEST_ROW:
            raise RecordingError(
                f"{path}, row {len(lines)}: {_LONGEST_ROW} characters or more; the first row is the"
                " names of the columns"
            )
    return lines


def _separator(line: str) -> str:
    """What stands between cells: a comma, or a semicolon, tab or blanks where that is none."""
    if ";" in line and line.count(";") >= line.count(","):
        return ";"
    return next((mark for mark in (",", "\t") if mark in line), " " if " " in line.strip() else ",")


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    rows = csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [cell.strip() for row in rows for cell in row]


def _are_units(cells: Sequence[str]) -> bool:
    """Whether cells are units, or words of which one is."""
    return any(f"_{cell}" in unit_factors() for cell in cells) and not any(
        cell and _DATUM.fullmatch(cell) for cell in cells
    )


@dataclass(frozen=True)
class _Body:
    """The rows of a CSV below its names, and the names of the columns."""

    path: Path
    names: Sequence[str]
    skipped: int  # rows above
    separator: str
    decimal: str
    at_once: int  # rows

    def row(self, place: int) -> int:
        return self.skipped + 1 + place

    def chunks(
        self, places: Sequence[int], kinds: Mapping[str, type], rows: int | None = None
    ) -> Iterator[Any]:
        """Parts as frames: columns by their labels, and what is behind the last one."""
        labels = [*map(_label, range(len(self.names))), _EXTRA]
        separator = r"\s+" if self.separator == " " else self.separator
        with self.path.open(encoding="utf-8-sig") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # from pandas 3.1 on `float_precision` is deprecated
            try:
                yield from pd.read_csv(
                    _Rows(self.path, file, self.skipped, self.separator.join(labels) + "\n"),
                    sep=separator,
                    decimal=self.decimal,
                    usecols=[*map(_label, places), _EXTRA],
                    index_col=False,  # else rows that are too long have one, and are shifted
                    dtype={label: kinds.get(label, str) for label in labels},
                    skipinitialspace=True,
                    skip_blank_lines=False,
                    float_precision="round_trip",  # to the last bit, also in older versions
                    chunksize=rows or self.at_once,
                    nrows=rows,
                )
            except UnicodeDecodeError:
                read_text(self.path)  # which says where
                raise
            except pd.errors.ParserError as error:  # such as a quote that does not end
                raise RecordingError(f"{self.path}: not a CSV: {error}") from None

    def point(self, cells: Any) -> Any:
        """Texts with a decimal point."""
        return cells.str.replace(",", ".") if self.decimal == "," else cells


def _read(body: _Body, wanted: Mapping[str, bool], clock: str) -> tuple[Cells, list[str]]:
    """Columns by name, and the faults of their cells.

    Numbers are (n,) float64, NaN where a cell is empty; a clock of texts or of integers that a
    float cannot hold is (n,) of texts. One that is not needed is left out where it holds text.
    """
    places = {name: body.names.index(name) for name in wanted}
    texts = {clock} if clock and _is_text_clock(body, places[clock]) else set[str]()
    bad: dict[str, str] = {}
    for _ in range(2):
        good = {name: place for name, place in places.items() if name not in bad}
        try:
            cells, faults = _parsed(body, good, texts)
            return cells, [*(fault for name, fault in bad.items() if wanted[name]), *faults]
        except RecordingError:
            raise
        except ValueError as error:  # text where numbers are: another reading says where
            bad = _bad_cells(body, {k: v for k, v in places.items() if k not in texts})
            why = error
    raise RecordingError(f"{body.path}: not a table of numbers: {why}")


def _is_text_clock(body: _Body, place: int) -> bool:
    for chunk in body.chunks([place], {}, rows=100):
        for cell in body.point(chunk[_label(place)].dropna()):
            try:
                float(cell)
            except ValueError:
                return True
            return _LONG.fullmatch(cell) is not None
    return False


def _parsed(
    body: _Body, places: Mapping[str, int], texts: Collection[str]
) -> tuple[Cells, list[str]]:
    kinds = {_label(place): str if n in texts else float for n, place in places.items()}
    parts: dict[str, list[Any]] = {name: [] for name in places}
    faults, rows, width = list[str](), 0, len(body.names)
    for chunk in body.chunks(list(places.values()), kinds):
        for name, place in places.items():
            parts[name].append(chunk[_label(place)].to_numpy(object if name in texts else float))
        more = chunk[_EXTRA].dropna()
        if len(more) and not faults:
            faults.append(
                f"{body.path}, row {body.row(more.index[0])}, column {width + 1}: {more.iloc[0]!r}"
                f" is one cell too many; the names end with column {width}, {body.names[-1]!r}"
            )
        rows += len(chunk)
        if rows * max(len(places), 1) * 8 > LARGEST:  # short cells take more than their text
            raise RecordingError(
                f"{body.path}, row {body.row(rows) - 1}: its numbers are more than {LARGEST} bytes;"
                " split the recording"
            )
    cells = {name: np.concatenate(part) if part else np.zeros(0) for name, part in parts.items()}
    return cells, faults


def _bad_cells(body: _Body, places: Mapping[str, int]) -> dict[str, str]:
    """Column → its first cell that is neither a number nor empty, in words."""
    first: dict[str, tuple[int, str]] = {}
    count = dict.fromkeys(places, 0)
    for chunk in body.chunks(list(places.values()), {}):
        for name, place in places.items():
            there = chunk[_label(place)].dropna()
            bad = there[pd.to_numeric(body.point(there), errors="coerce").isna()]
            count[name] += len(bad)
            if len(bad) and name not in first:
                first[name] = int(bad.index[0]), str(bad.iloc[0])
    return {
        name: f"{body.path}, row {body.row(row)}, column {name!r}: {cell!r} is not a number"
        + and_more(count[name])
        for name, (row, cell) in first.items()
    }


def _label(place: int) -> str:
    return f"c{place}"


class _Rows:
    """The rows of a table for pandas, below a row of our names; none is longer than allowed."""

    def __init__(self, path: Path, file: TextIO, skipped: int, names: str) -> None:
        self._path, self._file, self._names = path, file, names
        self._row, self._length = skipped + 1, 0
        for _ in range(skipped):
            file.readline()

    def read(self, size: int = -1) -> str:
        if self._names:
            names, self._names = self._names, ""
            return names
        text = self._file.read(min(size, _LONGEST_ROW) if size > 0 else _LONGEST_ROW)
        if self._length + len(text.partition("\n")[0]) >= _LONGEST_ROW:
            raise RecordingError(
                f"{self._path}, row {self._row}: {_LONGEST_ROW} characters or more; a row has fewer"
            )
        ends = text.count("\n")
        self._length = len(text) - text.rfind("\n") - 1 if ends else self._length + len(text)
        self._row += ends
        return text

    def __iter__(self) -> Iterator[str]:  # by which pandas knows a file
        raise NotImplementedError
