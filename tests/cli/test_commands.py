"""Commands from their arguments to their result."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.cli import main
from tendon_mj.cli.commands import COMMANDS
from tendon_mj.lab.recordings import read_recording
from tendon_mj.lab.replay import replay_recording
from tendon_mj.models import example_recording
from tests.lab.recorded import written


def read(folder):
    return json.loads((folder / "result.json").read_text("utf-8"))


def test_compare_meets_its_figures(tmp_path):
    assert main(["compare", "--out", str(tmp_path)]) == 0
    result = read(tmp_path)
    assert result["apparent_stiffness"]["max_relative_error"] < 0.016
    assert result["equivalent_backlash"]["max_relative_error"] < 0.002
    assert result["transmission"]["max_relative_error"] < 1e-9
    assert result["limit"]["apparent_stiffness"]["max_relative_error"] < 7e-4
    assert result["limit"]["equivalent_backlash"]["max_relative_error"] < 1e-4
    assert result["convergence_order"] == pytest.approx(2.0, abs=0.2)
    for picture in ("loops", "sweep", "limit", "convergence"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000


def test_the_line_for_the_tab_key_has_all_commands():
    page = Path(__file__).parents[2].joinpath("docs", "commands.md").read_text("utf-8")
    assert set(re.search(r'complete .* -W "(.*)" tendon-mj', page)[1].split()) == set(COMMANDS)


def test_replay_of_the_example_needs_the_friction(tmp_path):
    assert main(["replay", str(example_recording()), "--out", str(tmp_path)]) == 0
    result = read(tmp_path)
    with_friction = result["rmse"]["as described"]["output_tension_N"]["rmse"]
    without = result["rmse"]["friction 0"]["output_tension_N"]["rmse"]
    assert with_friction < 2 * 0.05  # twice the sensors' noise [N]
    assert without > 10 * with_friction
    assert "not measured" in result["source"]


@pytest.mark.parametrize(
    "change",
    [
        *(f"sheath.friction={value}" for value in ("nan", "-inf", "1e999", "much", "")),
        "sheeth.friction=0.3",
        "sheath.friction=0.1,sheath.friction=0.2",
    ],
)
def test_a_change_that_is_not_a_value_of_a_parameter_is_refused(change, tmp_path, capsys):
    recording = str(example_recording())
    assert main(["replay", recording, "--change", change, "--out", str(tmp_path)]) == 2
    assert f"'{change.partition('=')[0]}" in capsys.readouterr().err


def test_changes_are_more_variants_wherever_they_are_given(tmp_path):
    shift, more = "?utput_tension.o*=0.1", "*.friction=0.3"
    arguments = ["replay", "--change", more, shift, "--out", str(tmp_path), "--change=*.friction=0"]
    assert main([*arguments, str(example_recording())]) == 0
    result = read(tmp_path)["rmse"]
    assert list(result) == ["as described", "friction 0", more, shift, "*.friction=0"]
    assert result[more]["output_tension_N"]["rmse"] > 0.5
    shifted, plain = result[shift], result["as described"]
    assert shifted["input_tension_N"] == plain["input_tension_N"]
    assert shifted["output_tension_N"]["rmse"] > plain["output_tension_N"]["rmse"]
    assert result["*.friction=0"] == result["friction 0"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["finger", "--duration", "1e9"], "GB of memory"),
        (["finger", "--duration", "-1"], "must be finite and > 0"),
        (["bench", "--duration", "1e9"], "GB of memory"),
        (["finger", "--duration", "0"], "must be finite and > 0"),
        (["bench", "--motion", "curl"], "Motions with a name, such as curl, are the finger's"),
        (["bench", "--fps", "0"], "must be finite and > 0"),
        (["bench", "--size", "99998x720"], "width = 99998"),
        (["bench", "--size", "wide"], "give width x height in pixels"),
        (["bench", "--camera", "top"], "unknown camera 'top'"),
        (["finger", "--motion", "prss"], "did you mean 'press'"),
    ],
)
def test_render_refuses_before_it_simulates(arguments, said, tmp_path, capsys):
    assert main(["render", *arguments, "--out", str(tmp_path)]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert said in error
    assert "Traceback" not in error


def test_times_in_the_wrong_unit_are_refused_before_they_cost_hours(tmp_path, capsys):
    path = written(tmp_path, "0,0,20\n1e-9,1e-4,21\n2e-9,2e-4,22\n")
    assert main(["replay", path, "--out", str(tmp_path)]) == 2
    assert "are the times in seconds" in " ".join(capsys.readouterr().err.split())


def test_a_column_that_never_moves_has_no_range(tmp_path, capsys):
    path = written(tmp_path, "0,0,20\n0.1,1e-4,20\n0.2,2e-4,20\n")
    for command in ("check", "replay"):
        assert main([command, path, "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "rms error" in printed
    assert "inf%" not in printed
    misfit = read(tmp_path)["rmse"]["as described"]["input_tension_N"]
    assert misfit["share_of_range"] is None
    assert misfit["rmse"] > 0.0


@pytest.mark.parametrize("motion", ["curl", "press"])
def test_simulate_finger_shows_what_friction_does(motion, tmp_path):
    arguments = ["simulate", "finger", "--motion", motion, "--out", str(tmp_path), "--no-clip"]
    assert main(arguments) == 0
    result = read(tmp_path)
    assert result["friction 0"]["flexor_input_over_output_max"] == pytest.approx(1.0, abs=1e-9)
    assert result["friction as in the model"]["flexor_input_over_output_max"] > 1.5
    assert result["friction as in the model"]["flexor_input_over_output_min"] < 0.7
    assert (tmp_path / f"{motion}.png").stat().st_size > 10_000
    recording = read_recording(tmp_path / motion)
    again = replay_recording(recording)
    for column in recording.measured:
        np.testing.assert_allclose(
            again.columns[column], recording.columns[column], rtol=1e-9, atol=1e-12
        )


def test_simulate_finger_follows_a_table(tmp_path):
    table = tmp_path / "pull.csv"
    table.write_text("time_s,flexor_N,extensor_N\n0,4,4\n0.5,8,4\n1,8,4\n")
    out = tmp_path / "out"
    arguments = ["simulate", "finger", "--motion", str(table), "--out", str(out), "--no-clip"]
    assert main(arguments) == 0
    tension = read_recording(out / "pull").columns["flexor_input_tension_N"]
    assert tension[-1] == pytest.approx(8.0, abs=0.3)
    tracking = read(out)["friction as in the model"]["tracking"]
    assert tracking["flexor_input_tension_N"].keys() == {"rmse", "largest", "bias"}
    table.write_text("time_s,thumb_N\n0,4\n1,8\n")
    assert main(arguments) == 2


def test_simulate_finger_refuses_degrees_and_clamps_when_told_to(tmp_path, capsys):
    table = tmp_path / "degrees.csv"
    table.write_text("time_s,mcp_rad,pip_rad,dip_rad\n0,0,0,0\n1,45,0,0\n")
    arguments = ["simulate", "finger", "--motion", str(table), "--out", str(tmp_path / "out")]
    arguments.append("--no-clip")
    assert main(arguments) == 2
    assert "joint 'mcp' is commanded to 45 rad" in " ".join(capsys.readouterr().err.split())
    assert main([*arguments, "--clamp"]) == 0


def test_simulate_finger_does_not_write_over_the_table_that_it_follows(tmp_path, capsys):
    table = tmp_path / "mine.csv"
    table.write_text("time_s,flexor_N,extensor_N\n0,4,4\n0.1,8,4\n")
    before = table.read_text()
    arguments = ["simulate", "finger", "--motion", str(table), "--out", str(tmp_path), "--no-clip"]
    assert main(arguments) == 2
    assert "mine.csv" in capsys.readouterr().err
    assert table.read_text() == before


def test_a_clip_of_the_finger(tmp_path):
    table = tmp_path / "short.csv"
    table.write_text("time_s,mcp_rad,pip_rad,dip_rad\n0,0,0,0\n0.1,0.1,0.1,0.1\n")
    out = tmp_path / "out"
    assert main(["simulate", "finger", "--motion", str(table), "--out", str(out)]) == 0
    clip = read(out)["clip"]
    if clip is None:
        pytest.skip("no OpenGL on this machine")
    assert (out / clip).stat().st_size > 1000
