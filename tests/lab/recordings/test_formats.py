"""Laws of what a recording may be read from: any unit, CSV or Parquet or a log, say the same."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from tendon_mj.errors import MissingPackageError, RecordingError, UnknownNameError
from tendon_mj.lab.recordings import read_recording, read_table, write_recording
from tendon_mj.lab.replay import Simulator, replay_recording
from tendon_mj.lab.units import UNIT_FACTORS, UNITS, si_name
from tests.lab.recordings.tables import log, parquet
from tests.refusals import refusing

TIME = np.linspace(0.0, 0.4, 5)
REEL = 1e-3 * np.array([0.0, 0.4, 0.8, 0.3, -0.2])
TENSION = np.array([20.0, 21.0, 22.5, 21.5, 19.0])
TOML = """model = "bench"
source = "made up"
[drive]
{reel} = {{ actuator = "reel", hold = true }}
[measured]
{tension} = {{ sensor = "input_tension", noise = {noise} }}
"""


def write(folder: Path, time: str, reel: str, tension: str, noise: float) -> Path:
    """The same motion under any names, in the units that these claim."""
    names = [time, reel, tension]
    scaled = [v / si_name(n)[1] for n, v in zip(names, (TIME, REEL, TENSION), strict=True)]
    rows = "\n".join(",".join(map(repr, row)) for row in np.transpose(scaled).tolist())
    (folder / "r.csv").write_text(",".join(names) + "\n" + rows + "\n")
    (folder / "r.toml").write_text(TOML.format(reel=reel, tension=tension, noise=noise))
    return folder / "r.csv"


@pytest.mark.parametrize(
    ("names", "noise"),
    [
        (("time_s", "reel_m", "pull_N"), 0.05),
        (("time_ms", "reel_mm", "pull_kN"), 5e-5),
        (("time_us", "reel_inch", "pull_mN"), 50.0),
        (("time_ns", "reel_um", "pull_kgf"), 0.05 / 9.80665),
        (("time_ms", "reel_cm", "pull_lbf"), 0.05 / 4.4482216152605),
    ],
)
def test_a_recording_is_the_same_in_any_unit(
    tmp_path: Path, names: tuple[str, str, str], noise: float
) -> None:
    read = read_recording(write(tmp_path, *names, noise))
    assert list(read.columns) == ["reel_m", "pull_N"]
    assert_allclose(read.time, TIME, atol=1e-12)
    assert_allclose(read.columns["reel_m"], REEL, atol=1e-15)
    assert_allclose(read.columns["pull_N"], TENSION, rtol=1e-12)
    assert read.measured["pull_N"].noise == pytest.approx(0.05, rel=1e-12)
    assert (dict(read.drive), read.hold) == ({"reel_m": "reel"}, ("reel_m",))
    assert read.written("pull_N") == names[2]


def test_what_was_converted_is_written_in_si_and_reads_back_the_same(tmp_path: Path) -> None:
    read = read_recording(write(tmp_path, "time_ms", "reel_mm", "pull_kN", 5e-5))
    assert read_recording(write_recording(read, tmp_path / "r")) == read


@pytest.mark.parametrize(
    ("column", "target", "factor"),
    [
        ("angle_deg", "angle_rad", np.pi / 180.0),
        ("angle_rev", "angle_rad", 2.0 * np.pi),
        ("motor_rpm", "motor_rad_per_s", np.pi / 30.0),
        ("rate_deg_per_s", "rate_rad_per_s", np.pi / 180.0),
        ("feed_mm_per_min", "feed_m_per_s", 1e-3 / 60.0),
        ("load_Ncm", "load_Nm", 0.01),
        ("load_kgfcm", "load_Nm", 0.0980665),
        ("stop_mNm", "stop_Nm", 1e-3),
    ],
)
def test_units_are_those_that_they_claim(column: str, target: str, factor: float) -> None:
    name, found = si_name(column)
    assert name == target
    assert found == pytest.approx(factor, rel=1e-12)


def test_units_of_si_are_left_as_they_are_to_the_bit() -> None:
    assert {unit: UNIT_FACTORS[unit] for unit in UNITS} == {unit: (unit, 1.0) for unit in UNITS}


def test_a_column_is_named_as_the_file_has_it(tmp_path: Path) -> None:
    path = write(tmp_path, "time_s", "reel_mm", "pull_deg", 1.0)
    with refusing(RecordingError, "'pull_deg': sensor 'input_tension' reads [N]"):
        Simulator([read_recording(path)])
    toml = path.with_suffix(".toml")
    toml.write_text(toml.read_text().replace('"reel"', '"real"'))
    with refusing(RecordingError, "'reel_mm': unknown actuator 'real'; did you mean"):
        Simulator([read_recording(path)])


def test_a_trajectory_or_table_alone_is_converted_too(tmp_path: Path) -> None:
    path = write(tmp_path, "time_ms", "reel_mm", "pull_N", 0.05)
    assert list(read_table(path)) == ["time_s", "reel_m", "pull_N"]


# --- Parquet


def test_parquet_and_csv_are_the_same_recording(tmp_path: Path) -> None:
    csv = read_recording(write(tmp_path, "time_s", "reel_mm", "pull_N", 0.05))
    table = {"time_s": TIME, "reel_mm": REEL / 1e-3, "pull_N": TENSION}
    path = parquet(tmp_path / "r.parquet", **table)
    assert read_recording(path) == csv
    (tmp_path / "r.csv").unlink()
    for either in ("r", "r.toml"):
        assert read_recording(tmp_path / either) == csv


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"time_s": [0.0, 0.1], "a_N": ["1", "2"]}, "column 'a_N': holds string"),
        ({"time_s": [0.0, 0.0], "a_N": [1.0, 1.0]}, "column 'time_s': all times are 0.0"),
        ({"time_s": [0.1, 0.0], "a_N": [1.0, 1.0]}, "row 3, column 'time_s': 0.0 does not come"),
        ({"time_s": [0.0, 0.1], "a": [1.0, 1.0]}, "column 2: 'a' does not end in a unit"),
        ({}, "holds no column"),
    ],
)
def test_a_broken_parquet_is_refused_with_file_row_and_column(
    tmp_path: Path, columns: dict[str, list[object]], said: str
) -> None:
    path = parquet(tmp_path / "r.parquet", **columns)
    with refusing(RecordingError, "r.parquet", said):
        read_table(path)


# --- MCAP


MCAP = """[columns]
reel_mm = { topic = "/reel", field = "data" }
pull_N = { topic = "/cell", field = "wrench.force.0" }
"""


def rig_log(folder: Path, offset: float = 0.0) -> Path:
    reel = [("/reel", t, {"data": x / 1e-3}) for t, x in zip(TIME, REEL, strict=True)]
    pull = [
        ("/cell", t + offset, {"wrench": {"force": [f, 0.0]}})
        for t, f in zip(TIME, TENSION, strict=True)
    ]
    path = log(folder / "r.mcap", *sorted([*reel, *pull, ("/idle", 0.1, "x")], key=lambda m: m[1]))
    described = TOML.format(reel="reel_mm", tension="pull_N", noise=0.05)
    (folder / "r.toml").write_text(described + MCAP)
    return path


def test_a_log_and_a_csv_are_the_same_recording(tmp_path: Path) -> None:
    path = rig_log(tmp_path)
    read = read_recording(path)
    assert_allclose(read.time, TIME, atol=1e-9)
    assert_allclose(read.columns["reel_m"], REEL, atol=1e-15)
    assert_array_equal(read.columns["pull_N"], TENSION)
    assert read == read_recording(tmp_path / "r.toml")


def test_another_topic_is_linear_between_its_messages_within_the_common_time(
    tmp_path: Path,
) -> None:
    read = read_recording(rig_log(tmp_path, offset=0.05))
    assert_allclose(read.columns["reel_m"], REEL[1:])  # before the first force nothing is known
    assert_allclose(read.columns["pull_N"], 0.5 * (TENSION[1:] + TENSION[:-1]))


def test_a_held_drive_of_another_topic_keeps_the_latest_message(tmp_path: Path) -> None:
    path = rig_log(tmp_path, offset=0.05)
    toml = path.with_suffix(".toml")
    text = toml.read_text().partition("[columns]")[0]
    entries = MCAP.splitlines()[1:]
    toml.write_text("\n".join([text, "[columns]", *reversed(entries)]))
    assert_allclose(read_recording(path).columns["reel_m"], REEL[:-1])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"/reel"', '"/real"', "unknown topic '/real'; did you mean '/reel'?"),
        ('"data"', '"date"', "unknown field 'date'; did you mean 'data'?"),
        ('"wrench.force.0"', '"wrench.force.7"', "unknown field '7'"),
        ('"wrench.force.0"', '"wrench"', "is {'force': [20.0, 0.0]}, not a number"),
        ('field = "data"', 'feild = "data"', "did you mean 'field'?"),
        ("[columns]", "[other]", "unknown key 'other'"),
        (MCAP, "", "has no [columns]"),
    ],
)
def test_a_log_is_refused_with_topic_and_field(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    path = rig_log(tmp_path)
    toml = path.with_suffix(".toml")
    assert old in toml.read_text()
    toml.write_text(toml.read_text().replace(old, new))
    with refusing(RecordingError, said):
        read_recording(path)


def test_other_encodings_and_other_files_are_refused(tmp_path: Path) -> None:
    path = rig_log(tmp_path)
    log(path, ("/reel", 0.0, {"data": 1.0}), ("/cell", 0.0, {}), encoding="protobuf")
    with refusing(RecordingError, "encoded as 'protobuf'; JSON and ROS 2's CDR are read"):
        read_recording(path)
    for name, kind in (("r.mcap", "an MCAP"), ("r.parquet", "a Parquet")):
        (tmp_path / name).write_bytes(b"no such thing")
        with refusing(RecordingError, f"not {kind}"):
            read_recording(tmp_path / name)


@pytest.mark.parametrize(("suffix", "package"), [(".parquet", "pyarrow"), (".mcap", "mcap.reader")])
def test_a_missing_reader_is_told_with_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, package: str
) -> None:
    write(tmp_path, "time_s", "reel_mm", "pull_N", 0.05)
    (tmp_path / f"r{suffix}").write_bytes(b"")
    with (tmp_path / "r.toml").open("a") as file:
        file.write(MCAP)
    monkeypatch.setitem(sys.modules, package, None)
    with refusing(MissingPackageError, f"pip install 'tendon-mj[{suffix[1:]}]'"):
        read_recording(tmp_path / f"r{suffix}")


# --- where a model is sought


def test_a_model_is_sought_beside_its_description_and_then_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, "time_s", "reel_m", "pull_N", 0.05)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert read_recording(path).model == "bench"
    (tmp_path / "hand.xml").write_text("<mujoco/>")
    toml = path.with_suffix(".toml")
    toml.write_text(toml.read_text().replace('"bench"', '"hand.xml"'))
    assert Path(read_recording(path).model) == tmp_path / "hand.xml"
    toml.write_text(toml.read_text().replace('"hand.xml"', '"hnad.xml"'))
    recording = read_recording(path)
    for load in (lambda: replay_recording(recording), lambda: Simulator([recording])):
        with pytest.raises(UnknownNameError) as caught:
            load()
        for said in (str(tmp_path), "the description", "did you mean 'hand.xml'", "'bench'"):
            assert said in str(caught.value)


MESSAGES = """model = "bench"
source = "made up"
[drive]
input_displacement_m = "reel"
[measured]
input_tension_N = {{ sensor = "input_tension" }}
[columns]
input_displacement_m = {{ topic = "/a", field = "{field}" }}
input_tension_N = {{ topic = "/a", field = "{field}" }}
"""


def message_log(
    folder: Path, *messages: bytes, field: str = "x.0", compression: str = "ZSTD"
) -> Path:
    """A log of JSON messages of one topic, 1 ms apart."""
    stamped = [("/a", k * 10**6, data) for k, data in enumerate(messages)]
    path = log(folder / "r.mcap", *stamped, compression=compression)
    path.with_suffix(".toml").write_text(MESSAGES.format(field=field))
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
        path = message_log(
            tmp_path, *(b'{"x": [%d]}' % k for k in range(40)), compression=compression
        )
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
        read_recording(message_log(tmp_path, message, message, field=field))
