"""A recording's file that was cut off, or holds something else, is refused by name."""

from __future__ import annotations

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


def refusal(path: Path, share: float) -> str:
    """Message of the refusal of the first part of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(RecordingError) as caught:
        read_recording(path) if path.suffix == ".mcap" else read_table(path)
    return str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_a_file_that_was_cut_off_is_refused_by_name(tmp_path: Path, share: float) -> None:
    for compression in ("NONE", "LZ4", "ZSTD"):
        path = rig_log(tmp_path, *(b'{"x": [%d]}' % k for k in range(40)), compression=compression)
        assert read_recording(path).time.size == 40
        assert "r.mcap" in refusal(path, share)
    path = parquet(tmp_path / "r.parquet", time_s=np.arange(50.0), a_N=np.arange(50.0))
    assert "r.parquet" in refusal(path, share)


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
