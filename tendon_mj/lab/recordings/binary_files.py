"""Parquet tables, read through pyarrow, and MCAP logs of JSON messages, read through mcap."""

from __future__ import annotations

import json
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_mj.errors import MissingPackageError, RecordingError, unknown
from tendon_mj.lab.recordings.assembly import RawTable, element
from tendon_mj.lab.recordings.description import Source, TableLayout
from tendon_mj.lab.recordings.files import check_file
from tendon_mj.lab.recordings.times import Samples, at_common_times, check_table
from tendon_mj.lab.recordings.units import TIME, TIMES
from tendon_mj.typing import FloatArray

if TYPE_CHECKING:
    from mcap.records import Channel, Message


def read_parquet(path: Path) -> RawTable:
    """Read a Parquet file; rows in messages are those that a CSV of the same table would have.

    Raises:
        RecordingError: not a Parquet file, or one without a column.
        MissingPackageError: pyarrow is not installed.
    """
    check_file(path)
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise _missing(path, "Parquet", "pyarrow", "parquet") from None
    try:
        # integers next to empty cells stay exact
        table = pq.read_table(path).to_pandas(ignore_metadata=True, integer_object_nulls=True)
    except (pa.ArrowException, OSError, ValueError) as error:  # ValueError: a name is not UTF-8
        raise RecordingError(f"{path}: not a Parquet file: {error}") from None
    names = list(table.columns)
    if not names:
        raise RecordingError(f"{path}: holds no column")
    return RawTable(names, [table.iloc[:, k] for k in range(len(names))], first=2)


def read_mcap(path: Path, layout: TableLayout) -> dict[str, FloatArray]:
    """Read the columns that a description names, at the times of the first one's messages.

    ``time_s`` is their log time, from the first row on; other columns are as in `at_common_times`.

    Raises:
        RecordingError: not an MCAP, no such topic or field, another encoding than JSON, a value
            that is not a number, or as of `check_table`.
        MissingPackageError: mcap is not installed.
    """
    check_file(path)
    topics = {column: source for column, source in layout.columns.items() if column not in TIMES}
    if not topics:
        raise RecordingError(
            f"{path}: the description has no [columns], which says where the columns are, such as"
            ' tension_N = { topic = "/load_cell", field = "force" }'
        )
    for column, source in topics.items():
        if not source.topic:
            raise RecordingError(
                f"{path}: [columns] {column!r} names a column of a table; of a log write"
                " { topic = …, field = … }"
            )
    series = dict[str, Samples]()
    for column, (times, values) in _read_series(path, topics).items():
        if fault := topics[column].period_fault(values):
            raise RecordingError(f"{path}, [columns] {column!r}: {fault}")
        series[column] = times, topics[column].converted(values, column)
    table, _ = at_common_times(series, TIME, 1e-9, str(path), layout.held)
    check_table(table, str(path))
    return table


def _read_series(path: Path, topics: Mapping[str, Source]) -> dict[str, Samples]:
    """Column → (m,) log times [ns] and values."""
    times = {column: array("q") for column in topics}
    values = {column: array("d") for column in topics}
    there = set[str]()
    for channel, message in _messages(path):
        there.add(channel.topic)
        columns = [c for c, source in topics.items() if source.topic == channel.topic]
        if not columns:
            continue
        here = f"{path}, topic {channel.topic!r}, message {len(times[columns[0]]) + 1}"
        decoded = _decoded(channel.message_encoding, message.data, here)
        for column in columns:
            field = topics[column].field
            value = element(decoded, field, f"{here}, for {column!r}")
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise RecordingError(f"{here}: field {field!r} is {value!r}, not a number")
            times[column].append(message.log_time)
            values[column].append(value)
    for column, source in topics.items():
        if source.topic not in there:
            fault = unknown("topic", source.topic, there)
            raise RecordingError(f"{path}, [columns] {column!r}: {fault}")
    return {column: (np.array(times[column]), np.array(values[column])) for column in topics}


def _messages(path: Path) -> Iterator[tuple[Channel, Message]]:
    """Messages of a log in the order of the file."""
    try:
        from mcap.reader import NonSeekingReader
    except ImportError:
        raise _missing(path, "MCAP", "mcap", "mcap") from None
    with path.open("rb") as file:
        try:
            reader = NonSeekingReader(file, validate_crcs=True)
            for _, channel, message in reader.iter_messages(log_time_order=False):
                yield channel, message
        # whatever its parts raise: struct.error, KeyError, ZstdError, OverflowError, …
        except Exception as error:
            reason = str(error) or type(error).__name__
            raise RecordingError(f"{path}: not an MCAP: {reason}") from error


def _decoded(encoding: str, data: bytes, here: str) -> Any:
    if encoding != "json":
        raise RecordingError(
            f"{here}: it is encoded as {encoding!r}; JSON is read, so convert the log first"
        )
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{here}: not JSON: {error}") from None


def _missing(path: Path, kind: str, package: str, extra: str) -> MissingPackageError:
    return MissingPackageError(
        f"{path}: {kind} is read through {package}, which is not installed;"
        f" pip install 'tendon-mj[{extra}]'"
    )
