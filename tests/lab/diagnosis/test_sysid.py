"""Fits of mujoco.sysid on a rig whose parameters are known."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import fit_with_sysid, sysid_is_there
from tendon_mj.lab.recordings import Uncertain
from tests.lab.diagnosis.toy import COLUMNS, NOISE, Toy, recording
from tests.refusals import refusing

needs_sysid = pytest.mark.skipif(not sysid_is_there(), reason="mujoco.sysid lacks its extras")

FRICTION, CONSTANT = "sheath.friction", "sheath.constant_friction"
UNCERTAIN = {FRICTION: Uncertain(0.15, 0.05, 0.4), CONSTANT: Uncertain(0.0, -3.0, 3.0)}
TRUTH = {FRICTION: 0.2, CONSTANT: 1.0}


def record(seed, extra=0.0, uncertain=UNCERTAIN, **more):
    made = recording(f"toy_{seed}", seed, TRUTH, extra)
    return replace(made, uncertain=uncertain, **more)


def spoilt(made, error, rows=slice(None)):
    """The recording with an error [N] in some rows of its readings."""
    columns = {column: series.copy() for column, series in made.columns.items()}
    for column in COLUMNS:
        columns[column][rows] += error
    return replace(made, columns=columns)


@needs_sysid
def test_what_was_planted_is_recovered_down_to_the_noise():
    seen = []

    def progress(label, done, total):
        seen.append((label, done <= total, done == total))

    result = fit_with_sysid([record(1), record(2)], [record(3)], progress, simulator=Toy)
    for name, truth in TRUTH.items():
        value, low, high = result.values[name]
        assert value == pytest.approx(truth, rel=0.02)
        assert low < value < high
    assert result.train_rms == pytest.approx(1.0, abs=0.1)
    assert result.held_out_rms == pytest.approx(1.0, abs=0.1)
    assert result.signals == pytest.approx(dict.fromkeys(COLUMNS, NOISE), rel=0.1)
    assert {step[:2] for step in seen} == {("mujoco.sysid", True)}
    assert seen[-1][2]


@needs_sysid
def test_values_stay_in_the_ranges_of_the_recordings_and_without_any_nothing_is_fitted():
    narrow = UNCERTAIN | {FRICTION: Uncertain(0.1, 0.05, 0.15)}
    result = fit_with_sysid([record(1, uncertain=narrow)], [record(2)], simulator=Toy)
    for name, (value, low, high) in result.values.items():
        assert narrow[name].low <= low <= value <= high <= narrow[name].high
    assert result.values[FRICTION][0] == pytest.approx(0.15, rel=1e-3)
    result = fit_with_sysid([record(1, uncertain={})], [record(2, uncertain={})], simulator=Toy)
    assert result.values == {}
    assert "nothing was fitted" in result.note


@needs_sysid
def test_what_the_model_lacks_stays_in_the_error():
    result = fit_with_sysid([record(1, 1.0), record(2, 1.0)], [record(3, 1.0)], simulator=Toy)
    assert result.held_out_rms == pytest.approx(np.sqrt(0.5) / NOISE, rel=0.1)


@needs_sysid
def test_without_a_hold_out_the_tails_are_kept_from_the_fit():
    made = record(1)
    tail = spoilt(made, 50.0 * NOISE, slice(-130, None))
    result, clean = (fit_with_sysid([one], simulator=Toy) for one in (tail, made))
    assert result.values == clean.values
    assert result.train_rms == clean.train_rms
    assert result.held_out_rms > 10.0 * clean.held_out_rms


@needs_sysid
def test_of_different_states_each_is_predicted_by_a_fit_to_the_others():
    three = [record(k, known={"rig.bend": float(k)}) for k in (1, 2, 3)]
    assert fit_with_sysid(three, simulator=Toy).held_out_rms == pytest.approx(1.0, abs=0.1)
    off = fit_with_sysid([*three[:2], spoilt(three[2], 50.0 * NOISE)], simulator=Toy)
    assert off.held_out_rms > 50.0 / np.sqrt(3.0)  # the fit has not seen it
    assert off.train_rms < off.held_out_rms


def test_without_its_extras_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setattr(mujoco, "sysid", SimpleNamespace(), raising=False)
    with refusing(TendonError, "pip install 'tendon-mj[sysid]'"):
        fit_with_sysid([record(1)], simulator=Toy)
