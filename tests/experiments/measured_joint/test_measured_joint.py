"""The measured joint: recordings, rivals, splits and the study."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import experiments.measured_joint.__main__ as program
from experiments.measured_joint import bouc_wen, history_network, study
from experiments.measured_joint.__main__ import measured_joint
from experiments.measured_joint.bouc_wen import fit_bouc_wen
from experiments.measured_joint.candidates import CANDIDATES
from experiments.measured_joint.direct_fit import fit_directly
from experiments.measured_joint.history_network import fit_history_network
from experiments.measured_joint.joint_model import CAPSTAN
from experiments.measured_joint.prandtl_ishlinskii import fit_prandtl_ishlinskii, play
from experiments.measured_joint.prediction import error
from experiments.measured_joint.recording import (
    ANGLE,
    COLUMNS,
    COMMAND,
    TENSIONS,
    bend,
    bound_zeros,
    degrees,
)
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT, make_splits
from experiments.measured_joint.wound_in import WoundIn
from tendon_mj import CATALOGUE, diagnose
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Uncertain
from tests.experiments.measured_joint.synthetic import FRICTION, PLANTED, UNCERTAIN, blank, rig
from tests.refusals import refusing


def test_nothing_that_is_predicted_is_given():
    splits = make_splits([blank(b, 4) for b in (0, 60, 120, 180, 240)])
    for parts in splits.values():
        for split in parts:
            assert not {r.name for r in split.train} & {r.name for r in split.held_out}
    (between,), (beyond,) = splits[BETWEEN], splits[BEYOND]
    assert [degrees(r) for r in between.held_out] == [60, 180]
    assert [degrees(r) for r in beyond.held_out] == [180, 240]
    assert sorted(degrees(s.held_out[0]) for s in splits[LEFT_OUT]) == [0, 60, 120, 180, 240]
    for bends in ((0, 60, 240), (0, 120, 240)):
        with refusing(RecordingError, "of other bends are needed"):
            make_splits([blank(b, 4) for b in bends])


def test_no_zero_of_a_load_cell_is_above_its_lowest_reading():
    zero = {"input_tension_1.offset": Uncertain(0.0, -2.0, 2.0)}
    given, unseen = (replace(blank(b, 4), uncertain={**UNCERTAIN, **zero}) for b in (0, 60))
    given = replace(given, columns={**given.columns, "tension_1_N": np.array([5.0, 0.7, 6, 5])})
    for bounded in bound_zeros([given, unseen], [given]):
        assert bounded.uncertain["input_tension_1.offset"] == Uncertain(0.0, -2.0, 0.7)
        assert bounded.uncertain.keys() == given.uncertain.keys()


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"sheath_1.friction": 0.0, "sheath_2.friction": 0.6},
        {"sheath_1.axial_stiffness": 200.0, "sheath_2.axial_stiffness": 200.0},
        {"sheath_1.sheath_compliance": 1e-3},
        {"sheath_1.creep": 0.5, "sheath_1.creep_time": 1.0},
        {"input_tension_1.offset": 1.0, "input_tension_2.scale": 0.9},
    ],
)
def test_the_first_sample_reads_what_was_recorded(changed):
    recordings = [blank(b, 8) for b in (0, 240)]
    (answers,) = WoundIn(recordings)([{**PLANTED, **changed}])
    for recording, series in zip(recordings, answers, strict=True):
        for column in TENSIONS:
            assert series[column][0] == pytest.approx(recording.columns[column][0], abs=0.05)


def test_without_friction_the_tendon_is_a_spring():
    stiffness = PLANTED["sheath_1.axial_stiffness"]
    plain = {**PLANTED, "sheath_1.friction": 0.0, "sheath_2.friction": 0.0}
    (wound,) = WoundIn([blank(120, 8)])._wind_in([plain])
    # L = 1 m, pretension 0.2 N: what was S long carries 5 N
    unstretched = 1.0 / (1.0 + 0.2 / stiffness)
    assert wound[0] == pytest.approx(unstretched - 1.0 / (1.0 + 5.0 / stiffness), rel=1e-3)


BENDS = (0, 120, 240)


def made(degrees, law, samples=240):
    """A recording all of whose columns follow a law of the command and the bend."""
    recording = blank(degrees, samples)
    series = law(recording.columns[COMMAND], bend(recording))
    return replace(recording, columns={**recording.columns, **dict.fromkeys(COLUMNS, series)})


def worst(predict, recording):
    return max(error(recording, predict(recording)).rms.values())


def play_law(command, angle):
    return (1.0 - 0.1 * angle) * play(command, 0.3) + 0.2 * command + 0.05 * angle


def bouc_wen_law(command, angle):
    scaled = command / np.radians(60.0)
    return 0.2 * scaled + (1.0 - 0.1 * angle) * bouc_wen._hysteresis(scaled, 3.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("fit", "law", "within"),
    [
        (fit_prandtl_ishlinskii, play_law, 0.02),  # plays between its own
        (fit_bouc_wen, bouc_wen_law, 0.02),
        (fit_history_network, play_law, 0.16),  # of a loop whose spread is 0.67
    ],
)
def test_a_rival_finds_a_law_between_the_given_bends(fit, law, within, monkeypatch):
    monkeypatch.setattr(bouc_wen, "_GENERATIONS", 15)
    monkeypatch.setattr(history_network, "_MEMBERS", 2)
    assert worst(fit([made(b, law) for b in BENDS]), made(60, law)) < within


FOUND = ("spool's radius", "EA", "hinge's dry friction", "μ")
FEW = tuple(n for n in CAPSTAN if n.name in FOUND)


def test_a_direct_fit_finds_planted_numbers_and_predicts_other_bends():
    result = fit_directly(FEW, rig((0, 120, 240)), 0, starts=8, refined=2)
    assert result.values["μ"] == pytest.approx(FRICTION, rel=0.05)
    assert result.values["EA"] == pytest.approx(900.0, rel=0.05)
    (unseen,) = rig((60,), seed=1)
    assert error(unseen, result(unseen)).rms[ANGLE] < 0.01


def first_of_each(recordings):
    return {name: parts[:1] for name, parts in make_splits(recordings).items()}


@pytest.mark.long
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
        (results,) = result["diagnoses"][split]
        assert results["diagnosis"]["effects"] == ["sheath_friction"]
        friction = results["diagnosis"]["parameters"]["sheath_1.friction"]["value"]
        assert friction == pytest.approx(FRICTION, rel=0.05)
        assert all(r["after"][ANGLE] < 0.5 * r["before"][ANGLE] for r in results["held_out"])
    (left_out,) = result["held_out"]["nearest curves"][LEFT_OUT]
    assert left_out["bend_deg"] == 0
    page = (tmp_path / "out" / "table.md").read_text("utf-8")
    assert "nan" not in page
    for name in ("angle", "tension", "held_out"):
        assert (tmp_path / "out" / f"{name}.png").stat().st_size > 10_000
