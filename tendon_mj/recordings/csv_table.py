"""The numbers of a recording: a CSV of time series with SI units in the column names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.recordings.text_file import read_text
from tendon_mj.whole_file import whole_file

FloatArray = NDArray[np.float64]

TIME = "time_s"
UNITS = ("_s", "_m", "_N", "_rad", "_Nm", "_rad_per_s", "_m_per_s")

# the unit that a name claims, compound ones whole: `rate_deg_per_s` must not pass as seconds
_CLAIMED_UNIT = re.compile(r"(?:(?:^|_)[^_]+_per)?_[^_]+$")
# what numpy.loadtxt reads; NaN and inf are refused later, by name
_NUMBER = re.compile(
    r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?|nan|inf|infinity)", re.IGNORECASE
)


def read_table(path: Path) -> dict[str, FloatArray]:
    """Read a CSV into its columns in file order, ``time_s`` first; each of shape (n,) [its unit].

    Raises `RecordingError`, naming file, row (the header is row 1) and column, for whatever
    `check_table` refuses and for empty files, duplicate columns, ragged or empty rows, and cells
    that are empty or no numbers.
    """
    text = read_text(path)
    if not text.strip():
        raise RecordingError(f"{path}, row 1: the file is empty; its first column is {TIME!r}")
    header, *lines = text.rstrip("\n").split("\n")
    names = [cell.strip() for cell in header.split(",")]
    check_names(names, str(path))
    if len(lines) < 2:  # before loadtxt, which warns when it is given nothing
        raise RecordingError(_too_few_rows(len(lines), str(path)))
    try:
        cells = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2)
    except ValueError as error:
        raise RecordingError(_first_bad_cell(lines, names, path) or f"{path}: {error}") from None
    # loadtxt skips empty lines and knows nothing of the header
    if cells.shape != (len(lines), len(names)):
        raise RecordingError(_first_bad_cell(lines, names, path) or f"{path}: ragged rows")
    table = dict(zip(names, np.ascontiguousarray(cells.T), strict=True))
    check_table(table, str(path))
    return table


def write_table(table: Mapping[str, FloatArray], path: Path) -> None:
    """Write columns, each (n,) [its unit], as a CSV that reads back bit for bit."""
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    with whole_file(path) as made, made.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(table) + "\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def check_names(names: Sequence[str], where: str) -> None:
    """Raise `RecordingError` unless the names are unique, carry units and begin with ``time_s``."""
    for position, name in enumerate(names, start=1):
        here = f"{where}, row 1, column {position}"
        if name in names[: position - 1]:
            first = names.index(name) + 1
            raise RecordingError(f"{here}: {name!r} is already the name of column {first}")
        if position == 1 and name != TIME:
            hint = f" (it is column {names.index(TIME) + 1})" if TIME in names else ""
            comma = "; cells are separated by commas" if TIME in re.split("[;\t ]", name) else ""
            raise RecordingError(f"{here}: the first column is {TIME!r}{hint}, not {name!r}{comma}")
        if name != name.strip() or not name.isprintable() or {",", '"'} & set(name):
            raise RecordingError(
                f"{here}: {name!r} is no column name; write a word such as 'tension_N', unquoted"
            )
        claimed = _CLAIMED_UNIT.search(name)
        unit = claimed.group() if claimed else name
        if unit not in UNITS or unit == name:
            raise RecordingError(
                f"{here}: {name!r} does not end in an SI unit: {unknown('unit', unit, UNITS)}"
            )
        if f"_{name.removesuffix(unit)}".endswith(UNITS):  # `speed_m_s` is not in seconds
            raise RecordingError(
                f"{here}: {name!r} ends in two units; write one of {', '.join(UNITS)}"
            )


def check_table(table: Mapping[str, FloatArray], where: str) -> None:
    """Raise `RecordingError` unless the columns, each (n,), are lawful; rows as in the CSV.

    That is: names as in `check_names`, equal lengths of at least 2, every value finite and
    ``time_s`` strictly increasing.
    """
    check_names(list(table), where)
    time = table[TIME]
    for name, column in table.items():
        if column.ndim != 1 or column.shape != time.shape:
            raise RecordingError(
                f"{where}, column {name!r}: shape {column.shape}, but {TIME!r} has {time.shape}"
                " and (n,) is needed"
            )
    if time.size < 2:
        raise RecordingError(_too_few_rows(time.size, where))
    for name, column in table.items():
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise RecordingError(
                f"{where}, row {bad[0] + 2}, column {name!r}: {column[bad[0]]} is not finite"
            )
    back = np.flatnonzero(time[1:] <= time[:-1])
    if back.size:
        before, after = time[back[0]].item(), time[back[0] + 1].item()
        raise RecordingError(
            f"{where}, row {back[0] + 3}, column {TIME!r}: {after!r} does not come after {before!r}"
            " of the row before; time strictly increases"
        )


def _too_few_rows(count: int, where: str) -> str:
    return f"{where}, row {count + 2}: missing; at least 2 rows are needed below the header"


def _first_bad_cell(lines: Sequence[str], names: Sequence[str], path: Path) -> str:
    """Say which cell numpy.loadtxt stumbled over: slow, and only walked when it did."""
    for row, line in enumerate(lines, start=2):
        cells = [cell.strip() for cell in line.split(",")]
        if cells == [""] and len(names) > 1:
            return f"{path}, row {row}: empty row"
        for name, cell in zip(names, cells, strict=False):
            if not _NUMBER.fullmatch(cell):
                fault = f"{cell!r} is not a number" if cell else "empty cell"
                return f"{path}, row {row}, column {name!r}: {fault}"
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
