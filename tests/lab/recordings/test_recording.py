"""Laws of a recording: what is written reads back bit for bit, and what is checked stays so."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.recordings import (
    Measured,
    Recording,
    Session,
    Uncertain,
    is_same_model,
    read_recording,
    write_recording,
)
from tendon_mj.lab.recordings.description import parse_toml
from tendon_mj.lab.units import LARGEST, SMALLEST, UNITS
from tests.refusals import refusing

CELLS = st.floats(-LARGEST, LARGEST)
POSITIVE = st.floats(SMALLEST, LARGEST)
SIZES = st.just(0.0) | POSITIVE | st.floats(-LARGEST, -SMALLEST)
TEXT = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=60).filter(str.strip)
WORD = st.from_regex(r"[a-z]{3,8}[0-9]?", fullmatch=True)
PARAMETER = st.builds("{}.{}".format, TEXT, WORD).filter(
    lambda name: all(part.strip() for part in name.split("."))
)


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    clock = sorted(draw(st.lists(CELLS, min_size=2, max_size=8, unique=True)))
    words = draw(st.lists(WORD, max_size=5, unique=True))
    names = [f"{word}{draw(st.sampled_from(list(UNITS)))}" for word in words]
    names = [name for name in names if name != "time_s"]
    series = st.lists(CELLS, min_size=len(clock), max_size=len(clock))
    roles = {name: draw(st.sampled_from(["drive", "measured", "context"])) for name in names}
    driven = [name for name in names if roles[name] == "drive"]
    actuators = draw(st.lists(TEXT, min_size=len(driven), max_size=len(driven), unique=True))
    noise = st.none() | POSITIVE
    parameters = draw(st.lists(PARAMETER, max_size=6, unique=True))
    ranges = st.lists(SIZES, min_size=3, max_size=3).map(sorted)
    return Recording(
        name="any",
        model=draw(TEXT.filter(lambda text: "\0" not in text)),  # as no path has one
        source=draw(TEXT),
        time=np.array(clock),
        columns={name: np.array(draw(series)) for name in names},
        drive=dict(zip(driven, actuators, strict=True)),
        measured={
            name: Measured(draw(TEXT), draw(noise)) for name in names if roles[name] == "measured"
        },
        known={name: draw(SIZES) for name in parameters[::3]},
        uncertain={
            name: Uncertain(value=value, low=low, high=high, each=draw(st.booleans()))
            for name in parameters[1::3]
            for low, value, high in [draw(ranges)]
        },
        session={
            name: Session(value, max(draw(POSITIVE), 1e-11 * abs(value)))
            for name in parameters[2::3]
            for value in [draw(SIZES)]
        },
        hold=tuple(name for name in driven if draw(st.booleans())),
        settle=draw(st.sampled_from([0.0, 0.5]) | POSITIVE),
        settling_time=draw(st.none() | POSITIVE),
    )


def bench(**changes: object) -> Recording:
    fields: dict[str, object] = {
        "name": "bench",
        "model": "bench",
        "source": "made up",
        "time": np.array([0.0, 0.1, 0.2]),
        "columns": {
            "input_displacement_m": np.array([0.0, 0.001, 0.002]),
            "input_tension_N": np.array([20.0, 21.0, 22.0]),
        },
        "drive": {"input_displacement_m": "reel"},
        "measured": {"input_tension_N": Measured("input_tension", 0.05)},
        "known": {"sheath.axial_stiffness": 20000.0},
        "uncertain": {"sheath.friction": Uncertain(0.15, 0.05, 0.4)},
    }
    return Recording(**(fields | changes))  # type: ignore[arg-type]


def bits(recording: Recording) -> list[object]:
    """Everything in it, floats as their bits: 0.0 and -0.0 differ."""
    series = {"time_s": recording.time, **recording.columns}
    return [
        recording.model,
        recording.source,
        [(name, values.tobytes()) for name, values in series.items()],
        list(recording.drive.items()),
        [(name, m.sensor, repr(m.noise)) for name, m in recording.measured.items()],
        [(name, repr(value)) for name, value in recording.known.items()],
        [(name, repr(dataclasses.astuple(u))) for name, u in recording.uncertain.items()],
        [(name, repr(dataclasses.astuple(s))) for name, s in recording.session.items()],
        (sorted(recording.hold), repr(recording.settle), repr(recording.settling_time)),
    ]


@given(recordings())
def test_what_is_written_reads_back_bit_for_bit(recording: Recording) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = write_recording(recording, Path(folder) / recording.name)
        again = read_recording(path)
    assert bits(again) == bits(recording)
    assert again == recording


@settings(max_examples=20)
@given(recordings())
def test_writing_is_deterministic_and_idempotent(recording: Recording) -> None:
    with tempfile.TemporaryDirectory() as folder:
        first = write_recording(recording, Path(folder) / "first")
        second = write_recording(read_recording(first), Path(folder) / "second")
        for suffix in (".csv", ".toml"):
            one, two = first.with_suffix(suffix), second.with_suffix(suffix)
            assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("given_path", ["a.b", "a.b.csv", "a.b.toml"])
def test_csv_toml_and_stem_are_the_same_recording(tmp_path: Path, given_path: str) -> None:
    write_recording(bench(), tmp_path / given_path)
    assert {p.name for p in tmp_path.iterdir()} == {"a.b.csv", "a.b.toml"}
    for path in ("a.b", "a.b.csv", "a.b.toml"):
        assert read_recording(tmp_path / path) == bench(name="a.b")
        assert read_recording(str(tmp_path / path)) == bench(name="a.b")


def test_one_description_elsewhere_serves_many_tables(tmp_path: Path) -> None:
    written = write_recording(bench(), tmp_path / "bench")
    data = tmp_path / "data"
    data.mkdir()
    for name in ("first", "second"):
        (data / f"{name}.csv").write_bytes(written.read_bytes())
        read = read_recording(data / f"{name}.csv", description=tmp_path / "bench.toml")
        assert read == bench(name=name)


def test_columns_without_a_role_are_kept_as_context(tmp_path: Path) -> None:
    path = write_recording(bench(drive={}, measured={}, known={}, uncertain={}), tmp_path / "x")
    assert list(read_recording(path).columns) == ["input_displacement_m", "input_tension_N"]


def test_spaces_byte_order_mark_and_windows_lines_change_nothing(tmp_path: Path) -> None:
    path = write_recording(bench(), tmp_path / "bench")
    for file in (path, path.with_suffix(".toml")):
        text = file.read_text().replace("\n", "\r\n")
        spaced = text.replace(",", " , ") if file == path else text
        file.write_bytes(b"\xef\xbb\xbf" + spaced.encode() + b"\r\n")
    assert read_recording(path) == bench()


def test_a_recording_cannot_be_changed_and_owns_its_numbers() -> None:
    time_s = np.array([0.0, 1.0, 2.0])
    recording = bench(time=time_s)
    time_s[0] = 9.0
    assert recording.time[0] == 0.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        recording.model = "other"  # type: ignore[misc]
    for array in (recording.time, *recording.columns.values()):
        with refusing(ValueError, "read-only"):
            array[0] = 1.0


def test_copies_equal_the_original() -> None:
    recording = bench()
    for duplicate in (copy.deepcopy(recording), pickle.loads(pickle.dumps(recording))):
        assert duplicate == recording
    assert dataclasses.replace(recording, model="joint") != recording


def test_a_missing_actuator_or_sensor_is_refused_with_the_nearest() -> None:
    bench().check_against(actuators={"reel", "spare"}, sensors=["input_tension"])
    with refusing(RecordingError, "[drive] 'input_disp", "'reel'", "mean 'reels'"):
        bench().check_against(actuators=["reels", "servo"], sensors=["input_tension"])
    with refusing(RecordingError, "[measured] 'input_t", "mean 'input_tensions'"):
        bench().check_against(actuators=["reel"], sensors=["input_tensions", "angle"])


def test_values_refuse_impossible_numbers() -> None:
    with refusing(InvalidValueError, "0.5"):
        Uncertain(0.5, 0.1, 0.4)
    for noise in (0.0, -1.0, float("nan"), float("inf")):
        with refusing(InvalidValueError, "noise"):
            Measured("tension", noise)
    with refusing(InvalidValueError, "sensor"):
        Measured(" ")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": ""}, "name must not be empty"),
        ({"model": " "}, "model: must not be empty"),
        ({"time": [0.0, 0.2, 0.1]}, r"row 4, column 'time_s': 0.1 .* 0.2"),
        ({"time": [0.0, 0.1]}, r"column 'input_displacement_m': shape \(3,\)"),
        ({"columns": {"time_s": [0.0, 0.1, 0.2]}}, "column 'time_s': belongs in `time`"),
        ({"drive": {"input_displacment_m": "reel"}}, "mean 'input_displacement_m'"),
    ],
)
def test_a_recording_made_in_code_obeys_the_laws_of_files(
    changes: dict[str, object], message: str
) -> None:
    with pytest.raises(RecordingError, match=message):
        bench(**changes)


def test_the_documented_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = Path(__file__).parents[3] / "docs" / "recording.md"
    found = re.findall(r"```(\w+)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    blocks = dict(reversed(found))  # the first of each language
    monkeypatch.chdir(tmp_path)
    Path("pull.csv").write_text(blocks["csv"])
    Path("pull.toml").write_text(blocks["toml"])
    code = "\n".join(block for language, block in found if language == "python")
    names: dict[str, Any] = {}
    exec(compile(code, page.name, "exec"), names)
    assert names["simulator"].parameters["sheath.friction"][:2] == (0.15, "-")
    assert names["read_intervals"](names["model"]) == names["within"]
    assert bits(read_recording("again")) == bits(read_recording("pull"))
    head = 'model = "joint"\nsource = "a rig"\n'
    fragment, settled, log = [block for language, block in found if language == "toml"][1:4]
    described = parse_toml(head + fragment, page.name)[0]
    assert (described.hold, described.settle) == (("command_rad",), 0.0)
    assert described.session
    described = parse_toml(head + settled, page.name)[0]
    assert (described.quasi_static, described.settling_time) == (True, 8.0)
    topics = parse_toml(head + log, page.name)[1].columns
    assert list(topics) == ["command_deg", "input_tension_N", "joint_deg"]
    Path("pull.toml").write_text(blocks["toml"].replace("displacement", "displacment"))
    with pytest.raises(RecordingError, match=re.escape(" ".join(blocks["text"].split()))):
        read_recording("pull")


def test_a_model_s_file_is_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("one/rig", "one/out", "two/rig"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "rig.xml").write_text("<mujoco/>")
    monkeypatch.chdir(tmp_path / "one")
    time = np.array([0.0, 1.0])
    first = Recording(name="a", model="rig/rig.xml", source="s", time=time, columns={})
    write_recording(first, "out/a")
    assert read_recording("out/a").model == "rig/rig.xml"  # the same name from the same folder
    for folder in ("two", "two/rig"):
        monkeypatch.chdir(tmp_path / folder)
        found = Path(read_recording(tmp_path / "one" / "out" / "a").model)
        assert found.samefile(tmp_path / "one" / "rig" / "rig.xml")
    (tmp_path / "link").symlink_to("one/out")
    monkeypatch.chdir(tmp_path)
    assert Path(read_recording("link/a").model).samefile(tmp_path / "one" / "rig" / "rig.xml")
    write_recording(dataclasses.replace(first, model="rig"), "link/b")  # a model of the package
    assert read_recording("link/b").model == "rig"


def test_a_link_to_a_model_is_named_and_not_what_it_links_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Since what the model includes lies beside the link."""
    for folder in ("rig", "store", "out"):
        (tmp_path / folder).mkdir()
    (tmp_path / "store" / "abc").write_text("<mujoco/>")
    (tmp_path / "rig" / "rig.xml").symlink_to("../store/abc")
    monkeypatch.chdir(tmp_path)
    time = np.array([0.0, 1.0])
    one = Recording(name="a", model="rig/rig.xml", source="s", time=time, columns={})
    write_recording(one, "out/a")
    assert read_recording("out/a").model == "rig/rig.xml"


def test_a_file_with_the_name_of_a_model_is_not_taken_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench").write_text("not a model")
    (tmp_path / "out").mkdir()
    time = np.array([0.0, 1.0])
    write_recording(Recording(name="a", model="bench", source="s", time=time, columns={}), "out/a")
    assert read_recording("out/a").model == "bench"


def test_one_model_by_several_paths_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "rig.xml").write_text("<mujoco/>")
    (tmp_path / "link").symlink_to("a")
    (tmp_path / "a" / "other.xml").symlink_to("rig.xml")
    assert is_same_model("bench", "bench")
    assert is_same_model("a/rig.xml", str(tmp_path / "a" / "rig.xml"))
    assert is_same_model("a/rig.xml", "link/rig.xml")
    for other in ("b/rig.xml", "a/other.xml", "bench"):
        assert not is_same_model("a/rig.xml", other)
