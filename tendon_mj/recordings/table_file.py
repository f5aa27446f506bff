"""The table of a recording in any of the formats that are read, and the description beside it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from tendon_mj.errors import RecordingError
from tendon_mj.recordings.csv_table import read_csv
from tendon_mj.recordings.description import Topic
from tendon_mj.recordings.mcap_table import read_mcap
from tendon_mj.recordings.parquet_table import read_parquet
from tendon_mj.recordings.table_checks import FloatArray, in_si

FORMATS = (".csv", ".parquet", ".mcap")  # in the order in which a stem is sought


def read_table(path: Path, elements: Collection[str] = ()) -> dict[str, FloatArray]:
    """Read a CSV or Parquet file into its columns in file order, ``time_s`` first; each (n,) [SI].

    ``x_mm`` of the file becomes ``x_m``. Raises `RecordingError`, naming file, row (the header is
    row 1) and column, for what docs/recording.md does not allow. ``elements`` as in `check_names`.
    """
    return in_si(read_columns(path, elements=elements), str(path))


def read_columns(
    path: Path,
    topics: Mapping[str, Topic] | None = None,
    held: Collection[str] = (),
    elements: Collection[str] = (),
) -> dict[str, FloatArray]:
    """The columns of a table, under the names and in the units of its file; each (n,).

    Args:
        path: of the table.
        topics, held: what a log's columns are, as in `read_mcap`.
        elements: of a table, as in `check_names`.
    """
    suffix = path.suffix.lower()
    if suffix == ".mcap":
        if topics is None:
            raise RecordingError(f"{path}: a log needs a description that says what is in it")
        return read_mcap(path, topics, held)
    return (read_parquet if suffix == ".parquet" else read_csv)(path, elements)


def table_beside(path: Path, formats: Sequence[str] = FORMATS) -> tuple[Path, Path]:
    """Table and TOML of a path to either or to their stem, which may itself have dots in it.

    Where several tables could be meant, the first format of which there is a file, else the first.

    Raises:
        RecordingError: it names a folder alone, as `.` and `/` do.
    """
    if path.name in ("", ".."):
        raise RecordingError(f"{path} is a folder; give the path of a recording's table")
    if path.suffix.lower() in formats:
        return path, path.with_suffix(".toml")
    stem = path.name.removesuffix(".toml")
    tables = [path.with_name(stem + suffix) for suffix in formats]
    table = next((table for table in tables if table.is_file()), tables[0])
    return table, path.with_name(stem + ".toml")
