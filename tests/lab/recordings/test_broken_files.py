"""A recording's file with broken bytes is refused by name, or read."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import read_recording, read_table
from tests.lab.recordings.tables import log, parquet
from tests.refusals import refusing

TOML = """model = "bench"
source = "made up"
[drive]
input_displacement_m = "reel"
[measured]
input_tension_N = {{ sensor = "input_tension" }}
[mcap]
input_displacement_m = {{ topic = "/a", field = "{field}" }}
input_tension_N = {{ topic = "/a", field = "{field}" }}
"""


def rig_log(folder: Path, *messages: bytes, field: str = "x.0", compression: str = "ZSTD") -> Path:
    """A log of JSON messages of one topic, 1 ms apart."""
    stamped = [("/a", k * 10**6, data) for k, data in enumerate(messages)]
    path = log(folder / "r.mcap", *stamped, compression=compression)
    path.with_suffix(".toml").write_text(TOML.format(field=field))
    return path


def damaged(data: bytes, draw: random.Random) -> bytes:
    """Bytes of which a few are others, or gone."""
    changed = bytearray(data)
    at = draw.randrange(len(changed))
    if draw.random() < 0.5:
        changed[at] = draw.randrange(256)
    elif draw.random() < 0.5:
        del changed[at : at + draw.randrange(1, 40)]
    else:
        changed = changed[:at] or bytearray(b"x")
    return bytes(changed)


def refusals(path: Path, count: int = 200) -> list[str]:
    """Messages of the refusals of a file that is damaged in many ways."""
    data, draw, messages = path.read_bytes(), random.Random(1), []
    for _ in range(count):
        path.write_bytes(damaged(data, draw))
        try:
            read_recording(path) if path.suffix == ".mcap" else read_table(path)
        except RecordingError as error:
            messages.append(str(error))
    return messages


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_a_damaged_log_is_refused_by_name_or_read(tmp_path: Path, compression: str) -> None:
    numbers = (b'{"x": [%d]}' % k for k in range(40))
    path = rig_log(tmp_path, *numbers, compression=compression)
    assert read_recording(path).time.size == 40
    messages = refusals(path)
    assert all("r.mcap" in message for message in messages)
    assert len(messages) > 50


def test_a_damaged_parquet_is_refused_by_name_or_read(tmp_path: Path) -> None:
    path = parquet(tmp_path / "r.parquet", time_s=np.arange(50.0), a_N=np.arange(50.0))
    assert all("r.parquet" in message for message in refusals(path))


@pytest.mark.parametrize(
    ("message", "field", "reason"),
    [
        (b'{"x": [1', "x.0", "not JSON"),
        (b'{"x": [1]}', "x.1", "unknown field"),
        (b'{"x": [true]}', "x.0", "not a number"),
    ],
)
def test_a_message_without_the_number_is_refused(
    tmp_path: Path, message: bytes, field: str, reason: str
) -> None:
    with refusing(RecordingError, "r.mcap, topic '/a', message 1", reason):
        read_recording(rig_log(tmp_path, message, message, field=field))
