"""Laws of hidden cases: recordings do not reveal the key, and the ratio is the one asked for."""

import dataclasses
import json

import numpy as np
import pytest

from experiments.hidden_effects.references.sensor import Sensor
from experiments.hidden_effects.scoring.judged_case import JudgedCase
from experiments.hidden_effects.scoring.suite_statistics import confusion, table
from experiments.hidden_effects.suite.case import make_case
from experiments.hidden_effects.suite.case_plan import CasePlan
from experiments.hidden_effects.suite.plan_suite import SINGLE_EFFECTS, plan_suite
from experiments.hidden_effects.suite.strength_search import calibration_projector, find_strength
from tendon_mj.recordings import read_recording
from tendon_mj.replay import replay_recording

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


def test_a_suite_holds_every_effect_at_every_strength_once():
    suite = plan_suite(3, ("effect",), (2.0, 5.0), (0.01,), 1, 0, 0)
    assert sorted((p.names[0], p.target) for p in suite) == sorted(
        (e, s) for e in SINGLE_EFFECTS for s in (2.0, 5.0)
    )
    assert len({p.seed for p in suite}) == len(suite)


def test_calibration_removes_the_projection_on_its_sensitivities_and_nothing_else():
    rng = np.random.default_rng(0)
    along, other = rng.normal(size=(2, 50))
    left = calibration_projector([along])
    assert left(3.0 * along) == pytest.approx(np.zeros(50), abs=1e-12)
    assert left(other) @ along == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("power", [0.5, 1.0, 3.0])
def test_the_search_finds_a_strength_or_says_that_the_range_ends(power):
    found = find_strength(lambda s: 7.0 * s**power, 2.0, 1e-4, 10.0, 1.0)
    assert found.reached
    assert 7.0 * found.strength**power == pytest.approx(2.0, rel=0.1)
    assert not find_strength(lambda s: 7.0 * s**power, 2.0, 1e-4, 0.01, 0.001).reached


def test_lag_and_delay_shift_a_ramp_by_their_time():
    time = np.linspace(0.0, 1.0, 1001)
    for sensor in (Sensor(lag=0.02), Sensor(delay=0.02)):
        late = sensor.read(time, 5.0 * time)[500:]
        assert late == pytest.approx(5.0 * (time[500:] - 0.02), abs=1e-6)


KEY = {
    "kind": "effect",
    "hidden": ["creep"],
    "target": 5.0,
    "reached": True,
    "parameters": {"sheath.creep": 0.2},
}
RESULT = {
    "verdict": "named",
    "effects": ["creep"],
    "indistinguishable": [],
    "confidence": 0.97,
    "parameters": {"sheath.creep": {"value": 0.21, "low": 0.19, "high": 0.23, "unit": "-"}},
    "gap": {"held_out": {"reducible_closed": 0.98}},
}


def judged(key=None, **result):
    return JudgedCase("case", {**KEY, **(key or {})}, {**RESULT, **result}, 1.0)


def test_a_hit_counts_one_a_tie_a_half_and_a_wrong_name_nothing():
    assert judged().hit == 1.0
    assert judged(indistinguishable=[["creep", "stiffening"]]).hit == 0.5
    assert judged(effects=["stiffening"]).hit == 0.0
    assert judged(effects=["stiffening", "creep"]).hit == 0.0
    assert judged(effects=["stiffening", "creep"]).contains
    assert judged(verdict="unknown", effects=[]).hit == 0.0


def test_a_false_name_is_one_where_nothing_is_hidden():
    nothing = {"kind": "nothing", "hidden": []}
    assert judged(nothing).named_effect
    assert not judged(nothing, verdict="nothing missing", effects=[]).named_effect
    assert not judged(nothing, verdict="parameter", effects=["friction"]).named_effect


def test_errors_are_relative_and_intervals_cover_or_not():
    [(name, error, covered)] = judged().errors()
    assert (name, covered) == ("sheath.creep", True)
    assert error == pytest.approx(0.05)


def test_the_table_and_the_matrix_count_every_case():
    cases = [judged(), judged(effects=["stiffening"]), judged({"kind": "nothing", "hidden": []})]
    rows = {quantity: (figure, count) for quantity, _, figure, count in table(cases)}
    assert rows["one effect, residual ≥ 5 noise: first (tie: half)"] == ("50.0 %", 2)
    assert rows["nothing hidden: false name"] == ("100.0 %", 1)
    _, matrix = confusion(cases)
    assert sum(sum(row.values()) for row in matrix.values()) == len(cases)
