"""Laws of hidden cases: recordings do not reveal the key, and the ratio is the one asked for."""

import dataclasses
import json

import numpy as np
import pytest

from experiments.hidden_effects.case import make_case
from experiments.hidden_effects.plan import CasePlan
from tendon_mj.lab.recordings import read_recording
from tendon_mj.lab.replay import replay_recording

NOTHING = CasePlan(kind="nothing", names=(), target=0.0, noise=0.01, exclude=(), seed=(7, 1))
LAG = dataclasses.replace(NOTHING, kind="effect", names=("sensor_lag",), target=5.0)


@pytest.fixture(scope="module", params=[NOTHING, LAG], ids=["nothing", "sensor_lag"])
def case(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("case")
    return request.param, make_case(request.param, folder), folder


def recordings(folder):
    return [read_recording(path) for path in sorted(folder.glob("*.csv"))]


def test_the_six_recordings_of_a_case_do_not_reveal_its_key(case):
    plan, key, folder = case
    assert len(recordings(folder)) == 6
    assert json.loads((folder / "case.json").read_text()) == {"exclude": []}
    for name in plan.names:
        assert all(name not in path.read_text() for path in folder.iterdir())
    assert key["least_tension_N"] > 0.0


def test_the_strength_is_the_one_asked_for(case):
    plan, key, _ = case
    assert key["ratio"] == pytest.approx([plan.target] * len(plan.names), rel=0.1)


def test_the_same_seed_gives_the_same_case(case, tmp_path):
    plan, key, folder = case
    assert make_case(plan, tmp_path) == key
    assert recordings(tmp_path) == recordings(folder)


def test_with_nothing_hidden_the_bench_explains_the_reference_down_to_the_noise(tmp_path):
    key = make_case(NOTHING, tmp_path)
    for recording in recordings(tmp_path):
        simulated = replay_recording(recording, parameters=key["calibrated"])
        for column, measured in recording.measured.items():
            error = simulated.columns[column] - recording.columns[column]
            assert np.sqrt(np.mean(error**2)) < 1.1 * measured.noise
