"""Parquet tables, read through pyarrow, and MCAP logs of JSON messages, read through mcap."""

from __future__ import annotations

import json
from array import array
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_mj.errors import MissingPackageError, RecordingError, unknown
from tendon_mj.lab.recordings.assembly import Columns, OpenTable
from tendon_mj.lab.recordings.description import Source
from tendon_mj.lab.recordings.files import LARGEST_FILE, check_file
from tendon_mj.lab.recordings.times import Samples, at_common_times, check_table
from tendon_mj.lab.recordings.units import TIME, TIMES
from tendon_mj.typing import FloatArray

if TYPE_CHECKING:
    from mcap.records import Channel, Message

_FIRST = 2  # row of the first values in a CSV of the same table


def open_parquet(path: Path) -> OpenTable:
    """The names of a Parquet file's columns, and how to read them.

    Dots lead into lists and structs: ``position.0``. Rows in messages are those that a CSV of the
    same table would have.

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
    broken = (pa.ArrowException, OSError, ValueError)  # ValueError: a name that is not UTF-8
    try:
        file = pq.ParquetFile(path)
        schema = file.schema_arrow
        names = list(schema.names)
    except broken as error:
        raise RecordingError(f"{path}: not a Parquet file: {error}") from None
    if not names:
        raise RecordingError(f"{path}: holds no column")
    empty = schema.empty_table()

    def read(wanted: Mapping[str, bool], clock: str) -> tuple[Columns, list[str]]:
        roots = {name: _root(schema, name) for name in wanted}
        try:
            table = file.read(columns=list(dict.fromkeys(roots.values())))
            whole = {root: table.column(root) for root in roots.values()}
        except broken as error:
            raise RecordingError(f"{path}: not a Parquet file: {error}") from None
        cells, faults = Columns(), list[str]()
        for name, needed in wanted.items():
            rest = name[len(roots[name]) + 1 :]
            try:
                cells[name] = _cells(_part(whole[roots[name]], rest), name == clock)
            except (pa.ArrowException, TypeError) as error:
                faults += [f"{path}, column {name!r}: {error}"] if needed else []
        return cells, faults

    def has(name: str) -> bool:
        root = _root(schema, name)
        try:
            return bool(root) and _part(empty.column(root), name[len(root) + 1 :]) is not None
        except (pa.ArrowException, TypeError):
            return False

    kinds = ((name, schema.field(k).type) for k, name in enumerate(names))
    sample = {name: "1970-01-01" for name, kind in kinds if pa.types.is_timestamp(kind)}
    return OpenTable(names, has, _FIRST, read, sample)


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


def _cells(column: Any, is_clock: bool) -> Any:
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


def read_mcap(
    path: Path, topics: Mapping[str, Source], held: Collection[str] = ()
) -> dict[str, FloatArray]:
    """Read the columns that a description names, at the times of the first one's messages.

    ``time_s`` is their log time, from the first row on; other columns are as in `at_common_times`.

    Raises:
        RecordingError: not an MCAP, no such topic or field, another encoding than JSON, a value
            that is not a number, or as of `check_table`.
        MissingPackageError: mcap is not installed.
    """
    check_file(path)
    topics = {column: source for column, source in topics.items() if column not in TIMES}
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
    series = _read_series(path, topics)
    faults = {c: topics[c].period_fault(values) for c, (_, values) in series.items()}
    if any(faults.values()):
        lines = (f"{path}, [columns] {c!r}: {fault}" for c, fault in faults.items() if fault)
        raise RecordingError("\n".join(lines))
    converted = {c: (t, topics[c].converted(values, c)) for c, (t, values) in series.items()}
    table, _ = at_common_times(converted, TIME, 1e-9, str(path), held)
    check_table(table, str(path))
    return table


def _read_series(path: Path, topics: Mapping[str, Source]) -> dict[str, Samples]:
    """Column → (m,) log times [ns] and values; the first fault of each column in one message."""
    columns: dict[str, list[str]] = {}
    for column, source in topics.items():
        columns.setdefault(source.topic, []).append(column)
    times = {topic: array("q") for topic in columns}
    values = {column: array("d") for column in topics}
    there, faults = set[str](), dict[str, str]()
    for channel, message in _messages(path):
        topic = channel.topic
        there.add(topic)
        if topic not in columns:
            continue
        here = f"{path}, topic {topic!r}, message {len(times[topic]) + 1}"
        decoded = _decoded(channel.message_encoding, message.data, here)
        times[topic].append(message.log_time)
        for column in columns[topic]:
            try:
                field = topics[column].field
                values[column].append(_field(decoded, field, f"{here}, for {column!r}"))
            except RecordingError as error:
                faults.setdefault(column, str(error))
    missing = [name for name in sorted(columns) if name not in there]
    lines = [f"{path}, [columns]: {unknown('topic', name, there)}" for name in missing]
    if faults or lines:
        raise RecordingError("\n".join([*lines, *faults.values()]))
    return {
        column: (np.array(times[source.topic]), np.array(values[column]))
        for column, source in topics.items()
    }


def _messages(path: Path) -> Iterator[tuple[Channel, Message]]:
    """Messages of a log in the order of the file."""
    try:
        from mcap.reader import NonSeekingReader
    except ImportError:
        raise _missing(path, "MCAP", "mcap", "mcap") from None
    with path.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True, record_size_limit=LARGEST_FILE)
        messages = reader.iter_messages(log_time_order=False)
        while True:
            try:
                _, channel, message = next(messages)
            except StopIteration:
                return
            # whatever its parts raise: struct.error, KeyError, ZstdError, OverflowError, …
            except Exception as error:
                reason = str(error) or type(error).__name__
                raise RecordingError(f"{path}: not an MCAP: {reason}") from error
            yield channel, message


def _decoded(encoding: str, data: bytes, here: str) -> Any:
    if encoding != "json":
        raise RecordingError(
            f"{here}: it is encoded as {encoding!r}; JSON is read, so convert the log first"
        )
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{here}: not JSON: {error}") from None


def _field(message: Any, field: str, here: str) -> float:
    """A number in a message: names, and places in lists, with dots between."""
    for part in field.split("."):
        if isinstance(message, dict) and part in message:
            message = message[part]
        elif isinstance(message, list) and part.isdecimal() and int(part) < len(message):
            message = message[int(part)]
        else:
            there = message if isinstance(message, dict) else ()
            raise RecordingError(f"{here}: {unknown('field', part, map(str, there))} in {field!r}")
    if isinstance(message, bool) or not isinstance(message, int | float):
        raise RecordingError(f"{here}: field {field!r} is {message!r}, not a number")
    return float(message)


def _missing(path: Path, kind: str, package: str, extra: str) -> MissingPackageError:
    return MissingPackageError(
        f"{path}: {kind} is read through {package}, which is not installed;"
        f" pip install 'tendon-mj[{extra}]'"
    )
