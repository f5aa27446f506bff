"""`python -m experiments.cable_tool` writes what its README lists, and tells missing data."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

import experiments.cable_tool.__main__ as program
from experiments.cable_tool.__main__ import cable_tool
from experiments.cable_tool.candidates import CANDIDATES, CHOSEN
from experiments.cable_tool.cross_validation import cross_validate
from experiments.cable_tool.recording import read_folder
from experiments.cable_tool.report import TORQUE_ASKED
from experiments.command import run_experiment
from tests.experiments.cable_tool.synthetic import suite


def test_everything_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(program, "read_folder", lambda folder: suite())
    cable_tool(tmp_path, tmp_path / "out", resamples=2)
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    assert len(result["numbers"]) == 8
    assert set(result["held_out"]) == {candidate.name for candidate in CANDIDATES}
    assert result["held_out"][CHOSEN]["pose"]["groups"]["pitch"]["torque"]["mean"] < 3e-3
    assert len(result["held_out"][CHOSEN]["load"]["recordings"]) == len(suite())
    assert {share["pose"] for share in result["load_share"]} == {r.pose for r in suite()}
    page = (tmp_path / "out" / "table.md").read_text("utf-8")
    assert "published neural network" in page
    assert "nan" not in page
    for name in ("sheath_friction", "prediction", "held_out", "residual"):
        assert (tmp_path / "out" / f"{name}.png").stat().st_size > 10_000


def test_missing_data_are_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("TENDON_MJ_DATA", raising=False)
    assert run_experiment(cable_tool, "cable_tool", ["--out", str(tmp_path / "out")]) == 2
    assert "set TENDON_MJ_DATA" in capsys.readouterr().err
    monkeypatch.setenv("TENDON_MJ_DATA", str(tmp_path))
    assert run_experiment(cable_tool, "cable_tool", ["--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert "holds no CSV file" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.long
def test_loads_and_poses_left_out_of_the_measured_data_meet_what_was_asked():
    folder = Path(os.environ.get("TENDON_MJ_DATA", "")) / "cable_tool"
    if "TENDON_MJ_DATA" not in os.environ or not folder.is_dir():
        pytest.skip("TENDON_MJ_DATA names no folder with cable_tool (see docs/data.md)")
    recordings = read_folder(folder)
    chosen = next(c for c in CANDIDATES if c.name == CHOSEN)
    for left_out, groups in (("load", ("straight",)), ("pose", ("pitch", "roll"))):
        errors = cross_validate(chosen, recordings, left_out)
        for group in groups:
            mine = [one.torque for one in errors if one.group == group]
            assert np.mean(mine) < TORQUE_ASKED, group
