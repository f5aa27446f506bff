"""The numbers of a recording as an MCAP log of JSON messages (the extra `mcap`)."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tendon_mj.errors import MissingPackageError, RecordingError, unknown
from tendon_mj.recordings.description import Topic
from tendon_mj.recordings.table_checks import TIME, FloatArray, check_table
from tendon_mj.recordings.text_file import check_file

_Log = dict[str, tuple[list[int], list[Any]]]  # topic -> log times [ns], decoded messages


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
            no number, or what `check_table` refuses.
        MissingPackageError: mcap is not installed.
    """
    check_file(path)
    if not topics:
        raise RecordingError(
            f"{path}: the description has no [mcap], which says where the columns are, such as"
            ' tension_N = { topic = "/load_cell", field = "force" }'
        )
    log = _read_log(path, {topic.topic for topic in topics.values()})
    series = {column: _series(path, column, topic, log) for column, topic in topics.items()}
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


def _read_log(path: Path, wanted: Collection[str]) -> _Log:
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
    except ImportError:
        raise MissingPackageError(
            f"{path}: MCAP is read through mcap, which is not installed;"
            " pip install 'tendon-mj[mcap]'"
        ) from None
    log: _Log = {topic: ([], []) for topic in wanted}
    there: set[str] = set()
    try:
        with path.open("rb") as file:
            for _, channel, message in make_reader(file).iter_messages():
                there.add(channel.topic)
                if channel.topic not in log:
                    continue
                if channel.message_encoding != "json":
                    raise RecordingError(
                        f"{path}, topic {channel.topic!r}: its messages are encoded as"
                        f" {channel.message_encoding!r}; JSON is read, so convert them first"
                    )
                times, messages = log[channel.topic]
                times.append(message.log_time)
                messages.append(json.loads(message.data))
    except (McapError, ValueError, RecursionError, EOFError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{path}: not an MCAP of JSON messages: {error}") from None
    for topic in sorted(wanted):
        if topic not in there:
            raise RecordingError(f"{path}, [mcap]: {unknown('topic', topic, there)}")
    return log


def _series(
    path: Path, column: str, topic: Topic, log: _Log
) -> tuple[np.ndarray[Any, np.dtype[np.int64]], FloatArray]:
    """(m,) log times [ns] and values of a column; of two at one time the later one."""
    times, messages = log[topic.topic]
    values = [
        _field(message, topic.field, f"{path}, topic {topic.topic!r}, message {k}, for {column!r}")
        for k, message in enumerate(messages, start=1)
    ]
    latest = dict(zip(times, values, strict=True))
    return np.array(list(latest), dtype=np.int64), np.array(list(latest.values()))


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
