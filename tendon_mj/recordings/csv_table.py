"""The numbers of a recording as CSV, read through pandas and held to what a table may be."""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from tendon_mj.errors import RecordingError
from tendon_mj.recordings.table_checks import (
    TIME,
    FloatArray,
    check_names,
    check_table,
    too_few_rows,
)
from tendon_mj.recordings.text_file import read_text
from tendon_mj.whole_file import whole_file

# what a cell may be; NaN and inf are refused by name
_NUMBER = re.compile(
    r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?|nan|inf|infinity)", re.IGNORECASE
)


def read_csv(path: Path) -> dict[str, FloatArray]:
    """Read a CSV into its columns in file order, the time first; each (n,) [the file's unit].

    Raises `RecordingError`, naming file, row (the header is row 1) and column, for whatever
    `check_table` refuses and for empty files, duplicate columns, ragged or empty rows, and cells
    that are empty or no numbers.
    """
    text = read_text(path)
    if not text.strip():
        raise RecordingError(f"{path}, row 1: the file is empty; its first column is {TIME!r}")
    header, _, body = text.rstrip("\n").partition("\n")
    names = [cell.strip() for cell in header.split(",")]
    check_names(names, str(path))
    count = body.count("\n") + 1 if body else 0
    if count < 2:
        raise RecordingError(too_few_rows(count, str(path)))
    cells = _numbers(body, len(names))
    # pandas reads ragged rows and empty cells as NaN or not at all, and says no row
    if cells is None or cells.shape[0] != count or not np.isfinite(cells).all():
        fault = _first_bad_cell(body.split("\n"), names, path)
        raise RecordingError(fault or f"{path}: not a table of numbers")
    table = dict(zip(names, np.ascontiguousarray(cells.T), strict=True))
    check_table(table, str(path))
    return table


def write_csv(table: Mapping[str, FloatArray], path: Path) -> None:
    """Write columns, each (n,) [its unit], as a CSV that reads back bit for bit."""
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    with whole_file(path) as made, made.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(table) + "\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def _numbers(body: str, columns: int) -> FloatArray | None:
    """(rows, columns) of the text below the header; None where pandas finds no numbers."""
    if not re.fullmatch(r"[0-9eE+\-., \tnaifty\n]*", body, re.IGNORECASE):
        return None  # what pandas may take for a number, or an end of the cell: quotes, zero bytes
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # from pandas 3.1 on `float_precision` is deprecated
        warnings.simplefilter("error", pd.errors.ParserWarning)  # a row with too many cells
        try:
            frame = pd.read_csv(
                io.StringIO(body),
                header=None,
                names=list(range(columns)),
                index_col=False,
                dtype=np.float64,
                skipinitialspace=True,
                skip_blank_lines=False,
                float_precision="round_trip",  # to the last bit, also in older versions
            )
        except (ValueError, pd.errors.ParserError, pd.errors.ParserWarning):
            return None
    return np.asarray(frame.to_numpy(np.float64))


def _first_bad_cell(lines: Sequence[str], names: Sequence[str], path: Path) -> str:
    """Say which cell is no number: slow, and only walked where there is one."""
    for row, line in enumerate(lines, start=2):
        cells = [cell.strip() for cell in line.split(",")]
        if cells == [""] and len(names) > 1:
            return f"{path}, row {row}: empty row"
        for name, cell in zip(names, cells, strict=False):
            if not _NUMBER.fullmatch(cell):
                fault = f"{cell!r} is not a number" if cell else "empty cell"
                return f"{path}, row {row}, column {name!r}: {fault}"
            if not math.isfinite(float(cell)):
                return f"{path}, row {row}, column {name!r}: {float(cell)} is not finite"
        if len(cells) < len(names):
            return (
                f"{path}, row {row}, column {names[len(cells)]!r}: missing; the row has"
                f" {len(cells)} of {len(names)} cells"
            )
        if len(cells) > len(names):
            return (
                f"{path}, row {row}, column {len(names) + 1}: {cells[len(names)]!r} is one cell"
                f" too many; the header ends with column {len(names)}, {names[-1]!r}"
            )
    return ""
