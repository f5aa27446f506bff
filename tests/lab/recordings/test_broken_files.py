"""Whatever bytes a recording's file has, it is refused by name, soon and in little memory."""

from __future__ import annotations

import os
import random
import sys
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import mcap_table, read_recording, read_table, text_file

STAMP = 1_700_000_000_000_000_000  # [ns]
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


def log(folder: Path, *messages: bytes, first: int = STAMP, field: str = "x.0", **options) -> Path:
    """A log of JSON messages of one topic, 1 ms apart."""
    writer_of = pytest.importorskip("mcap.writer")
    path = folder / "r.mcap"
    with path.open("wb") as file:
        writer = writer_of.Writer(file, **options)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channel = writer.register_channel("/a", "json", schema)
        for k, data in enumerate(messages):
            writer.add_message(channel, first + k * 10**6, data, first)
        writer.finish()
    path.with_suffix(".toml").write_text(TOML.format(field=field))
    return path


def numbers(count: int) -> list[bytes]:
    return [b'{"x": [%d]}' % k for k in range(count)]


def refusal(path: Path) -> str:
    """Message of the refusal of a recording, empty where it is read."""
    try:
        read_recording(path) if path.suffix == ".mcap" else read_table(path)
    except RecordingError as error:
        return str(error)
    return ""


def damaged(data: bytes, draw: random.Random) -> bytes:
    """Bytes of which a few are others, extreme or gone."""
    changed = bytearray(data)
    for _ in range(draw.choice([1, 1, 2, 5])):
        at, kind = draw.randrange(len(changed)), draw.random()
        if kind < 0.5:
            changed[at] = draw.randrange(256)
        elif kind < 0.7:
            changed[at : at + 8] = draw.choice(
                [b"\xff" * 8, bytes(8), (2**62).to_bytes(8, "little")]
            )
        elif kind < 0.85:
            del changed[at : at + draw.randrange(1, 40)]
        else:
            changed = changed[:at] or bytearray(b"x")
    return bytes(changed)


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_a_damaged_log_is_refused_by_name_or_read(tmp_path: Path, compression: str) -> None:
    writer_of = pytest.importorskip("mcap.writer")
    kind = getattr(writer_of.CompressionType, compression)
    path = log(tmp_path, *numbers(40), compression=kind)
    assert read_recording(path).time.size == 40
    data, draw = path.read_bytes(), random.Random(1)
    said = []
    for _ in range(400):
        path.write_bytes(damaged(data, draw))
        said.append(refusal(path))
    assert all("r.mcap" in text for text in said if text)
    assert sum(map(bool, said)) > 100


def test_a_damaged_parquet_is_refused_by_name_or_read(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "r.parquet"
    columns = {"time_s": np.arange(50.0), "a_N": np.arange(50.0)}
    pq.write_table(pa.table(columns), path)
    data, draw = path.read_bytes(), random.Random(1)
    for _ in range(400):
        path.write_bytes(damaged(data, draw))
        said = refusal(path)
        assert not said or "r.parquet" in said
    path.write_bytes(data.replace(b"a_N", b"\xff_N"))
    with pytest.raises(RecordingError, match=r"r\.parquet: not a Parquet file: .*utf-8"):
        read_table(path)


@pytest.mark.parametrize(
    ("message", "options", "said"),
    [
        (b'{"x": [1' + b"0" * 400 + b"]}", {}, "is an integer above 1e308"),
        (b'{"x": [1' + b"0" * 5000 + b"]}", {}, "message 1: not JSON"),
        (b'{"x": [1]}', {"first": 2**63}, "log time 9223372036854775808 ns is after"),
        (b'{"x": [1]}', {"field": "x." + "0" * 5000}, "unknown field"),
        (b'{"x": [1]}', {"field": "x.\u0660"}, "unknown field"),  # a zero of another script
    ],
)
def test_numbers_beyond_what_a_number_holds_are_refused(
    tmp_path: Path, message: bytes, options: dict, said: str
) -> None:
    with pytest.raises(RecordingError, match=said) as caught:
        read_recording(log(tmp_path, message, message, **options))
    assert "r.mcap" in str(caught.value)


def test_a_log_that_unpacks_to_too_much_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages = pytest.importorskip("tendon_mj.lab.recordings.mcap_messages")
    path = log(tmp_path, *(b'{"x": [0' + b" " * 5000 + b"]}" for _ in range(20)), chunk_size=20_000)
    assert path.stat().st_size < 20_000
    assert read_recording(path).time.size == 20
    for module, name, most, said in (
        (mcap_table, "_LARGEST_MESSAGE", 5000, "5010 bytes, more than 5000"),
        (messages, "LARGEST", 50_000, "chunks unpack to more than 50000"),
        (messages, "_LARGEST_CHUNK", 10_000, "a chunk unpacks to"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, most)
            assert said in refusal(path)


@pytest.mark.parametrize("compression", ["LZ4", "ZSTD"])
def test_a_chunk_that_unpacks_to_more_than_it_says_is_refused(
    tmp_path: Path, compression: str
) -> None:
    writer_of = pytest.importorskip("mcap.writer")
    kind = getattr(writer_of.CompressionType, compression)
    path = log(tmp_path, *numbers(40), compression=kind)
    data = bytearray(path.read_bytes())
    at = data.index(compression.lower().encode()) - 16  # of 8 bytes of size, and two numbers of 4
    data[at : at + 8] = (100).to_bytes(8, "little")
    path.write_bytes(data)
    with pytest.raises(RecordingError, match="a chunk unpacks to another size than 100 bytes"):
        read_recording(path)


def test_a_small_parquet_of_many_rows_is_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    module = pytest.importorskip("tendon_mj.lab.recordings.parquet_table")
    path, zeros = tmp_path / "r.parquet", np.zeros(100_000)
    pq.write_table(pa.table({"time_s": zeros, "a_N": zeros}), path)
    monkeypatch.setattr(module, "LARGEST", 10**6)
    monkeypatch.setattr(pq.ParquetFile, "read", None)
    assert path.stat().st_size < 10**6
    with pytest.raises(RecordingError, match=r"100000 rows of 2 columns are more than 1000000"):
        read_table(path)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither")
def test_pipes_and_devices_are_refused_and_not_opened(tmp_path: Path) -> None:
    pipe, zeros = tmp_path / "pipe.csv", tmp_path / "zeros.csv"
    os.mkfifo(pipe)
    zeros.symlink_to("/dev/zero")
    for path in (pipe, zeros):
        with pytest.raises(RecordingError, match=rf"{path.name}: a device or pipe"):
            text_file.check_file(path)


def test_a_header_without_an_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_bytes(bytes(2**20 + 10))
    with pytest.raises(RecordingError, match=r"r\.csv, row 1: 1048576 characters or more"):
        read_table(path)
