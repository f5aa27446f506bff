"""Tables in Parquet files, and in datasets of LeRobot, through pyarrow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings.files import (
    check_file,
    episode_files,
    episode_of,
    missing_reader,
    read_info,
)
from tendon_mj.lab.recordings.table import Columns, OpenTable
from tendon_mj.lab.units import TIME

_FIRST = 2  # row of the first values in a CSV of the same table


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
    empty, place, rows, rate = schema.empty_table(), dict[str, str](), None, 0.0
    if episode is not None:
        place, rows = _places(path.parent), datasets.field("episode_index") == episode
        if place[TIME] not in names:
            del place[TIME]
            rate = read_info(path.parent)["fps"]
        names = [*place, *(name for name in names if name not in place)]

    def read(wanted: Mapping[str, bool], clock: str) -> tuple[Columns, list[str]]:
        parts = {name: _part_of(schema, place.get(name, name)) for name in wanted}
        roots = dict.fromkeys(root for root, _ in parts.values())
        try:
            table = data.to_table(columns=list(roots), filter=rows)
            whole = {root: table.column(root) for root in roots}
        except broken as error:
            raise RecordingError(f"{path}: not a Parquet file: {error}") from None
        if episode is not None and not table.num_rows:
            total = read_info(path.parent)["total_episodes"]
            raise RecordingError(
                f"{path}: no frame of episode {episode} in its data; the dataset has episodes 0 to"
                f" {total - 1}"
            )
        if episode is None and "episode_index" in schema.names:
            several = data.to_table(columns=["episode_index"]).column(0).unique().to_pylist()
            if len(several) > 1:
                raise RecordingError(
                    f"{path}: holds episodes {several[0]} to {several[-1]} of a dataset of LeRobot;"
                    f" give one, as <folder with meta and data>/episode_{several[0]}"
                )
        cells, faults = Columns(), list[str]()
        for name, needed in wanted.items():
            root, rest = parts[name]
            try:
                cells[name] = _arrow_cells(_part(whole[root], rest), name == clock)
            except (pa.ArrowException, TypeError) as error:
                faults += [f"{path}, column {name!r}: {error}"] if needed else []
        return cells, faults

    def has(name: str) -> bool:
        root, rest = _part_of(schema, place.get(name, name))
        try:
            return bool(root) and _part(empty.column(root), rest) is not None
        except (pa.ArrowException, TypeError):
            return False

    kinds = ((name, schema.field(name).type) for name in names if name in schema.names)
    sample = {name: "1970-01-01" for name, kind in kinds if pa.types.is_timestamp(kind)}
    period = 1.0 / rate if rate else 0.0
    return OpenTable(names, has, _FIRST, read, sample, period=period)


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


def _part_of(schema: Any, name: str) -> tuple[str, list[str]]:
    """The column that a name with dots is a part of, and the parts that lead into it."""
    parts = name.split(".")
    roots = {".".join(parts[:k]): parts[k:] for k in range(len(parts), 0, -1)}
    return next(((root, rest) for root, rest in roots.items() if root in schema.names), ("", []))


def _part(column: Any, rest: Sequence[str]) -> Any:
    """The elements of lists, and fields of structs, to which the parts of a name lead."""
    import pyarrow.compute as pc

    for part in filter(None, rest):
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
