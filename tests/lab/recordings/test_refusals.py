"""Each file that is no recording is refused with where it is broken and the nearest valid name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording, read_recording, read_table
from tests.refusals import refusing

HEADER = "time_s,reel_m,tension_N\n"
CSV = HEADER + "0,0,20\n0.1,1e-3,21\n0.2,2e-3,22\n"
TOML = """model = "bench"
source = "made up"
[drive]
reel_m = "reel"
[measured]
tension_N = { sensor = "input_tension", noise = 0.05 }
[known]
"sheath.axial_stiffness" = 20000
[uncertain]
"sheath.friction" = { value = 0.15, low = 0.05, high = 0.4 }
"""


def refusal(folder: Path, csv: str | bytes = CSV, toml: str | bytes = TOML) -> str:
    for suffix, text in ((".csv", csv), (".toml", toml)):
        data = text if isinstance(text, bytes) else text.encode()
        (folder / f"rig{suffix}").write_bytes(data)
    with pytest.raises(RecordingError) as caught:
        read_recording(folder / "rig")
    return str(caught.value)


def test_the_unbroken_files_are_accepted(tmp_path: Path) -> None:
    (tmp_path / "rig.csv").write_text(CSV)
    (tmp_path / "rig.toml").write_text(TOML)
    assert read_recording(tmp_path / "rig").time.size == 3


@pytest.mark.parametrize(
    ("csv", "where", "what"),
    [
        ("", "row 1", "empty"),
        (HEADER, "row 2", "at least 2 rows"),
        (HEADER + "0,0,20\n", "row 3", "at least 2 rows"),
        ("time,reel_m,tension_N\n0,0,0\n1,1,1\n", "row 1, column 1", "'time_s'"),
        ("time_s,reel_m,reel_m\n0,0,0\n1,1,1\n", "row 1, column 3", "the name of column 2"),
        ("time_s,reel_nm,tension_N\n0,0,0\n1,1,1\n", "row 1, column 2", "converted: _ms, "),
        ("time_s,reel_m,angle_dgr\n0,0,0\n1,1,1\n", "row 1, column 3", "did you mean '_deg'?"),
        ("time_s,reel_m,room_degC\n0,0,0\n1,1,1\n", "row 1, column 3", "with an offset"),
        ("time_s,reel_m,rate_per_s\n0,0,0\n1,1,1\n", "row 1, column 3", "unit that is read"),
        ("time_s,reel_m,speed_m_s\n0,0,0\n1,1,1\n", "row 1, column 3", "two units"),
        ("time_s,reel_m,reel_mm,tension_N\n0,0,0,0\n1,1,1,1\n", "'reel_mm'", "as 'reel_m' is"),
        ("time_s,reel_m,tension\n0,0,0\n1,1,1\n", "row 1, column 3", "'tension'"),
        ("time_s,reel_m,\n0,0,0\n1,1,1\n", "row 1, column 3", "''"),
        (
            HEADER.replace("_s", "_ms") + '0,0,20\n"1,000",1e-3,21\n"2,000",2e-3,22\n',
            "row 3, column 'time_ms'",
            "'1,000' is neither a number nor a time",
        ),
        (CSV.replace("21", "twenty"), "row 3, column 'tension_N'", "'twenty' is not a number"),
        (CSV.replace("21", "1_0"), "row 3, column 'tension_N'", "'1_0' is not a number"),
        (CSV.replace("21", "2\u0661"), "row 3, column 'tension_N'", "is not a number"),
        (CSV.replace("1e-3", "-inf"), "row 3, column 'reel_m'", "-inf is not finite"),
        (CSV.replace("1e-3", "-1e308"), "row 3, column 'reel_m'", "-1e+308"),
        (CSV.replace(",21", ",21,5"), "row 3, column 4", "'5' is one cell too many"),
        (HEADER + "0,0\n1,1\n", "row 2, column 'tension_N'", "empty cell"),
        (CSV.replace("0.2,", "0.05,"), "row 4, column 'time_s'", "0.05 does not come after 0.1"),
        (b"\xff\xfet\x00", "row 1, column 1", "0xff is not UTF-8"),
        (CSV.encode() + b"0.3,\xb5,23\n", "row 5, column 2", "0xb5 is not UTF-8"),
    ],
)
def test_a_broken_table_is_refused_with_row_and_column(
    tmp_path: Path, csv: str | bytes, where: str, what: str
) -> None:
    path = tmp_path / "rig.csv"
    path.write_bytes(csv if isinstance(csv, bytes) else csv.encode())
    with refusing(RecordingError, path, where, what):
        read_table(path)


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ('model = "bench"', "model = ", "line 1", "not TOML"),
        ('model = "bench"', 'mode = "bench"', "unknown key 'mode'", "did you mean 'model'?"),
        ('model = "bench"', "", "'model'", "missing"),
        ('model = "bench"', "model = 3", "model", "must be a text in quotes, got 3"),
        ('model = "bench"', 'model = " "', "model", "must not be empty"),
        ("[drive]", "[driven]", "unknown key 'driven'", "did you mean 'drive'?"),
        ("[drive]", "[[drive]]", "drive", "must be a table"),
        ('reel_m = "reel"', 'reel_M = "reel"', "[drive] 'reel_M'", "did you mean 'reel_m'?"),
        ('reel_m = "reel"', 'time_s = "reel"', "[drive] 'time_s'", "clock"),
        ('reel_m = "reel"', "reel_m = 1", "[drive] 'reel_m'", "got 1"),
        ('reel_m = "reel"', 'reel_m = ""', "[drive] 'reel_m'", "must not be empty"),
        ('"reel"', '"reel"\ntension_N = "reel"', "[drive] 'tension_N'", "'reel_m' already drives"),
        ('"reel"', '"reel"\ntension_N = "b"', "[measured] 'tension_N'", "is also in [drive]"),
        ('"reel"', '"reel"\nreel_m = "b"', "line 5", "not TOML"),
        ("tension_N =", "tensoin_N =", "[measured] 'tensoin_N'", "did you mean 'tension_N'?"),
        ("sensor =", "senser =", "[measured] 'tension_N'", "did you mean 'sensor'?"),
        ('sensor = "input_tension", ', "", "[measured] 'tension_N'", "'sensor' is missing"),
        ('"input_tension"', '""', "[measured] 'tension_N'", "sensor must be a name"),
        ("noise = 0.05", "noize = 0.05", "[measured] 'tension_N'", "did you mean 'noise'?"),
        ("noise = 0.05", "noise = 0", "[measured] 'tension_N'", "noise = 0.0"),
        ("noise = 0.05", "noise = nan", "[measured] 'tension_N'", "noise = nan"),
        ("noise = 0.05", 'noise = "1"', "[measured] 'tension_N', noise", "a number, got '1'"),
        ('{ sensor = "input_tension", noise = 0.05 }', '"a"', "'tension_N'", "write { sensor"),
        ('"sheath.axial_stiffness"', "stiffness", "[known] 'stiffness'", "<element>.<parameter>"),
        ('"sheath.axial_stiffness"', '".a"', "[known] '.a'", "<element>.<parameter>"),
        ('"sheath.axial_stiffness"', "sheath.axial", "[known] 'sheath'", "is quoted"),
        ("20000", '"20000"', "[known] 'sheath.axial_stiffness'", "a number, got '20000'"),
        ("20000", "inf", "[known] 'sheath.axial_stiffness'", "inf"),
        ("20000", "-1e308", "[known] 'sheath.axial_stiffness'", "-1e+308"),
        ("20000", "1e-300", "[known] 'sheath.axial_stiffness'", "at least 1e-30 in size"),
        ('"sheath.friction"', "sheath.friction", "[uncertain] 'sheath'", "is quoted"),
        ('"sheath.friction"', '"sheath.axial_stiffness"', "[uncertain]", "is also in [known]"),
        ("value = 0.15", "value = 0.5", "[uncertain] 'sheath.friction'", "0.05 ≤ 0.5 ≤ 0.4"),
        ("high = 0.4", "high = inf", "[uncertain] 'sheath.friction'", "high = inf"),
        ("{ value = 0.15, low = 0.05, high = 0.4 }", "0.15", "'sheath.friction'", "write { value"),
    ],
)
def test_a_broken_description_is_refused_with_table_and_key(
    tmp_path: Path, old: str, new: str, where: str, what: str
) -> None:
    assert TOML.count(old)
    message = refusal(tmp_path, toml=TOML.replace(old, new, 1))
    assert message.startswith(str(tmp_path / "rig.toml"))
    assert where in message
    assert what in message


def test_a_name_that_two_columns_have_is_not_mapped(tmp_path: Path) -> None:
    csv = "time_s,reel_m,cell,cell\n0,0,20,19\n0.1,1e-3,21,20\n0.2,2e-3,22,21\n"
    toml = TOML + '[columns]\ntension_N = { column = "cell", unit = "N" }\n'
    told = refusal(tmp_path, csv, toml)
    assert "[columns] 'tension_N'" in told
    assert "several columns 'cell'" in told


def test_a_missing_table_is_refused_with_the_nearest_file(tmp_path: Path) -> None:
    (tmp_path / "bend_060.csv").write_text(CSV)
    meant = str(tmp_path / "bend_060.csv")  # with its folder, to be copied
    with refusing(RecordingError, "bend_60.csv: no", f"mean {meant!r}?"):
        read_recording(tmp_path / "bend_60")


def test_a_missing_description_is_refused_with_the_way_out(tmp_path: Path) -> None:
    (tmp_path / "rig.csv").write_text(CSV)
    (tmp_path / "rigs.toml").write_text(TOML)
    with refusing(RecordingError, "rig.toml:", "'rigs.toml'", "`description`"):
        read_recording(tmp_path / "rig.csv")
    with refusing(RecordingError, "rigg.toml: no such file", "'rigs.toml'"):
        read_recording(tmp_path / "rig.csv", description=tmp_path / "rigg.toml")


def test_a_missing_folder_or_a_folder_for_a_file_is_refused(tmp_path: Path) -> None:
    with refusing(RecordingError, "nor a folder"):
        read_recording(tmp_path / "nowhere" / "rig")
    (tmp_path / "rig.csv").mkdir()
    with refusing(RecordingError, "rig.csv: cannot be read"):
        read_recording(tmp_path / "rig")


def test_a_noise_that_is_too_small_in_si_is_refused_at_its_column(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("time_s,x_m,pull_uN\n0,0,1\n1,0,1\n")
    (tmp_path / "r.toml").write_text(
        'model = "bench"\nsource = "s"\n[drive]\nx_m = "reel"\n[measured]\n'
        'pull_uN = { sensor = "input_tension", noise = 1e-26 }\n'
    )
    with refusing(RecordingError, "r.toml, [measured] 'pull_uN', in SI: noise"):
        read_recording(tmp_path / "r.csv")


@pytest.mark.parametrize(
    "more",
    [
        {"time": ["a", "b", "c"]},
        {"columns": {"x_m": ["x", "y", "z"]}},
        {"columns": {"x_m": [1, None, [2]]}},
        {"uncertain": {"a.b": 3}},
        {"session": {"a.b": 1.0}},
        {"measured": {"x_m": "sensor"}},
    ],
)
def test_a_recording_of_wrong_types_is_refused_as_one(more: dict[str, Any]) -> None:
    given = {
        "name": "r",
        "model": "m",
        "source": "s",
        "time": [0, 1, 2],
        "columns": {"x_m": [0] * 3},
    }
    Recording(**given)
    with refusing(RecordingError, "recording 'r'"):
        Recording(**given | more)
