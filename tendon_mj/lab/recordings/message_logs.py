"""Logs of messages: MCAP with JSON (mcap), bags of ROS (rosbags)."""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings.clock import Samples, at_common_times
from tendon_mj.lab.recordings.column_names import in_its_unit
from tendon_mj.lab.recordings.description import Source
from tendon_mj.lab.recordings.files import check_file, is_bag, missing_reader
from tendon_mj.lab.recordings.table import check_table
from tendon_mj.lab.units import TIME, TIMES, UNIT_FACTORS, claimed_unit
from tendon_mj.typing import FloatArray

# types of ROS whose definitions say that they are in SI
_IN_SI = ("geometry_msgs/", "sensor_msgs/msg/JointState", "sensor_msgs/msg/Imu")
# what their fields are in
_SI = {
    "position": ("_rad", "_m"),
    "velocity": ("_rad_per_s", "_m_per_s"),
    "effort": ("_Nm", "_N"),
    "force": ("_N",),
    "torque": ("_Nm",),
    "angular_velocity": ("_rad_per_s",),
    "angular": ("_rad_per_s",),
    "linear": ("_m_per_s",),
}
# topic, time at which it was logged [ns], type, and what decodes it
_Message = tuple[str, int, str, Callable[[], Any]]


def read_log(
    path: Path, topics: Mapping[str, Source], held: Collection[str] = ()
) -> dict[str, FloatArray]:
    """Read the columns that a description names, at the times of the first one's messages.

    ``time_s`` is their log time, from the first row on; other columns are as in `at_common_times`.
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
    series, topics = _read_series(path, topics)
    faults = {c: topics[c].period_fault(values) for c, (_, values) in series.items()}
    if any(faults.values()):
        lines = (f"{path}, [columns] {c!r}: {fault}" for c, fault in faults.items() if fault)
        raise RecordingError("\n".join(lines))
    converted = {c: (t, topics[c].converted(values, c)) for c, (t, values) in series.items()}
    table, _ = at_common_times(converted, TIME, 1e-9, str(path), held)
    check_table(table, str(path))
    return table


def _read_series(
    path: Path, topics: Mapping[str, Source]
) -> tuple[dict[str, Samples], dict[str, Source]]:
    """Column → (m,) log times [ns] and values, and its source; the first fault of each in one."""
    columns: dict[str, list[str]] = {}
    for column, source in topics.items():
        columns.setdefault(source.topic, []).append(column)
    times = {topic: array("q") for topic in columns}
    values = {column: array("d") for column in topics}
    sources = dict(topics)
    there, faults = set[str](), dict[str, str]()
    for topic, stamp, kind, decoded in _messages(path, columns, there):
        if topic not in columns:
            continue
        here = f"{path}, topic {topic!r}, message {len(times[topic]) + 1}"
        try:
            message = decoded()
        except Exception as error:  # whatever decoders raise on bytes that are not theirs
            raise RecordingError(f"{here}: not {kind}: {error}") from None
        times[topic].append(stamp)
        for column in columns[topic]:
            try:
                field = topics[column].field
                values[column].append(_field(message, field, f"{here}, for {column!r}"))
            except RecordingError as error:
                faults.setdefault(column, str(error))
            if kind.startswith(_IN_SI) and len(times[topic]) == 1:
                si, fault = UNIT_FACTORS[claimed_unit(column)][0], ""
                are = next((_SI[part] for part in field.split(".") if part in _SI), (si,))
                if topics[column].factor == 1.0 and not topics[column].unit and si not in are:
                    fault = f"field {field!r} of {kind} is in {' or '.join(u[1:] for u in are)}"
                else:
                    sources[column], fault = in_its_unit(column, topics[column], si)
                faults |= {column: f"{here}, for {column!r}: {fault}"} if fault else {}
    missing = [name for name in sorted(columns) if name not in there]
    lines = [f"{path}, [columns]: {unknown('topic', name, there)}" for name in missing]
    if faults or lines:
        raise RecordingError("\n".join([*lines, *faults.values()]))
    series = {
        column: (np.array(times[source.topic]), np.array(values[column]))
        for column, source in topics.items()
    }
    return series, sources


def _messages(path: Path, wanted: Collection[str], there: set[str]) -> Iterator[_Message]:
    """Messages of a log, at least those of the topics that are wanted; all topics are added."""
    kind, read = ("a bag of ROS", _of_bag) if is_bag(path) else ("an MCAP", _of_mcap)
    try:
        yield from read(path, wanted, there)
    except (RecordingError, ImportError):
        raise
    # whatever its parts raise: struct.error, KeyError, ZstdError, OverflowError, …
    except Exception as error:
        reason = str(error) or type(error).__name__
        raise RecordingError(f"{path}: not {kind}: {reason}") from error


def _of_mcap(path: Path, wanted: Collection[str], there: set[str]) -> Iterator[_Message]:
    try:
        from mcap.reader import NonSeekingReader
    except ImportError:
        raise missing_reader(path, "MCAP", "mcap", "mcap") from None
    with path.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        for _, channel, message in reader.iter_messages(log_time_order=False):
            if channel.message_encoding == "cdr":
                yield from _of_bag(path, wanted, there)
                return
            there.add(channel.topic)
            if channel.message_encoding != "json":
                raise RecordingError(
                    f"{path}, topic {channel.topic!r}: it is encoded as"
                    f" {channel.message_encoding!r}; JSON and ROS 2's CDR are read, so convert the"
                    " log first"
                )
            decoded = partial(json.loads, message.data)
            yield channel.topic, message.log_time, "JSON", decoded


def _of_bag(path: Path, wanted: Collection[str], there: set[str]) -> Iterator[_Message]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_reader(path, "a bag of ROS", "rosbags", "rosbags") from None
    # types of messages in a bag without definitions of them, as ROS 2 wrote before 2023
    store = get_typestore(Stores.ROS1_NOETIC if path.suffix == ".bag" else Stores.LATEST)
    with AnyReader([path], default_typestore=store) as reader:
        sent = [connection for connection in reader.connections if connection.msgcount]
        there |= {connection.topic for connection in sent}
        named = [connection for connection in sent if connection.topic in wanted]
        for connection, stamp, data in reader.messages(named) if named else ():
            decoded = partial(reader.deserialize, data, connection.msgtype)
            yield connection.topic, stamp, connection.msgtype, decoded


def _field(message: Any, field: str, here: str) -> float:
    """A number in a message: names, and places in lists, with dots between.

    A name in a list is a place in the list ``name`` next to it, as of joints.
    """
    names: Any = ()
    for part in field.split("."):
        fields = message if isinstance(message, dict) else getattr(message, "__dict__", {})
        listed = isinstance(message, list | np.ndarray)
        if part in fields:
            names, message = fields.get("name", ()), fields[part]
        elif listed and part in names and len(names) == len(message):
            message = message[list(names).index(part)]
        elif listed and part.isdecimal() and int(part) < len(message):
            message = message[int(part)]
        else:
            there = names if listed else fields
            raise RecordingError(f"{here}: {unknown('field', part, map(str, there))} in {field!r}")
    if isinstance(message, bool | np.bool_) or not isinstance(message, int | float | np.number):
        raise RecordingError(f"{here}: field {field!r} is {message!r}, not a number")
    return float(message)
