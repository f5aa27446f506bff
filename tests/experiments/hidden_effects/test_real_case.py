"""Laws of cases that have what reality has: their recordings hold just what their keys say."""

import dataclasses

import numpy as np
import pytest

from experiments.hidden_effects.case import make_case
from experiments.hidden_effects.plan import CasePlan
from tendon_mj.lab.recordings import read_recording
from tendon_mj.lab.replay import Simulator, replay_recording
from tendon_mj.models import load_model

QUIET = CasePlan(
    kind="session", names=(), target=0.0, noise=0.01, exclude=(), seed=(7, 1), bends=True
)
ASYMMETRIC = dataclasses.replace(
    QUIET, names=("direction_asymmetry",), target=5.0, noise=0.001, bends=False
)
REMAINDER = dataclasses.replace(
    ASYMMETRIC, kind="remainder", small=("sensor_drift", "sensor_hum"), exclude=("sensor_drift",)
)
TOO_HIGH = dataclasses.replace(
    QUIET, kind="too_high", names=("constant_friction",), target=5.0, bends=False
)


def recordings(folder):
    return [read_recording(path) for path in sorted(folder.glob("*.csv"))]


def explained(recording, parameters):
    """Whether a simulation with these parameters leaves no more than noise."""
    simulated = replay_recording(recording, parameters=parameters)
    errors = [
        (simulated.columns[column] - recording.columns[column]) / measured.noise
        for column, measured in recording.measured.items()
    ]
    return np.sqrt(np.mean(np.square(errors))) < 1.1


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    folder = tmp_path_factory.mktemp("quiet")
    return make_case(QUIET, folder), recordings(folder)


def test_sessions_are_explained_by_what_each_has_of_its_own_and_not_without(quiet):
    key, made = quiet
    shared = key["calibrated"]
    assert all(explained(r, {**shared, **key["sessions"][r.name]}) for r in made)
    assert not all(explained(r, shared) for r in made)


def test_recordings_of_sessions_state_the_spread_of_zeros_and_pretension_and_know_the_bend(quiet):
    key, made = quiet
    wanted = {"sheath.pretension", "input_tension.offset", "output_tension.offset"}
    for recording in made:
        assert recording.session.keys() == wanted
        own = key["sessions"][recording.name]
        assert recording.known["sheath.extra_bend"] == own["sheath.extra_bend"]
        for name, stated in recording.session.items():
            assert abs(own[name] - stated.value) < 5.0 * stated.spread  # guesses, by a factor of 2
    assert len({r.known["sheath.extra_bend"] for r in made}) == len(made)


def test_among_sessions_the_strength_is_a_multiple_of_how_much_they_differ(tmp_path):
    key = make_case(ASYMMETRIC, tmp_path)
    assert key["ratio"] == pytest.approx([5.0 * key["unit"]], rel=0.1)
    assert key["unit"] > max(1.0, key["left"])


def test_above_a_remainder_the_strength_is_a_multiple_of_what_remains(tmp_path):
    key = make_case(REMAINDER, tmp_path)
    assert key["ratio"] == pytest.approx([5.0 * key["unit"]], rel=0.1)
    assert key["unit"] >= max(1.0, *key["small"].values())
    assert key["small"].keys() == set(REMAINDER.small)


def test_a_number_too_high_is_in_the_model_and_the_true_one_explains_the_recordings(tmp_path):
    key = make_case(TOO_HIGH, tmp_path)
    ((name, true),) = key["parameters"].items()
    first, *_ = made = recordings(tmp_path)
    assert Simulator(made).parameters[name].value == key["model"][name] > true
    assert all(explained(r, {**key["calibrated"], name: true}) for r in made)
    assert not explained(first, key["calibrated"])


def test_the_model_of_a_case_lies_beside_its_recordings_and_says_nothing_of_the_key(tmp_path):
    make_case(TOO_HIGH, tmp_path / "here")
    text = (tmp_path / "here" / "model.xml").read_text()
    assert "<!--" not in text
    moved = (tmp_path / "here").rename(tmp_path / "there")
    assert load_model(recordings(moved)[0].model).nu > 0
