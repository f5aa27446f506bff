"""Laws of hidden ties: what is hidden has the strength asked for, and the rig is in its state."""

import dataclasses

import numpy as np
import pytest

from experiments.hidden_effects.references import ReferenceBench
from experiments.next_experiment.case import Case, make
from experiments.next_experiment.rig import (
    DRIVE,
    KNOWN,
    LOWEST,
    NOISE,
    PRETENSION,
    Description,
    poor_drive,
    record,
    run,
)
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
