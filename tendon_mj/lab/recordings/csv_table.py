"""A CSV as it is in its file: names, separator and cells, which pandas reads."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.assembly import RawTable
from tendon_mj.lab.recordings.files import read_text

_TOP = re.compile(r"(?:(?:#.*|[^\S\n]*)\n)*")  # comments and blank lines above the names
_DATUM = re.compile(r"\s*(?:[+-]?\.?\d.*|nan)?\s*", re.IGNORECASE)  # a number, a time, or empty


def read_csv(path: Path, header: Sequence[str] = ()) -> RawTable:
    """Read a CSV.

    Lines that begin with ``#`` above the names are passed over. Without names below them, the last
    of these lines is the names, as `numpy.savetxt` writes them. ``header``: names of the columns of
    a file that has none.

    Raises:
        RecordingError: the file is empty, not UTF-8 or not a CSV, or its first row has no names.
    """
    text = read_text(path)
    top = re.match(_TOP, text)[0]  # type: ignore[index]  # it matches nothing, too
    first_line, _, below = text[len(top) :].partition("\n")
    if not first_line.strip():
        raise RecordingError(f"{path}, row 1: the file is empty")
    separator = _separator(first_line)
    first, row = _cells(first_line, separator), top.count("\n") + 1
    names = list(header) or first
    if all(map(_DATUM.fullmatch, first)):
        if not header:
            comment = top.rstrip("\n").rpartition("\n")[2]
            names = _cells(comment.lstrip("# "), separator)
            if len(names) != len(first):
                raise RecordingError(
                    f"{path}, row {row}: holds numbers, not the names of the columns; write into"
                    ' the description, above its tables: header = ["time_s", …], names of all'
                    f" {len(first)} columns"
                )
        below = text[len(top) :]
    elif header:
        raise RecordingError(
            f"{path}, row {row}: holds names, {first[0]!r} and so on; take header = … out of the"
            " description"
        )
    else:
        row += 1
    *columns, extra = _columns(below, len(names), separator, path)
    fault = ""
    if extra.notna().any():
        place = int(extra.first_valid_index())
        fault = (
            f"{path}, row {row + place}, column {len(names) + 1}: {extra[place]!r} is one cell too"
            f" many; the names end with column {len(names)}, {names[-1]!r}"
        )
    return RawTable(names, columns, row, fault)


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


def _columns(body: str, count: int, separator: str, path: Path) -> list[Any]:
    """Columns of rows without names: so many, and that of the cells behind them."""
    labels = [f"c{k}" for k in range(count + 1)]
    decimal = "," if separator == ";" and "," in body else "."
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # from pandas 3.1 on `float_precision` is deprecated
        try:
            frame = pd.read_csv(
                io.StringIO(separator.join(labels) + "\n" + body),
                sep=r"\s+" if separator == " " else separator,
                decimal=decimal,
                usecols=labels,
                index_col=False,  # else rows that are too long have one, and are shifted
                dtype={labels[-1]: str},
                skipinitialspace=True,
                skip_blank_lines=False,
                float_precision="round_trip",  # to the last bit, also in older versions
                low_memory=False,  # one type for the whole of a column
                dtype_backend="numpy_nullable",  # integers next to empty cells stay exact
            )
        except pd.errors.ParserError as error:  # such as a quote that does not end
            raise RecordingError(f"{path}: not a CSV: {error}") from None
    columns = [frame[label] for label in labels]
    if decimal == ",":
        columns = [c.str.replace(",", ".") if c.dtype == "string" else c for c in columns]
    return columns
