"""A recording: measured or simulated time series, and their meaning on a model; its files."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings.assembly import assemble
from tendon_mj.lab.recordings.csv_files import open_csv, write_csv
from tendon_mj.lab.recordings.description import (
    Description,
    TableLayout,
    format_description,
    parse_toml,
)
from tendon_mj.lab.recordings.files import (
    check_file,
    check_format,
    episode_of,
    is_bag,
    read_text,
    table_beside,
)
from tendon_mj.lab.recordings.message_logs import read_log
from tendon_mj.lab.recordings.parquet_files import open_parquet
from tendon_mj.lab.recordings.table import Table, check_table, in_si
from tendon_mj.lab.units import TIME, si_name
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
    The other fields are `Description`'s. Arrays and mappings are copies, the arrays read-only.
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
        columns = {n: _frozen(v, f"{where}, column {n!r}") for n, v in self.columns.items()}
        freeze = object.__setattr__
        freeze(self, "time", _frozen(self.time, f"{where}, time"))
        freeze(self, "columns", columns)
        if self.rows is not None:
            rows = np.array(self.rows)
            rows.setflags(write=False)
            freeze(self, "rows", rows)
        drive = {c: n if isinstance(n, str) else tuple(n) for c, n in self.drive.items()}
        freeze(self, "drive", drive)
        for name in ("measured", "known", "uncertain", "session", "in_file"):
            freeze(self, name, dict(getattr(self, name)))
        if TIME in columns:
            raise RecordingError(f"{where}, column {TIME!r}: belongs in `time`, not in `columns`")
        check_table({TIME: self.time, **columns}, where, si=True)
        self.check(columns, where)

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

    def __repr__(self) -> str:
        span = f"{self.time[-1] - self.time[0]:.4g} s" if self.time.size else "empty"
        return (
            f"Recording({self.name!r} on model {self.model!r}: {self.time.size} samples, {span};"
            f" driven: {', '.join(self.drive) or 'none'};"
            f" measured: {', '.join(self.measured) or 'none'})"
        )

    def to_dataframe(self) -> pd.DataFrame:
        """The columns, each in the unit of its name, over the index `time_s`."""
        return pd.DataFrame(dict(self.columns), index=pd.Index(self.time, name=TIME))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Recording):
            return NotImplemented
        mine, theirs = ({TIME: r.time, **r.columns} for r in (self, other))
        return (
            super().__eq__(other)
            and self.name == other.name
            and mine.keys() == theirs.keys()
            and all(np.array_equal(mine[name], theirs[name]) for name in mine)
        )


GivenRecording = Recording | str | os.PathLike  # type: ignore[type-arg]  # of str; for isinstance


def read_given(
    recording: GivenRecording, description: str | os.PathLike[str] | None = None
) -> Recording:
    """A recording as it is, or as `read_recording` reads it from its path."""
    if isinstance(recording, Recording):
        return recording
    if not isinstance(recording, GivenRecording):
        raise RecordingError(
            f"a {type(recording).__name__} is neither a recording nor its path; of several "
            "recordings give one at a time"
        )
    return read_recording(recording, description)


def read_recording(
    path: str | os.PathLike[str], description: str | os.PathLike[str] | None = None
) -> Recording:
    """Read a recording from its table and TOML; ``path`` is either of them or their common stem.

    The table is a CSV, a Parquet file (``.parquet``), a log (``.mcap``), the folder or file of a
    bag of ROS, or an episode of a dataset of LeRobot (``<folder>/episode_3``). Columns in mm, deg
    and the like become columns in SI: ``x_mm`` is ``x_m`` of the recording, and its ``noise`` too.

    ``description`` is the TOML's path if it does not lie beside the table. Nothing in the files
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
    columns_of = {"drive": described.drive, "measured": described.measured}
    named = {column: title for title, columns in columns_of.items() for column in columns}
    table, rows = read_columns(file, layout, named, described.hold, toml=str(toml))
    described.check(table, str(toml))
    in_si_units = described.in_si(str(toml))
    columns = in_si(table, str(file))
    in_file = {si_name(name)[0]: name for name in table if si_name(name)[0] != name}
    return Recording(
        name=file.stem,
        time=columns.pop(TIME),
        columns=columns,
        in_file=in_file,
        beside=toml.parent,
        rows=rows,
        **vars(replace(in_si_units, model=_model_beside(toml, described.model))),
    )


def read_table(path: Path) -> dict[str, FloatArray]:
    """Read a CSV or Parquet file into its columns, ``time_s`` first; each (n,) [SI].

    ``x_mm`` of the file becomes ``x_m``. Raises `RecordingError`, naming file, row (the header is
    row 1) and column, for anything docs/recording.md does not allow.
    """
    return in_si(read_columns(path).columns, str(path))


def read_columns(
    path: Path,
    layout: TableLayout | None = None,
    described: Mapping[str, str] | None = None,
    held: Collection[str] = (),
    elements: Collection[str] = (),
    toml: str = "",
) -> Table:
    """The columns of a table, under the names and in the units of its description.

    Arguments as of `assemble`; without a layout every column of a table is needed.
    """
    check_format(path)
    if path.suffix.lower() == ".mcap" or is_bag(path):
        if layout is None:
            raise RecordingError(f"{path}: a log needs a description, which names its columns")
        if layout.period:
            raise RecordingError(f"{toml}, period: messages of a log have times; take it out")
        return Table(read_log(path, layout.columns, held))
    if path.suffix.lower() == ".parquet" or episode_of(path) is not None:
        table = open_parquet(path)
    else:
        table = open_csv(path, layout.header if layout else ())
    return assemble(table, str(path), layout, described, held=held, elements=elements, toml=toml)


def write_recording(recording: Recording, path: str | os.PathLike[str]) -> Path:
    """Write ``<stem>.csv`` and ``<stem>.toml`` in an existing folder, and return the CSV's path.

    Existing files are replaced. Reading it back gives the same recording bit for bit, named after
    the file's stem; a model that is a file is named by its path from there, so that it is found
    from any folder. Raises OSError where the folder cannot be written.
    """
    csv, toml = table_beside(Path(path), (".csv",))
    write_csv({TIME: recording.time, **recording.columns}, csv)
    text = format_description(recording, _model_from(toml, recording.model))
    with whole_file(toml) as made:
        made.write_text(text, encoding="utf-8", newline="\n")
    return csv


def read_description(toml: Path) -> Description:
    """The description of columns as the file has them; its model as `Recording.model`."""
    described, _ = parse_toml(read_text(toml), str(toml))
    return replace(described, model=_model_beside(toml, described.model))


def is_same_model(one: str, other: str) -> bool:
    """Return whether the models of two recordings are one name, or one file in one folder."""
    first, second = Path(one), Path(other)
    files = first.name == second.name and first.is_file() and second.is_file()
    return one == other or (files and first.parent.samefile(second.parent))


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


def _frozen(values: ArrayLike, where: str) -> FloatArray:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{where}: not an array of numbers: {error}") from None
    array.setflags(write=False)
    return array
