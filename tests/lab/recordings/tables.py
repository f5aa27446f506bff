"""Tables and logs as files, and refusals by class and facts."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendon_mj.typing import FloatArray

START = 1_700_000_000_000_000_000  # [ns] since 1970


def parquet(path: Path, **columns: object) -> Path:
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table(columns), path)
    return path


def log(
    path: Path,
    *messages: tuple[str, float, object],
    encoding: str = "json",
    compression: str = "ZSTD",
    schema: tuple[str, str, str] = ("any", "jsonschema", "{}"),
) -> Path:
    """A log of (topic, time since `START` [s] or since 1970 [ns, an int], message or its bytes).

    ``schema``: name of the messages' type, the language of its definition, and that.
    """
    module = pytest.importorskip("mcap.writer")
    with path.open("wb") as file:
        writer = module.Writer(file, compression=getattr(module.CompressionType, compression))
        writer.start(profile="ros2" if encoding == "cdr" else "")
        name, language, text = schema
        kind = writer.register_schema(name=name, encoding=language, data=text.encode())
        topics = sorted({topic for topic, _, _ in messages})
        ids = {topic: writer.register_channel(topic, encoding, kind) for topic in topics}
        for topic, at, message in messages:
            stamp = at if isinstance(at, int) else START + round(at * 1e9)
            data = message if isinstance(message, bytes) else json.dumps(message).encode()
            writer.add_message(ids[topic], log_time=stamp, publish_time=stamp, data=data)
        writer.finish()
    return path


def dataset(
    folder: Path,
    version: int,
    vectors: Mapping[str, Mapping[str, Sequence[FloatArray]]],
    rate: float,
) -> Path:
    """A dataset of LeRobot: feature → name of an element → its numbers in each episode."""
    pa = pytest.importorskip("pyarrow")
    features: dict[str, object] = {
        name: {"dtype": "float32", "shape": [len(of)], "names": list(of)}
        for name, of in vectors.items()
    }
    features["timestamp"] = {"dtype": "float32", "shape": [1], "names": None}
    first = next(iter(next(iter(vectors.values())).values()))
    episodes, vector = [], pa.list_(pa.float32())
    for k in range(len(first)):
        frames = np.arange(len(first[k]))
        columns = {
            name: pa.array(np.transpose([v[k] for v in of.values()]).tolist(), vector)
            for name, of in vectors.items()
        }
        columns["timestamp"] = pa.array((frames / rate).astype(np.float32))
        columns["episode_index"] = pa.array(np.full(frames.size, k))
        episodes.append(pa.table(columns))
    chunk = folder / "data" / "chunk-000"
    chunk.mkdir(parents=True)
    pq = pytest.importorskip("pyarrow.parquet")
    if version == 3:
        pq.write_table(pa.concat_tables(episodes), chunk / "file-000.parquet")
    else:
        for k, table in enumerate(episodes):
            pq.write_table(table, chunk / f"episode_{k:06d}.parquet")
    (folder / "meta").mkdir()
    info = {"codebase_version": f"v{version}.0", "total_episodes": len(episodes)}
    (folder / "meta" / "info.json").write_text(json.dumps(info | {"features": features}))
    return folder


def bag(folder: Path, storage: str, *messages: tuple[str, float, str, Mapping[str, Any]]) -> Path:
    """A bag of ROS 2 of (topic, time since `START` [s], type, fields)."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    types = pytest.importorskip("rosbags.typesys")
    store = types.get_typestore(types.Stores.ROS2_HUMBLE)
    time = store.types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    header = store.types["std_msgs/msg/Header"](stamp=time, frame_id="")
    kinds = {topic: kind for topic, _, kind, _ in messages}

    def made(kind: str, fields: Mapping[str, Any]) -> Any:
        """A message, of messages where a field is a mapping, with a type in it."""
        values = {
            name: made(**value) if isinstance(value, dict) else value
            for name, value in fields.items()
        }
        head = {"header": header} if "header" in store.types[kind].__dataclass_fields__ else {}
        return store.types[kind](**head, **values)

    plugin = rosbag2.StoragePlugin[storage]
    with rosbag2.Writer(folder, version=9, storage_plugin=plugin) as writer:
        sent = {t: writer.add_connection(t, k, typestore=store) for t, k in kinds.items()}
        for topic, at, kind, fields in messages:
            data = store.serialize_cdr(made(kind, fields), kind)
            writer.write(sent[topic], START + round(at * 1e9), data)
    return folder
