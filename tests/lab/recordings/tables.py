"""Tables and logs as files, and refusals by class and facts."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

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
) -> Path:
    """A log of (topic, time since `START` [s] or since 1970 [ns, an int], message or its bytes)."""
    module = pytest.importorskip("mcap.writer")
    with path.open("wb") as file:
        writer = module.Writer(file, compression=getattr(module.CompressionType, compression))
        writer.start()
        schema = writer.register_schema(name="any", encoding="jsonschema", data=b"{}")
        topics = sorted({topic for topic, _, _ in messages})
        ids = {topic: writer.register_channel(topic, encoding, schema) for topic in topics}
        for topic, at, message in messages:
            stamp = at if isinstance(at, int) else START + round(at * 1e9)
            data = message if isinstance(message, bytes) else json.dumps(message).encode()
            writer.add_message(ids[topic], log_time=stamp, publish_time=stamp, data=data)
        writer.finish()
    return path
