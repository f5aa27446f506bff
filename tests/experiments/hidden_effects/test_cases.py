"""Laws of hidden cases: recordings do not reveal the key and hold just what it says."""

import dataclasses
import json

import numpy as np
import pytest

from experiments.hidden_effects.case import make_case
from experiments.hidden_effects.excitation import Sensor
from experiments.hidden_effects.plan import CasePlan
from experiments.hidden_effects.strengths import calibration_projector
from tendon_mj.lab.recordings import read_recording
from tendon_mj.lab.replay import Simulator, replay_recording
from tendon_mj.models import load_model

NOTHING = CasePlan(kind="nothing", names=(), target=0.0, noise=0.01, exclude=(), seed=(7, 1))
LAG = dataclasses.replace(NOTHING, kind="effect", names=("sensor_lag",), target=5.0)
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


def test_calibration_removes_the_projection_on_its_sensitivities_and_nothing_else():
    rng = np.random.default_rng(0)
    along, other = rng.normal(size=(2, 50))
    left = calibration_projector([along])
    assert left(3.0 * along) == pytest.approx(np.zeros(50), abs=1e-12)
    assert left(other) @ along == pytest.approx(0.0, abs=1e-12)


def test_lag_and_delay_shift_a_ramp_by_their_time():
    time = np.linspace(0.0, 1.0, 1001)
    for sensor in (Sensor(lag=0.02), Sensor(delay=0.02)):
        late = sensor.read(time, 5.0 * time, time)[500:]
        assert late == pytest.approx(5.0 * (time[500:] - 0.02), abs=1e-6)


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


def explained(recording, parameters):
    """Whether a simulation with these parameters leaves no more than noise."""
    simulated = replay_recording(recording, parameters=parameters)
    errors = [
        (simulated.columns[column] - recording.columns[column]) / measured.noise
        for column, measured in recording.measured.items()
    ]
    return np.sqrt(np.mean(np.square(errors))) < 1.1


def test_with_nothing_hidden_the_bench_explains_the_reference_down_to_the_noise(tmp_path):
    key = make_case(NOTHING, tmp_path)
    assert all(explained(recording, key["calibrated"]) for recording in recordings(tmp_path))


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    folder = tmp_path_factory.mktemp("quiet")
    return make_case(QUIET, folder), recordings(folder)


def test_sessions_are_explained_by_what_each_has_of_its_own_and_not_without(quiet):
    key, made = quiet
    shared = key["calibrated"]
    assert all(explained(r, {**shared, **key["sessions"][r.name]}) for r in made)
    assert not all(explained(r, shared) for r in made)


@pytest.mark.parametrize("plan", [ASYMMETRIC, REMAINDER], ids=["sessions", "remainder"])
def test_the_strength_is_a_multiple_of_how_much_sessions_differ_or_of_what_remains(plan, tmp_path):
    key = make_case(plan, tmp_path)
    assert key["ratio"] == pytest.approx([5.0 * key["unit"]], rel=0.1)
    others = key["small"] if plan.small else {"left": key["left"]}
    assert not plan.small or others.keys() == set(plan.small)
    assert key["unit"] >= max(1.0, *others.values())


def test_a_number_too_high_is_in_the_model_and_the_true_one_explains_the_recordings(tmp_path):
    key = make_case(TOO_HIGH, tmp_path)
    ((name, true),) = key["parameters"].items()
    first, *_ = made = recordings(tmp_path)
    assert Simulator(made).parameters[name].value == key["model"][name] > true
    assert all(explained(r, {**key["calibrated"], name: true}) for r in made)
    assert not explained(first, key["calibrated"])
    assert "<!--" not in (tmp_path / "model.xml").read_text()  # it says nothing of the key
    moved = tmp_path.rename(tmp_path.with_name("moved"))
    assert load_model(recordings(moved)[0].model).nu > 0
