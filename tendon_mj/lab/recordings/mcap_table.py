"""The numbers of a recording as an MCAP log of JSON messages (the extra `mcap`)."""

from __future__ import annotations

import json
import re
from array import array
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_mj.errors import MissingPackageError, RecordingError, unknown
from tendon_mj.lab.recordings.description import Source
from tendon_mj.lab.recordings.table_checks import TIME, TIMES, check_table
from tendon_mj.lab.recordings.text_file import check_file
from tendon_mj.lab.recordings.times import Series, at_common_times
from tendon_mj.typing import FloatArray

if TYPE_CHECKING:
    from tendon_mj.lab.recordings.mcap_messages import LogMessage

_PLACE = re.compile("[0-9]{1,9}")  # in a list
_LARGEST_MESSAGE = 2**24  # [bytes]: what it says takes some twenty times as much memory
_LAST_TIME = 2**63 - 1  # [ns]: the year 2262


def read_mcap(
    path: Path, topics: Mapping[str, Source], held: Collection[str] = ()
) -> dict[str, FloatArray]:
    """Read the columns that a description names, at the times of the first one's messages.

    Times are log times, from the first row on; other columns are as in `at_common_times`.

    Args:
        path: of the log.
        topics: column [its unit] → where its values are.
        held: columns that keep their value until the next message.

    Returns:
        ``time_s`` and the columns, each (n,).

    Raises:
        RecordingError: no MCAP, no such topic or field, another encoding than JSON, a value that is
            no number, too large a message, or what `check_table` refuses.
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
    read = _read_series(path, topics)
    faults = {c: topics[c].period_fault(values) for c, (_, values) in read.items()}
    if said := [f"{path}, [columns] {c!r}: {fault}" for c, fault in faults.items() if fault]:
        raise RecordingError("\n".join(said))
    series = {
        column: (times, topics[column].converted(values, column))
        for column, (times, values) in read.items()
    }
    table, _ = at_common_times(series, TIME, 1e-9, str(path), held)
    check_table(table, str(path))
    return table


def _read_series(path: Path, topics: Mapping[str, Source]) -> dict[str, Series]:
    """Column → (m,) log times [ns] and values; what cannot be read of any is said at once."""
    try:
        from tendon_mj.lab.recordings.mcap_messages import read_messages
    except ImportError:
        raise MissingPackageError(
            f"{path}: MCAP is read through mcap, which is not installed;"
            " pip install 'tendon-mj[mcap]'"
        ) from None
    columns: dict[str, list[str]] = {}
    for column, source in topics.items():
        columns.setdefault(source.topic, []).append(column)
    times = {topic: array("q") for topic in columns}
    values = {column: array("d") for column in topics}
    there, faults = set[str](), dict[str, str]()
    for message in read_messages(path):
        there.add(message.topic)
        if message.topic in columns:
            here = f"{path}, topic {message.topic!r}, message {len(times[message.topic]) + 1}"
            decoded = _decoded(message, here)
            times[message.topic].append(message.time)
            for column in columns[message.topic]:
                try:
                    number = _field(decoded, topics[column].field, f"{here}, for {column!r}")
                    values[column].append(number)
                except RecordingError as error:
                    faults.setdefault(column, str(error))
    missing = [name for name in sorted(columns) if name not in there]
    said = [f"{path}, [columns]: {unknown('topic', name, there)}" for name in missing]
    if faults or said:
        raise RecordingError("\n".join([*said, *faults.values()]))
    return {
        column: (np.array(times[source.topic]), np.array(values[column]))
        for column, source in topics.items()
    }


def _decoded(message: LogMessage, here: str) -> Any:
    """What a message says."""
    if message.encoding != "json":
        raise RecordingError(
            f"{here}: it is encoded as {message.encoding!r}; JSON is read, so convert the log first"
        )
    if len(message.data) > _LARGEST_MESSAGE:
        raise RecordingError(f"{here}: {len(message.data)} bytes, more than {_LARGEST_MESSAGE}")
    if message.time > _LAST_TIME:
        raise RecordingError(f"{here}: log time {message.time} ns is after {_LAST_TIME} ns")
    try:
        return json.loads(message.data)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{here}: not JSON: {error}") from None


def _field(message: Any, field: str, here: str) -> float:
    """A number in a message: names, and places in lists, with dots between."""
    for part in field.split("."):
        if isinstance(message, dict) and part in message:
            message = message[part]
        elif isinstance(message, list) and _PLACE.fullmatch(part) and int(part) < len(message):
            message = message[int(part)]
        else:
            there = message if isinstance(message, dict) else ()
            raise RecordingError(f"{here}: {unknown('field', part, map(str, there))} in {field!r}")
    if isinstance(message, bool) or not isinstance(message, int | float):
        raise RecordingError(f"{here}: field {field!r} is {message!r}, not a number")
    try:
        return float(message)
    except OverflowError:
        raise RecordingError(f"{here}: field {field!r} is an integer above 1e308") from None
