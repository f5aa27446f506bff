"""Laws of hidden ties: what is hidden has the strength asked for, and the rig is in its state."""

import dataclasses

import numpy as np
import pytest

from experiments.hidden_effects.references import ReferenceBench
from experiments.next_experiment.case import Case, make
from experiments.next_experiment.rig import (
    DRIVE,
    DURATION,
    KNOWN,
    LOWEST,
    NOISE,
    PRETENSION,
    RATE,
    Description,
    poor_drive,
    record,
    run,
)
from experiments.next_experiment.settle import draw_experiment
from experiments.next_experiment.study import Settled, SettledCases
from experiments.next_experiment.table import table
from tendon_mj.lab.recordings import read_recording, write_recording

CASE = Case(hidden="sensor_bias", motion="triangle", sensors="output", ratio=3.0, seed=900)
COLUMN = "output_tension_N"
DESCRIBED = Description(sensors=(COLUMN,), known=KNOWN, uncertain={})


@pytest.fixture(scope="module")
def rig():
    return make(CASE)


def test_the_effect_has_the_strength_asked_for_and_the_recording_does_not_tell(rig, tmp_path):
    assert rig.ratio == pytest.approx(CASE.ratio, rel=0.1)
    write_recording(rig.train, tmp_path / "slow")
    assert read_recording(tmp_path / "slow") == rig.train
    assert CASE.hidden not in (tmp_path / "slow.toml").read_text("utf-8")
    assert rig.train.measured.keys() == {COLUMN}


@pytest.mark.parametrize("motion", ["sine", "triangle"])
def test_a_poor_drive_has_one_speed_and_one_amplitude(motion):
    drive = poor_drive(motion, 0.5e-3)
    assert drive.size == round(DURATION * RATE)
    assert drive[0] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(drive).max() == pytest.approx(0.5e-3, rel=1e-2)
    assert np.abs(np.diff(drive)).max() * RATE == pytest.approx(1e-3, rel=1e-2)


def test_an_experiment_is_run_in_the_state_that_it_asks_for():
    random, rig = np.random.default_rng(0), ReferenceBench()
    slow = record(rig, "slow", poor_drive("sine", 0.3e-3), DESCRIBED, random)
    tight = run(rig, dataclasses.replace(slow, known={**KNOWN, PRETENSION: 30.0}), random)
    assert tight is not None
    assert tight.known[PRETENSION] == 30.0
    assert np.median(tight.columns[COLUMN] - slow.columns[COLUMN]) > 5.0 * NOISE
    assert np.array_equal(tight.columns[DRIVE], slow.columns[DRIVE])


def test_what_would_leave_the_limits_is_not_run():
    random, rig = np.random.default_rng(0), ReferenceBench()
    slow, slack = (
        record(rig, "slow", -poor_drive("sine", amplitude), DESCRIBED, random)
        for amplitude in (0.5e-3, 5e-3)
    )
    assert slack.columns[COLUMN].min() < LOWEST < slow.columns[COLUMN].min()
    assert run(rig, slow, random) is not None
    assert run(rig, slack, random) is None


def test_random_experiments_are_of_the_same_length(rig):
    drawn = [draw_experiment([rig.train], DESCRIBED.bounds, seed).recording for seed in range(5)]
    assert all(r.time.size == rig.train.time.size for r in drawn)
    assert len({r.known[PRETENSION] for r in drawn}) == 5


def test_the_table_counts_ties_only():
    settled, open_one = (
        {"settled": s, "experiment": "", "verdict": "named", "effects": []} for s in (1, 0)
    )
    case = {"hidden": "a", "motion": "sine", "sensors": "output", "ratio": 3.0, "seed": 1}
    tie = {"case": case, "tie": True, "ties": [["a", "b"]], "differences": [], "seconds": 3.0}
    given = {"suggested": settled, "random": [settled, open_one]}
    none = {"suggested": None, "random": [open_one, open_one]}
    text = table([{**tie, **given}, {**tie, **none}, {"tie": False}])
    assert "| settled by the suggested experiment, of these | 1 of 1, 100% |" in text
    assert "| settled by a random one, of these | 1 of 2, 50% |" in text
    assert "| settled by the suggested experiment, of all ties | 1 of 2, 50% |" in text


def test_what_other_code_settled_is_settled_again(tmp_path):
    SettledCases(tmp_path, 2).write("new", Settled({"verdict": "named"}, "new"))
    (tmp_path / "old.json").write_text('{"verdict": "named", "of": {"tendon_mj": "sources 0"}}')
    assert SettledCases(tmp_path, 2).done() == {"new"}
