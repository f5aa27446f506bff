"""Tables in CSV files, through pandas: preambles, second headers, decimal commas, footers."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from io import BytesIO
from pathlib import Path
from statistics import mode
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.files import read_text
from tendon_mj.lab.recordings.table import DATUM, Columns, OpenTable, and_more, warn
from tendon_mj.lab.units import UNIT, UNIT_FACTORS, claimed_unit, proposed_name
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_AHEAD = 2**16  # characters that are searched for decimal commas, or for the last row
_EXACT = 15  # digits of an integer that a float holds; ns since 1970 have more
_EXTRA = "extra"  # the cells behind the last column


def open_csv(path: Path, header: Sequence[str] = ()) -> OpenTable:
    """The names of a CSV's columns, and how to read them.

    ``header``: names of the columns of a file that has none.
    """
    text = read_text(path)
    row, units, comment, (first_row, begin) = _above_values(text, path)
    separator, first, here = row.separator, row.cells, f"{path}, row {row.number}"
    names, full, named = list(header) or first, dict[str, str](), first_row > row.number
    if header and named:
        raise RecordingError(
            f"{here}: holds names, {first[0]!r} and so on; take header = … out of the description"
        )
    if not header and not named:
        names = _cells(comment.lstrip("# "), separator)
        if len(names) != len(first):
            raise RecordingError(
                f"{here}: holds numbers, not the names of the columns; write into the description,"
                f' above its tables: header = ["time_s", …], names of all {len(first)} columns'
            )
    if units:
        names = [_with_unit(*pair) for pair in zip(first, units, strict=True)]
        full = {short: name for short, name in zip(first, names, strict=True) if short != name}
    rows = text[begin:]
    decimal = "." if separator == "," else _decimal(path, rows[:_AHEAD])
    sample = dict(zip(names, _cells(rows.partition("\n")[0], separator), strict=False))
    body = _Body(
        path, names, first if named else names, rows, first_row, separator, decimal, sample
    )
    return OpenTable(names, {*names, *full}.__contains__, first_row, body.read, sample, full)


def write_csv(table: Mapping[str, FloatArray], path: Path) -> None:
    """Write columns, each (n,) [its unit], as a CSV that reads back bit for bit."""
    with whole_file(path) as made:
        pd.DataFrame(table).to_csv(made, index=False, lineterminator="\n")


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


class _Row(NamedTuple):
    number: int  # in the file
    begin: int  # in the text
    end: int
    cells: list[str]
    separator: str


def _above_values(text: str, path: Path) -> tuple[_Row, list[str], str, tuple[int, int]]:
    """The names of a CSV, their units if it has some, the last line above that begins with ``#``.

    Names and units are rows as long as most, with a text where most have a value, above the first
    one of values: the last of them, or the two last if the last one is of units. Without names it
    is the first row of values.

    Returns:
        These three, and the row and the place in the text at which the values begin.
    """
    tail = [line for line in text[-_AHEAD:].splitlines()[::-1] if line.strip()]
    usual = cache(partial(_have_values, tail[: (len(tail) + 1) // 2]))
    texts, others, values, comment = list[_Row](), list[_Row](), list[_Row](), ""
    for number, line in enumerate(re.finditer(r".*\n?", text), start=1):
        separator = _separator(line[0])
        row = _Row(number, line.start(), line.end(), _cells(line[0], separator), separator)
        if line[0].startswith("#"):
            comment = line[0]
        elif line[0].strip():
            pairs = zip(row.cells, usual(separator), strict=False)
            data = [DATUM.fullmatch(cell) is not None for cell, has in pairs if has and cell]
            whole = bool(data) and len(row.cells) == len(usual(separator))
            if whole and all(data):
                values.append(row)
                break
            (texts if whole and not any(data) else others).append(row)
    if names := texts[-1:] or others[:1]:
        last, units = names[0], _units(names[0].cells)
        width = len(last.cells)
        above = [row for row in texts + others if row < last and len(row.cells) == width]
        names, units = ([max(above)], units) if above and units else (names, [])
        return names[0], units, comment, (last.number + 1, last.end)
    if values:
        return values[0], [], comment, (values[0].number, values[0].begin)
    raise RecordingError(f"{path}, row 1: the file is empty")


def _have_values(lines: Sequence[str], separator: str) -> list[bool]:
    """Whether most cells of each column are a number or a time, in rows of the usual length."""
    rows = [_cells(line, separator) for line in lines]
    length = mode(map(len, rows))
    columns = zip(*(row for row in rows if len(row) == length), strict=True)
    filled = ([cell for cell in column if cell] for column in columns)
    return [2 * sum(map(bool, map(DATUM.fullmatch, cells))) > len(cells) for cells in filled]


def _units(cells: Sequence[str]) -> list[str]:
    """The units in a row of texts, of which one is known at least; empty if it has none."""
    units = [cell.strip("[]() ") for cell in cells]
    return units if any(proposed_name(f"x {unit}")[1:] in UNIT_FACTORS for unit in units) else []


def _with_unit(name: str, unit: str) -> str:
    """A column's name that ends in the unit of a second header, in brackets if it is in doubt."""
    proposed = proposed_name(f"{name} {unit}")
    said, below = (claimed_unit(n) for n in (proposed_name(name), proposed))
    if not unit or name.endswith(f"_{unit}") or said == below:
        return name
    two = said in UNIT_FACTORS and UNIT_FACTORS[said][0] == UNIT_FACTORS.get(below, ("",))[0]
    return f"{name} [{unit}]" if two or UNIT in proposed else proposed


def _decimal(path: Path, text: str) -> str:
    """The decimal mark of numbers that are not between commas."""
    numbers = re.findall(r"(?<![\w,.])[+-]?(\d*,\d+)(?![\w,.])", text)
    if numbers and all(re.fullmatch(r"[1-9]\d{0,2},\d{3}", number) for number in numbers):
        raise RecordingError(
            f"{path}: {numbers[0]!r} has a comma for decimals or for thousands; write such numbers"
            " with a point, or without commas"
        )
    if numbers and (more := re.search(r"(?<![\w,.])[1-9]\d{0,2}(?:\.\d{3})+(?![\w.])", text)):
        raise RecordingError(
            f"{path}: {more[0]!r} has a point, and {numbers[0]!r} a comma for decimals; write"
            " numbers without marks between thousands"
        )
    return "," if numbers else "."


@dataclass(frozen=True)
class _Body:
    """The rows of a CSV below its names, and the names of the columns."""

    path: Path
    names: Sequence[str]
    written: Sequence[str]  # the names as the file has them
    rows: str
    first: int  # row of the file
    separator: str
    decimal: str
    sample: Mapping[str, str]

    def read(self, wanted: Mapping[str, bool], clock: str) -> tuple[Columns, list[str]]:
        """Columns by name, and the faults of their cells; see `OpenTable`.

        Columns are numbers, with NaN for empty cells; a clock of more digits than a number holds is
        of texts.
        """
        exact = len(self.sample.get(clock, "")) in range(1, _EXACT + 1)
        labels = {name: f"c{self.names.index(name)}" for name in wanted}
        frame = self._frame([*labels.values()], {} if exact or not clock else {labels[clock]: str})
        if clock and (times := frame[labels[clock]]).dtype.kind not in "iuf":
            frame = frame[: self._above_footer(times, clock)]
        cells, faults, width = Columns(), list[str](), len(self.names)
        more = frame[_EXTRA].dropna()
        for name, label in labels.items():
            column = frame[label]
            self._check_begun_once(column, name)
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
                f"{self.path}, row {self.first + more.index[0]}, column {width + 1}: {cell!r} is"
                f" one cell too many; the names end with column {width}, {self.names[-1]!r}"
            )
        return cells, faults

    def _above_footer(self, times: Any, clock: str) -> int:
        """Number of rows above those at the end of which the time is a text."""
        cells = times.to_numpy(object)
        is_time = (isinstance(c, str) and bool(DATUM.fullmatch(c)) for c in cells[::-1])
        end = len(cells) - next((k for k, found in enumerate(is_time) if found), 0)
        footer = times[end:].dropna()
        if not len(footer):
            return len(cells)
        warn(
            f"{self.path}, row {self.first + int(footer.index[0])}, column {clock!r}:"
            f" {footer.iloc[0]!r} is not a time; rows from there to the end are left out"
        )
        return int(footer.index[0])

    def _check_begun_once(self, column: Any, name: str) -> None:
        """Refuse a table in which the names stand again, as of a logger that was started twice."""
        if column.dtype.kind not in "iuf":
            again = np.flatnonzero(column == self.written[self.names.index(name)])
            if again.size:
                raise RecordingError(
                    f"{self.path}, row {self.first + int(again[0])}: the names stand there again;"
                    " make it the first row of another recording"
                )

    def _frame(self, labels: Sequence[str], kinds: Mapping[str, type]) -> Any:
        separator = r"\s+" if self.separator == " " else self.separator
        every = [*(f"c{k}" for k in range(len(self.names))), _EXTRA]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # from pandas 3.1 on `float_precision` is deprecated
            try:
                return pd.read_csv(
                    BytesIO((self.separator.join(every) + "\n" + self.rows).encode()),
                    sep=separator,
                    decimal=self.decimal,
                    usecols=[*labels, _EXTRA],
                    index_col=False,  # else rows that are too long have one, and are shifted
                    dtype={**kinds, _EXTRA: str},
                    na_values=["-", "--"],
                    skipinitialspace=True,
                    skip_blank_lines=False,
                    float_precision="round_trip",  # to the last bit, also in older versions
                    low_memory=False,  # one type for the whole of a column
                )
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
            f"{self.path}, row {self.first + int(bad.index[0])}, column {name!r}: {bad.iloc[0]!r}"
            f" is not a number{and_more(len(bad))}"
        )
