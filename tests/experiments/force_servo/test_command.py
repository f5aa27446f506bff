"""`python -m experiments.force_servo` meets its figures and writes its pictures."""

import json

import pytest

from experiments.command import run_experiment
from experiments.force_servo.__main__ import force_servo


@pytest.mark.long
def test_the_study_meets_its_figures(tmp_path):
    force_servo(tmp_path)
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    steps = result["overshoot"]
    assert steps["pulling"] < 0.005
    assert steps["loosening"] == pytest.approx(steps["loosening_predicted"], rel=0.2)
    assert steps["scheduled_difference_cut"] > 0.9
    assert steps["scheduled_rise_ratio_loosening"] <= 1.0
    assert all(abs(e) < 0.02 for e in result["phase_plane"]["slope_error"].values())
    assert result["limit_cycle"]["r_squared"] > 0.98
    assert abs(result["limit_cycle"]["intercept_over_mean_amplitude"]) < 0.05
    assert result["tracking"]["rmse_reduction"] > 0.88
    for picture in ("fig6_phase_plane", "fig7_steps", "limit_cycle", "strategies"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000


def test_a_file_for_a_folder_is_refused_in_one_line(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert run_experiment(force_servo, "force_servo", ["--out", str(tmp_path / "file")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("python -m experiments.force_servo: --out ")
    assert error.count("\n") == 1
