"""Planted friction comes back, by a direct fit and by the whole command; missing data are told."""

import json
from functools import partial

import numpy as np
import pytest

import experiments.measured_joint.__main__ as program
from experiments.command import run_experiment
from experiments.measured_joint import study
from experiments.measured_joint.__main__ import measured_joint
from experiments.measured_joint.candidates import CANDIDATES
from experiments.measured_joint.direct_fit import fit_directly
from experiments.measured_joint.joint_model import CAPSTAN, Number, values_in
from experiments.measured_joint.prediction import error
from experiments.measured_joint.recording import ANGLE
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT, make_splits
from tendon_mj import CATALOGUE, diagnose
from tests.experiments.measured_joint.synthetic import FRICTION, blank, rig

FOUND = ("spool's radius", "EA", "hinge's dry friction", "μ")
FEW = tuple(n for n in CAPSTAN if n.name in FOUND)


def test_a_direct_fit_finds_planted_numbers_and_predicts_other_bends():
    found = fit_directly(FEW, rig((0, 120, 240)), 0, starts=8, refined=2)
    assert found.values["μ"] == pytest.approx(FRICTION, rel=0.05)
    assert found.values["EA"] == pytest.approx(900.0, rel=0.05)
    (unseen,) = rig((60,), seed=1)
    assert error(unseen, found(unseen)).rms[ANGLE] < 0.01


def test_numbers_of_one_parameter_add_up_and_may_grow_with_the_bend():
    base = Number("F", ("joint.frictionloss",), 0.0, 0.1)
    growing = Number("F per rad", ("joint.frictionloss",), 0.0, 0.1, per_bend=True)
    values = values_in((base, growing), (0.5, 0.2), [blank(0, 4), blank(180, 4)])
    assert values["joint.frictionloss @ bend_000deg"] == pytest.approx(0.05)
    assert values["joint.frictionloss @ bend_180deg"] == pytest.approx(0.05 + 0.02 * np.pi)


def first_of_each(recordings):
    return {name: parts[:1] for name, parts in make_splits(recordings).items()}


def test_the_command_finds_planted_friction_and_writes_everything(tmp_path, monkeypatch):
    recordings = rig((0, 60, 120, 180, 240), samples=50)
    quick = tuple(c for c in CANDIDATES if c.name in ("Prandtl–Ishlinskii", "nearest curves"))
    catalogue = [CATALOGUE["sheath_friction"]]
    monkeypatch.setattr(study, "diagnose", partial(diagnose, catalogue=catalogue))
    monkeypatch.setattr(
        study.run_study, "__defaults__", (*study.run_study.__defaults__[:-1], quick)
    )
    monkeypatch.setattr(study, "make_splits", first_of_each)
    monkeypatch.setattr(program, "read_folder", lambda folder: recordings)
    measured_joint(tmp_path, tmp_path / "out")
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    for split in (BETWEEN, BEYOND):
        (found,) = result["diagnoses"][split]
        assert found["diagnosis"]["effects"] == ["sheath_friction"]
        friction = found["diagnosis"]["parameters"]["sheath_1.friction"]["value"]
        assert friction == pytest.approx(FRICTION, rel=0.05)
        assert all(r["after"][ANGLE] < 0.5 * r["before"][ANGLE] for r in found["held_out"])
    (left_out,) = result["held_out"]["nearest curves"][LEFT_OUT]
    assert left_out["bend_deg"] == 0
    page = (tmp_path / "out" / "table.md").read_text("utf-8")
    assert "nan" not in page
    for name in ("angle", "tension", "held_out"):
        assert (tmp_path / "out" / f"{name}.png").stat().st_size > 10_000


def test_missing_data_are_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("TENDON_MJ_DATA", raising=False)
    assert run_experiment(measured_joint, "measured_joint", ["--out", str(tmp_path / "out")]) == 2
    assert "set TENDON_MJ_DATA" in capsys.readouterr().err
    monkeypatch.setenv("TENDON_MJ_DATA", str(tmp_path))
    assert run_experiment(measured_joint, "measured_joint", ["--out", str(tmp_path / "out")]) == 2
    error_line = capsys.readouterr().err
    assert "holds no CSV file" in error_line
    assert error_line.count("\n") == 1
    assert not (tmp_path / "out").exists()
