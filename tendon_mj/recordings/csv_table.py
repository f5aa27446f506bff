"""The numbers of a recording as CSV, read through pandas and held to what a table may be."""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

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
from tendon_mj.recordings.text_file import LARGEST, check_file, read_text
from tendon_mj.whole_file import whole_file

# what a cell may be; NaN and inf are refused by name
_NUMBER = re.compile(
    r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?|nan|inf|infinity)", re.IGNORECASE
)
_LONGEST_ROW = 2**20  # characters: thousands of columns
_BLOCK = 2**24  # characters that are read at a time: a table takes many times its text otherwise


def read_csv(path: Path, elements: Collection[str] = ()) -> dict[str, FloatArray]:
    """Read a CSV into its columns in file order, the time first; each (n,) [the file's unit].

    Raises `RecordingError`, naming file, row (the header is row 1) and column, for whatever
    `check_table` refuses and for empty files, duplicate columns, ragged or empty rows, and cells
    that are empty or no numbers.
    """
    check_file(path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            return _read(file, path, elements)
    except UnicodeDecodeError:
        read_text(path)  # which says where
        raise


def _read(file: TextIO, path: Path, elements: Collection[str]) -> dict[str, FloatArray]:
    header, texts = file.readline(_LONGEST_ROW), _blocks(file, path)
    if len(header) == _LONGEST_ROW:
        raise RecordingError(
            f"{path}, row 1: {_LONGEST_ROW} characters or more; the first row is the names of"
            " the columns"
        )
    begun = list(islice(texts, 2))  # the first ends at its last row, whatever blank ones follow
    if not (header + "".join(begun[:1])).strip():
        raise RecordingError(f"{path}, row 1: the file is empty; its first column is {TIME!r}")
    names = [cell.strip() for cell in header.rstrip("\n").split(",")]
    check_names(names, str(path), elements=elements)
    if len(begun) < 2 and not any("\n" in text for text in begun):
        raise RecordingError(too_few_rows(len(begun), str(path)))
    row, blocks = 2, list[FloatArray]()
    for text in chain(begun, texts):
        count, cells = text.count("\n") + 1, _numbers(text, len(names))
        # pandas reads ragged rows and empty cells as NaN or not at all, and says no row
        if cells is None or cells.shape[0] != count or not np.isfinite(cells).all():
            fault = _first_bad_cell(text.split("\n"), row, names, path)
            raise RecordingError(fault or f"{path}: not a table of numbers")
        blocks.append(cells)
        row += count
        if (row - 2) * len(
            names
        ) * cells.itemsize > LARGEST:  # short cells take more than their text
            raise RecordingError(
                f"{path}, row {row}: its numbers are more than {LARGEST} bytes; split the recording"
            )
    table = {name: np.concatenate([b[:, k] for b in blocks]) for k, name in enumerate(names)}
    check_table(table, str(path), elements=elements)
    return table


def _blocks(file: TextIO, path: Path) -> Iterator[str]:
    """The rest of a file in blocks of rows, two at least, but for blank ones at its end."""
    blank, row = "", 2
    while lines := file.readlines(_BLOCK):
        if len(lines) == 1:
            lines.append(file.readline())
        longest = max(lines, key=len)
        if len(longest) >= _LONGEST_ROW:
            raise RecordingError(
                f"{path}, row {row + lines.index(longest)}: {len(longest)} characters; a row has"
                f" fewer than {_LONGEST_ROW}"
            )
        row += len(lines)
        text = "".join(lines)
        body = text.rstrip("\n")
        if body:
            yield blank + body
            blank = text[len(body) + 1 :]
        else:
            blank += text


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


def _first_bad_cell(lines: Sequence[str], first: int, names: Sequence[str], path: Path) -> str:
    """Say which cell of rows from ``first`` on is no number: slow, and only where there is one."""
    for row, line in enumerate(lines, start=first):
        cells = [cell.strip(" \t") for cell in line.split(",")]  # as pandas: other blanks are none
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
