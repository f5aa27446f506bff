"""Tables in files, through their readers: CSV (pandas), Parquet and LeRobot's (pyarrow)."""

from __future__ import annotations

import csv
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.assembly import (
    DATUM,
    Columns,
    OpenTable,
    and_more,
)
from tendon_mj.lab.recordings.files import (
    check_file,
    episode_files,
    episode_of,
    missing_reader,
    read_info,
    read_text,
)
from tendon_mj.lab.recordings.units import TIME, UNIT_FACTORS, proposed_name
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_AHEAD = 2**16  # characters that are searched for decimal commas
_EXACT = 15  # digits of an integer that a float holds; ns since 1970 have more
_EXTRA = "extra"  # the cells behind the last column
_FIRST = 2  # row of the first values in a CSV of the same table


def open_csv(path: Path, header: Sequence[str] = ()) -> OpenTable:
    """The names of a CSV's columns, and how to read them.

    Lines that begin with ``#`` above the names are passed over. Without names below them, the last
    of these lines is the names, as `numpy.savetxt` writes them. ``header``: names of the columns of
    a file that has none.
    """
    lines, more, rest = list[str](), "\n", read_text(path)
    while more and (not lines or lines[-1].startswith("#") or not lines[-1].strip()):
        line, more, rest = rest.partition("\n")
        lines.append(line)
    if lines[-1].startswith("#") or not lines[-1].strip():
        raise RecordingError(f"{path}, row 1: the file is empty")
    separator = _separator(lines[-1])
    first, below = _cells(lines[-1], separator), _cells(rest.partition("\n")[0], separator)
    no_names = all(map(DATUM.fullmatch, first))
    here = f"{path}, row {len(lines)}"
    if header and not no_names:
        raise RecordingError(
            f"{here}: holds names, {first[0]!r} and so on; take header = … out of the description"
        )
    names = list(header) or first
    if no_names and not header:
        names = _cells(lines[-2].lstrip("# "), separator) if len(lines) > 1 else []
        if len(names) != len(first):
            raise RecordingError(
                f"{here}: holds numbers, not the names of the columns; write into the description,"
                f' above its tables: header = ["time_s", …], names of all {len(first)} columns'
            )
    elif not header:
        _check_units_row(path, len(lines) + 1, first, below)
    decimal = "," if separator == ";" and "," in rest[:_AHEAD] else "."
    sample = dict(zip(names, first if no_names else below, strict=False))
    rows, first_row = rest, len(lines) + 1
    if no_names:
        rows, first_row = f"{lines[-1]}\n{rest}", len(lines)
    body = _Body(path, names, rows, first_row, separator, decimal, sample)
    return OpenTable(names, set(names).__contains__, first_row, body.read, sample)


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


def _check_units_row(path: Path, row: int, names: Sequence[str], below: Sequence[str]) -> None:
    """Refuse a row of units, or words of which one is a unit, below the names."""
    units = [cell.strip("[]() ") for cell in below]
    some = any(f"_{cell}" in UNIT_FACTORS for cell in units)
    if len(below) != len(names) or not some or any(c and DATUM.fullmatch(c) for c in units):
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
        return self.first + place

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
            f"{self.path}, row {self._row(int(bad.index[0]))}, column {name!r}: {bad.iloc[0]!r} is"
            f" not a number{and_more(len(bad))}"
        )


def open_parquet(path: Path) -> OpenTable:
    """The names of a Parquet file's columns, or of an episode's, and how to read them.

    Dots lead into lists and structs: ``position.0``. Rows in messages are those that a CSV of the
    same table would have.
    """
    check_file(path)
    episode = episode_of(path)
    files = [path] if episode is None else episode_files(path, episode)
    try:
        import pyarrow as pa
        import pyarrow.dataset as datasets
    except ImportError:
        raise missing_reader(path, "Parquet", "pyarrow", "parquet") from None
    broken = (pa.ArrowException, OSError, ValueError)  # ValueError: a name that is not UTF-8
    try:
        data = datasets.dataset(list(map(str, files)), format="parquet")
        schema = data.schema
        names = list(schema.names)
    except broken as error:
        raise RecordingError(f"{path}: not a Parquet file: {error}") from None
    if not names:
        raise RecordingError(f"{path}: holds no column")
    empty, place, rows = schema.empty_table(), dict[str, str](), None
    if episode is not None:
        place, rows = _places(path.parent), datasets.field("episode_index") == episode
        names = [*place, *(name for name in names if name not in place)]

    def read(wanted: Mapping[str, bool], clock: str) -> tuple[Columns, list[str]]:
        paths = {name: place.get(name, name) for name in wanted}
        roots = {name: _root(schema, at) for name, at in paths.items()}
        try:
            table = data.to_table(columns=list(dict.fromkeys(roots.values())), filter=rows)
            whole = {root: table.column(root) for root in roots.values()}
        except broken as error:
            raise RecordingError(f"{path}: not a Parquet file: {error}") from None
        if episode is not None and not table.num_rows:
            total = read_info(path.parent)["total_episodes"]
            raise RecordingError(
                f"{path}: no frame of episode {episode} in its data; the dataset has episodes 0 to"
                f" {total - 1}"
            )
        cells, faults = Columns(), list[str]()
        for name, needed in wanted.items():
            rest = paths[name][len(roots[name]) + 1 :]
            try:
                cells[name] = _arrow_cells(_part(whole[roots[name]], rest), name == clock)
            except (pa.ArrowException, TypeError) as error:
                faults += [f"{path}, column {name!r}: {error}"] if needed else []
        return cells, faults

    def has(name: str) -> bool:
        at = place.get(name, name)
        root = _root(schema, at)
        try:
            return bool(root) and _part(empty.column(root), at[len(root) + 1 :]) is not None
        except (pa.ArrowException, TypeError):
            return False

    kinds = ((name, schema.field(name).type) for name in names if name in schema.names)
    sample = {name: "1970-01-01" for name, kind in kinds if pa.types.is_timestamp(kind)}
    return OpenTable(names, has, _FIRST, read, sample)


def _places(folder: Path) -> dict[str, str]:
    """Name of a column of a dataset of LeRobot → its place in the files.

    The clock, in seconds, and the elements of vectors that have names: ``action.elbow.pos``.
    """
    places = {TIME: "timestamp"}
    for feature, entry in read_info(folder)["features"].items():
        names = entry.get("names") if isinstance(entry, dict) else None
        names = next(iter(names.values()), []) if isinstance(names, dict) else names
        if isinstance(names, list) and len(set(map(str, names))) == len(names):
            places |= {f"{feature}.{name}": f"{feature}.{k}" for k, name in enumerate(names)}
    return places


def _root(schema: Any, name: str) -> str:
    """The column that a name with dots is a part of; the name itself where it is a column."""
    parts = name.split(".")
    roots = (".".join(parts[:k]) for k in range(len(parts), 0, -1))
    return next((root for root in roots if root in schema.names), "")


def _part(column: Any, rest: str) -> Any:
    """The elements of lists, and fields of structs, to which the rest of a name leads."""
    import pyarrow.compute as pc

    for part in filter(None, rest.split(".")):
        if part.isdecimal():
            column = pc.list_element(column, int(part))
        else:
            column = pc.struct_field(column, part)
    return column


def _arrow_cells(column: Any, is_clock: bool) -> Any:
    """Numbers with NaN for null; of a clock also dates and texts, as they are."""
    import pyarrow as pa

    kind = column.type
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        exact = is_clock and not column.null_count
        return np.asarray(column.to_numpy(), None if exact else np.float64)
    if is_clock and (pa.types.is_timestamp(kind) or pa.types.is_duration(kind)):
        return np.asarray(column.to_numpy())
    if is_clock and (pa.types.is_string(kind) or pa.types.is_large_string(kind)):
        return np.array([np.nan if cell is None else cell for cell in column.to_pylist()], object)
    raise TypeError(f"holds {kind}; a column holds numbers")
