"""The command `sweep` from its arguments to its files."""

import dataclasses
import json
import shutil

import pandas
import pytest

from tendon_mj.cli import main
from tendon_mj.lab.recordings import read_recording, write_recording
from tendon_mj.models import example_recording

pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")

BENCH = ["sweep", "bench", "--processes", "1"]
VARIED = ["--parameter", "sheath.friction=0.05:0.3:3", "environment.stiffness=9.9e3:1.01e4"]


def test_a_sweep_has_a_table_a_picture_and_says_what_matters(tmp_path, capsys):
    options = ["--duration", "0.3", "--draws", "4", "--outputs", "output_tension"]
    assert main([*BENCH, *VARIED, *options, "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "12 rollouts" in said
    assert "of its variance follows sheath.friction; all stayed stable." in said
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert result["rollouts"] == 12
    assert result["outputs"]["output_tension.max"]["share_of_variance"].keys() == {
        "sheath.friction",
        "environment.stiffness",
    }
    assert {"rollouts", "sweep.png", "table.csv"} == set(result["files"])
    assert len((tmp_path / "table.csv").read_text().splitlines()) == 13
    assert (tmp_path / "sweep.png").stat().st_size > 10_000
    options[3] = "5"
    assert main([*BENCH, *VARIED, *options, "--out", str(tmp_path)]) == 2
    assert "draws is 4 there and 5 here" in " ".join(capsys.readouterr().err.split())
    assert (tmp_path / "result.json").exists()  # nothing was touched


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--parameter", "sheath.fricton=0.1,0.2"], "did you mean 'sheath.friction'"),
        ([*VARIED, "--workers", "2", "--scheduler", "tcp://a:1"], "give one of them"),
        ([*VARIED, "--motion", "nowhere.csv"], "no such file"),
        ([*VARIED, "--outputs", "output_force"], "did you mean 'output_tension'"),
        ([*VARIED, "--duration", "1", "--recording", str(example_recording())], "give one of them"),
        ([*VARIED, "--duration", "1e12"], "1e+12 s"),
        ([*VARIED, "--draws", "2", "--seed", "-1"], "--seed -1 must be ≥ 0"),
        ([*VARIED, "--draws", "100000000000"], "make 300000000000 rollouts; a sweep has at most"),
        ([*VARIED, "--policy", "nowhere.py:pull"], "nowhere.py: no such file"),
    ],
)
def test_refusals_are_one_line_and_come_before_anything_is_written(options, said, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["sweep", "bench", *options, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert said in " ".join(error.split())
    assert "Traceback" not in error
    assert not out.exists()


def test_a_recording_s_sweep_tells_the_error_and_odd_times_and_does_not_write_over_it(
    tmp_path, capsys
):
    recording = read_recording(example_recording())
    time, cut = recording.time[:60].copy(), slice(0, 60)
    time[40:] += 0.7
    columns = {name: values[cut] for name, values in recording.columns.items()}
    write_recording(dataclasses.replace(recording, time=time, columns=columns), tmp_path / "table")
    before = (tmp_path / "table.csv").read_bytes()
    arguments = ["sweep", "bench", "--parameter", "sheath.friction=0.1,0.2", "--processes", "1"]
    arguments += ["--recording", str(tmp_path / "table.csv"), "--out"]
    assert main([*arguments, str(tmp_path)]) == 2
    assert "table.csv" in capsys.readouterr().err
    assert (tmp_path / "table.csv").read_bytes() == before
    assert main([*arguments, str(tmp_path / "out"), "--outputs", "*.error"]) == 0
    assert "1 gap" in capsys.readouterr().out
    outputs = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))["outputs"]
    assert outputs
    assert all(name.endswith(".error") for name in outputs)


def contents(folder):
    """Path → bytes of every file, but for the lock."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != ".lock"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


FRICTION = ["--parameter", "sheath.friction=0.1,0.2"]
SHORT = ["--duration", "0.02", "--settle", "0.02"]
LATE = {
    "no scheduler": (["--scheduler", "tcp://127.0.0.1:1"], "no Dask scheduler answers"),
    "value": (["--parameter", "sheath.friction=0.1,1e308"], "1e+308"),
    "value within a range": (
        ["--parameter", "sheath.static_friction=0:0.4:5"],  # 0 is none given
        "static_friction = 0.1 must be ≥ friction",
    ),
    "policy": (["--policy", "POLICY"], "no such joint"),
}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Folder of a sweep that ran to its end."""
    out = tmp_path_factory.mktemp("sweep") / "out"
    assert main([*BENCH, *FRICTION, *SHORT, "--out", str(out)]) == 0
    return out


@pytest.mark.parametrize(("again", "late"), [*((True, late) for late in LATE), (False, "policy")])
def test_a_sweep_that_is_refused_late_leaves_the_folder_as_it_was(
    again, late, finished, tmp_path, capsys
):
    options, said = LATE[late]
    if options[0] == "--scheduler":
        pytest.importorskip("distributed", reason="the extra tendon-mj[cluster] is not installed")
    policy = tmp_path / "bad.py"
    policy.write_text("def pull(model, data):\n    raise ValueError('no such joint')\n")
    options = [f"{policy}:pull" if option == "POLICY" else option for option in options]
    out = shutil.copytree(finished, tmp_path / "out")
    if not again:  # what another command left
        shutil.rmtree(out / "rollouts")
        (out / "plan.json").unlink()
    before, varied = contents(out), [] if "--parameter" in options else FRICTION
    where = [] if "--scheduler" in options else ["--processes", "1"]
    asked = ["sweep", "bench", *varied, *options, *SHORT, *where, "--out", str(out)]
    assert main([*asked, "--again"] if again else asked) == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert contents(out) == before


def test_names_that_no_column_may_have_are_swept_over(tmp_path):
    motors = "".join(f"<motor name='{n}' joint='j' ctrlrange='-1 1'/>" for n in ("m,1", "m_1"))
    sensors = "".join(f"<jointpos name='{n}' joint='j'/>" for n in ("q&quot;", "q_"))
    (tmp_path / "m.xml").write_text(
        "<mujoco><worldbody><body><joint name='j'/><geom size='0.1'/></body></worldbody>"
        f"<actuator>{motors}</actuator><sensor>{sensors}</sensor></mujoco>"
    )
    options = ["--parameter", "j.damping=0.1,0.2", "--duration", "0.1", "--processes", "1"]
    out = tmp_path / "out"
    assert main(["sweep", str(tmp_path / "m.xml"), *options, "--out", str(out)]) == 0
    table = pandas.read_csv(out / "table.csv")
    assert (table['q".final'] == table["q_.final"]).all()
