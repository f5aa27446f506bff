import json
import subprocess
import sys

import pytest

from tendon_mj.cli import main
from tendon_mj.cli.replay import carried_recording


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
    assert result["step_cost_ratio"] > 0.5  # a measurement, not a promise: the machine may be busy
    for picture in ("loops", "sweep", "limit", "convergence"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000


def test_replay_of_the_twin_needs_the_friction(tmp_path):
    assert main(["replay", str(carried_recording()), "--out", str(tmp_path)]) == 0
    result = read(tmp_path)
    with_friction = result["rmse"]["as described"]["output_tension_N"]["rmse"]
    without = result["rmse"]["friction 0"]["output_tension_N"]["rmse"]
    assert with_friction < 2 * 0.05  # twice the sensors' noise [N]
    assert without > 10 * with_friction
    assert "not measured" in result["source"]


def test_change_is_one_more_variant(tmp_path):
    arguments = ["replay", str(carried_recording()), "--out", str(tmp_path)]
    assert main([*arguments, "--change", "*.friction=0.3"]) == 0
    result = read(tmp_path)["rmse"]
    assert result["*.friction=0.3"]["output_tension_N"]["rmse"] > 0.5
    assert main([*arguments, "--change", "sheeth.friction=0.3"]) == 2
    assert main([*arguments, "--change", "sheath.friction=much"]) == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["replay", "nothing.csv"], "nothing.csv"),
        (["render", "bensch"], "did you mean 'bench'"),
    ],
)
def test_refusals_are_one_line(arguments, said, tmp_path, capsys):
    assert main([*arguments, "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error


def test_help_names_the_commands():
    script = "from tendon_mj.cli import main; main(['--help'])"
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout
    for command in ("compare", "replay", "render", "demo"):
        assert command in shown
