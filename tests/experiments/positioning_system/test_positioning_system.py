"""The three descriptions say the same of one motion, and the experiment finds what was planted."""

from __future__ import annotations

import json
import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import experiments.positioning_system.__main__ as program
import experiments.positioning_system.study as study
from experiments.positioning_system import published
from experiments.positioning_system.__main__ import positioning_system
from experiments.positioning_system.descriptions import NAMES, describe
from experiments.positioning_system.measurement import Measurement, read_measurement
from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis import CATALOGUE, diagnose
from tendon_mj.lab.replay import Simulator
from tests.experiments.positioning_system.synthetic import synthetic
from tests.refusals import refusing

FEW = ("joint_damping", "joint_friction", "sensor_gain")
TRUTH = {**published.PARAMETERS, "gravity.x": 0.0}


@pytest.fixture(scope="module")
def measurement() -> Measurement:
    return synthetic()


def test_the_servo_s_gains_are_read_off_the_columns(measurement: Measurement) -> None:
    stiffness, damping, left = measurement.servo_gains()
    assert stiffness == pytest.approx(published.SERVO_STIFFNESS, rel=0.02)
    assert damping == pytest.approx(published.SERVO_DAMPING, rel=0.05)
    assert left < 2.0


def test_what_does_not_repeat_from_cycle_to_cycle_is_the_noise() -> None:
    random, time = np.random.default_rng(1), np.arange(0.0, 12.0, 1e-3)
    cycle = np.sin(np.pi * time)
    noisy = (cycle + random.normal(0.0, noise, time.size) for noise in (0.02, 0.3))
    result = Measurement(time, cycle, *noisy).reproducibility()
    assert result == pytest.approx((0.02, 0.3), rel=0.05)
    with refusing(RecordingError, "less than twice"):
        Measurement(time, time, time, time).reproducibility()


def test_the_truth_explains_one_motion_however_it_is_described(measurement: Measurement) -> None:
    for name, recording in describe(measurement).items():
        plain, true = Simulator([recording])([{}, TRUTH])
        for column, series in true[0].items():
            measured = recording.columns[column]
            left, wrong = (np.std(s - measured) for s in (series, plain[0][column]))
            assert left < 0.2 * wrong, (name, column)


def test_friction_and_damping_are_named_and_everything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measurement: Measurement
) -> None:
    few = [CATALOGUE[name] for name in FEW]
    monkeypatch.setattr(program, "read_measurement", lambda path: measurement)
    monkeypatch.setattr(study, "diagnose", partial(diagnose, catalogue=few))
    monkeypatch.setattr(study, "sysid_is_there", lambda: False)
    only = {"motion": describe(measurement)["motion"]}
    monkeypatch.setattr(study, "describe", lambda measurement: only)
    positioning_system(tmp_path, tmp_path / "out")
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    results = result["described"]["motion"]["diagnosis"]
    assert {"joint_damping", "joint_friction"} <= set(results["effects"])
    assert results["verdict"] in ("named", "partly")
    for parameter in ("screw.damping", "screw.frictionloss"):
        told = published.PARAMETERS[parameter]
        assert results["parameters"][parameter]["value"] == pytest.approx(
            told, rel=published.WITHIN
        )
    assert NAMES["motion"] in (tmp_path / "out" / "table.md").read_text("utf-8")
    for name in ("friction", "residual"):
        assert (tmp_path / "out" / f"{name}.png").stat().st_size > 10_000


def test_the_published_model_explains_the_measured_file() -> None:
    file = Path(os.environ.get("TENDON_MJ_DATA", "")) / "positioning_system" / "emps.csv"
    if "TENDON_MJ_DATA" not in os.environ or not file.is_file():
        pytest.skip("TENDON_MJ_DATA names no folder with positioning_system (see docs/data.md)")
    measured = read_measurement(file)
    stiffness, damping, _ = measured.servo_gains()
    assert stiffness / damping == pytest.approx(published.POSITION_GAIN, rel=0.01)
    recording = describe(measured)["motion"]
    (answer,) = Simulator([recording])([published.PARAMETERS])[0]
    force = recording.columns["motor_force_N"]
    assert np.std(answer["motor_force_N"] - force) < 0.1 * np.std(force)
