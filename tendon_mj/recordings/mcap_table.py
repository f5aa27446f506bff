"""The numbers of a recording as an MCAP log of JSON messages (the extra `mcap`)."""

from __future__ import annotations

import json
import re
from array import array
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import MissingPackageError, RecordingError, unknown
from tendon_mj.recordings.description import Topic
from tendon_mj.recordings.table_checks import TIME, FloatArray, check_table
from tendon_mj.recordings.text_file import check_file

if TYPE_CHECKING:
    from tendon_mj.recordings.mcap_messages import LogMessage

_Series = tuple[NDArray[np.int64], FloatArray]  # log times [ns], values
_PLACE = re.compile("[0-9]{1,9}")  # in a list
_LARGEST_MESSAGE = 2**24  # [bytes]: what it says takes some twenty times as much memory
_LAST_TIME = 2**63 - 1  # [ns]: the year 2262


def read_mcap(
    path: Path, topics: Mapping[str, Topic], held: Collection[str] = ()
) -> dict[str, FloatArray]:
    """Read the columns that a description's [mcap] names, at the times of the first one's messages.

    Times are log times, from the first row on. A column of another topic is linear between its
    messages, or keeps the latest where it is among ``held``; rows before the first or after the
    last message of any of the topics are left out.

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
    if not topics:
        raise RecordingError(
            f"{path}: the description has no [mcap], which says where the columns are, such as"
            ' tension_N = { topic = "/load_cell", field = "force" }'
        )
    series = _read_series(path, topics)
    stamps = next(iter(series.values()))[0]
    first = max(times[0] for times, _ in series.values())
    last = min(times[-1] for times, _ in series.values())
    rows = stamps[(stamps >= first) & (stamps <= last)]
    if rows.size < 2:
        raise RecordingError(f"{path}: the topics of [mcap] have no two messages at common times")
    table = {TIME: (rows - rows[0]) * 1e-9}
    for column, (times, values) in series.items():
        if column in held:
            table[column] = values[np.searchsorted(times, rows, side="right") - 1]
        else:
            table[column] = np.interp(rows - rows[0], times - rows[0], values)
    check_table(table, str(path))
    return table


def _read_series(path: Path, topics: Mapping[str, Topic]) -> dict[str, _Series]:
    """Column → (m,) rising log times [ns] and values; of two at one time the later one."""
    try:
        from tendon_mj.recordings.mcap_messages import read_messages
    except ImportError:
        raise MissingPackageError(
            f"{path}: MCAP is read through mcap, which is not installed;"
            " pip install 'tendon-mj[mcap]'"
        ) from None
    columns: dict[str, list[str]] = {}
    for column, topic in topics.items():
        columns.setdefault(topic.topic, []).append(column)
    times = {topic: array("q") for topic in columns}
    values = {column: array("d") for column in topics}
    there: set[str] = set()
    for message in read_messages(path):
        there.add(message.topic)
        if message.topic in columns:
            here = f"{path}, topic {message.topic!r}, message {len(times[message.topic]) + 1}"
            decoded = _decoded(message, here)
            times[message.topic].append(message.time)
            for column in columns[message.topic]:
                number = _field(decoded, topics[column].field, f"{here}, for {column!r}")
                values[column].append(number)
    for name in sorted(columns):
        if name not in there:
            raise RecordingError(f"{path}, [mcap]: {unknown('topic', name, there)}")
    return {
        column: _in_order(np.array(times[topic.topic]), np.array(values[column]))
        for column, topic in topics.items()
    }


def _in_order(times: NDArray[np.int64], values: FloatArray) -> _Series:
    order = np.argsort(times, kind="stable")
    times, values = times[order], values[order]
    last = np.append(times[1:] != times[:-1], True)
    return times[last], values[last]


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
