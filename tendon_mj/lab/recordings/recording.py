"""A recording: measured or simulated time series, and their meaning on a model; its files."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings.assembly import Table, assemble
from tendon_mj.lab.recordings.binary_files import read_mcap, read_parquet
from tendon_mj.lab.recordings.csv_table import read_csv
from tendon_mj.lab.recordings.description import (
    Description,
    TableLayout,
    format_description,
    parse_description,
    parse_toml,
)
from tendon_mj.lab.recordings.files import (
    check_file,
    check_format,
    read_text,
    table_beside,
)
from tendon_mj.lab.recordings.times import check_table, in_si
from tendon_mj.lab.recordings.units import TIME, si_name
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording(Description):
    """Time series and their description, validated and immutable.

    name: the file's stem; time: (n,) [s], strictly increasing; columns: name → (n,) [the unit its
    name ends in, of SI], every column but the time, also those neither driven nor measured;
    in_file: name → its name in the file, of those that were converted; beside: folder in which the
    description was, if it was read; rows: (n,) row of the file that each sample is, if it was read.
    These three matter to messages alone, not to equality.
    The other fields are `Description`'s. Arrays are read-only copies.
    Raises `RecordingError` for all that is refused in a file.
    """

    name: str
    time: FloatArray
    columns: Mapping[str, FloatArray]
    in_file: Mapping[str, str] = field(default_factory=dict)
    beside: Path | None = None
    rows: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        where = f"recording {self.name!r}"
        if not self.name.strip():
            raise RecordingError(f"{where}: the name must not be empty")
        if TIME in self.columns:
            raise RecordingError(f"{where}, column {TIME!r}: belongs in `time`, not in `columns`")
        freeze = object.__setattr__
        freeze(self, "time", _read_only(self.time))
        freeze(self, "columns", {n: _read_only(values) for n, values in self.columns.items()})
        lists = {c: names for c, names in self.drive.items() if not isinstance(names, str)}
        freeze(self, "drive", {**self.drive, **{c: tuple(names) for c, names in lists.items()}})
        for name in ("measured", "known", "uncertain", "session", "in_file"):
            freeze(self, name, dict(getattr(self, name)))
        check_table({TIME: self.time, **self.columns}, where, si=True)
        self.check(self.columns, where)

    def written(self, column: str) -> str:
        """A column's name as the file has it, for messages; its own if it was not converted."""
        return self.in_file.get(column, column)

    def row(self, sample: int) -> int:
        """Row of the file that a sample is, for messages; the first is row 2 unless it was read."""
        return sample + 2 if self.rows is None else int(self.rows[sample])

    def check_against(self, actuators: Collection[str], sensors: Collection[str]) -> None:
        """Raise `RecordingError`, with the nearest valid name, unless a model has all it needs.

        ``actuators``, hinges and slides among them, and ``sensors`` are the model's names.
        """
        read = [(column, measured.sensor) for column, measured in self.measured.items()]
        for table, kind, pairs, valid in (
            ("drive", "actuator", self.driven, actuators),
            ("measured", "sensor", read, sensors),
        ):
            for column, name in pairs:
                if name not in valid:
                    raise RecordingError(
                        f"recording {self.name!r}, [{table}] {self.written(column)!r}:"
                        f" {unknown(kind, name, valid)}"
                    )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Recording):
            return NotImplemented
        mine, theirs = ({TIME: r.time, **r.columns} for r in (self, other))
        return (
            all(getattr(self, f) == getattr(other, f) for f in _NOT_ARRAYS)
            and mine.keys() == theirs.keys()
            and all(np.array_equal(mine[name], theirs[name]) for name in mine)
        )


_NOT_COMPARED = ("time", "columns", "in_file", "beside", "rows")  # the first two are, as arrays
_NOT_ARRAYS = [f.name for f in fields(Recording) if f.name not in _NOT_COMPARED]


def read_recording(
    path: str | os.PathLike[str], description: str | os.PathLike[str] | None = None
) -> Recording:
    """Read a recording from its table and TOML; ``path`` is either of them or their common stem.

    The table is a CSV, a Parquet file (``.parquet``) or a log (``.mcap``). Columns in mm, deg and
    the like become columns in SI: ``x_mm`` is ``x_m`` of the recording, and its ``noise`` too.

    ``description`` is the TOML's path where it does not lie beside the table. Nothing in the files
    is evaluated. Raises `RecordingError`, naming file, row (the header is row 1), column and the
    nearest valid name, for anything docs/recording.md does not allow. A model's path is sought
    beside the description first.
    """
    file, toml = table_beside(Path(path))
    hint = f"; it describes {file.name}, or pass `description` (--description)"
    if description is not None:
        toml, hint = Path(description), ""
    check_file(file)
    check_format(file)
    described, layout = parse_toml(read_text(toml, hint), str(toml))
    table, rows = read_columns(file, layout)
    described.check(table, str(toml))
    columns = in_si(table, str(file))
    in_file = {si_name(name)[0]: name for name in table if si_name(name)[0] != name}
    return Recording(
        name=file.stem,
        time=columns.pop(TIME),
        columns=columns,
        in_file=in_file,
        beside=toml.parent,
        rows=rows,
        **vars(replace(described.in_si(), model=_model_beside(toml, described.model))),
    )


def read_table(path: Path, elements: Collection[str] = ()) -> dict[str, FloatArray]:
    """Read a CSV or Parquet file into its columns, ``time_s`` first; each (n,) [SI].

    ``x_mm`` of the file becomes ``x_m``. Raises `RecordingError`, naming file, row (the header is
    row 1) and column, for anything docs/recording.md does not allow. ``elements`` as in
    `unit_fault`.
    """
    return in_si(read_columns(path, elements=elements).columns, str(path))


def read_columns(
    path: Path, layout: TableLayout | None = None, elements: Collection[str] = ()
) -> Table:
    """The columns of a table, under the names and in the units of its description.

    Arguments as of `assemble`; without a layout every column of a table is needed.
    """
    check_format(path)
    if path.suffix.lower() == ".mcap":
        if layout is None:
            raise RecordingError(f"{path}: a log needs a description, which names its columns")
        return Table(read_mcap(path, layout))
    if path.suffix.lower() == ".parquet":
        raw = read_parquet(path)
    else:
        raw = read_csv(path, layout.header if layout else ())
    return assemble(raw, str(path), layout, elements)


def write_recording(recording: Recording, path: str | os.PathLike[str]) -> Path:
    """Write ``<stem>.csv`` and ``<stem>.toml`` in an existing folder, and return the CSV's path.

    Existing files are replaced. Reading it back gives the same recording bit for bit, named after
    the file's stem; a model that is a file is named by its path from there, so that it is found
    from any folder. Raises OSError where the folder cannot be written.
    """
    path = Path(path)
    stem = path.name.removesuffix(".toml").removesuffix(".csv")
    csv, toml = path.with_name(f"{stem}.csv"), path.with_name(f"{stem}.toml")
    table = pd.DataFrame({TIME: recording.time, **recording.columns})
    with whole_file(csv) as made:
        table.to_csv(made, index=False, lineterminator="\n")
    text = format_description(recording, _model_from(toml, recording.model))
    with whole_file(toml) as made:
        made.write_text(text, encoding="utf-8", newline="\n")
    return csv


def described_model(toml: Path) -> str:
    """The model that a description names, as `Recording.model`.

    Raises:
        RecordingError: the description cannot be read.
    """
    return _model_beside(toml, parse_description(read_text(toml), str(toml)).model)


def is_same_model(one: str, other: str) -> bool:
    """Whether two recordings' models are the same name, or paths to one file in one folder."""
    first, second = Path(one), Path(other)
    return one == other or (
        first.name == second.name
        and first.is_file()
        and second.parent.is_dir()
        and first.parent.samefile(second.parent)
    )


def _model_beside(toml: Path, model: str) -> str:
    """Path of the MJCF file of that name next to the description; else the name itself."""
    beside = toml.parent / model
    if not beside.is_file():
        return model
    plain = Path(os.path.normpath(beside))  # the same for a file that is named from several folders
    same = plain.exists() and plain.samefile(beside)  # no link on the way
    return str(plain if same else beside)


def _model_from(toml: Path, model: str) -> str:
    """Path of a model's file as the description has it, from its own folder; a name stays."""
    # of a link the link, beside which its includes are; names of models have no suffix
    file, folder = Path(model).parent.resolve() / Path(model).name, toml.parent.resolve()
    if file.suffix == "" or not file.is_file():
        return model
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # on another drive
        return model


def _read_only(values: ArrayLike) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
