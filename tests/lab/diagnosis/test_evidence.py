"""Evidence beside a verdict: noise, correlations, whiteness, provenance."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    Diagnosis,
    collect_provenance,
    diagnose,
    files_of,
    noise_sensitivity,
    parameter_correlations,
)
from tendon_mj.lab.diagnosis.audit import Autocorrelation, autocorrelation, with_noise
from tendon_mj.lab.recordings import write_recording
from tests.lab.diagnosis.toy import Toy, recording, rig


@cache
def named() -> Diagnosis:
    """Constant friction, found."""
    return diagnose(*rig(1, {"sheath.constant_friction": 1.0, "sheath.friction": 0.2}), Toy)


@cache
def sound() -> Diagnosis:
    """Nothing to be found."""
    return diagnose(*rig(2, {"sheath.friction": 0.2}), Toy)


def test_at_the_stated_noise_the_criteria_give_the_verdict() -> None:
    for outcome in (named(), sound()):
        sensitivity = noise_sensitivity(outcome)
        half, same, twice = sensitivity.cases
        assert same.verdict == outcome.verdict
        assert (half.factor, twice.factor) == (0.5, 2.0)
        assert half.before == pytest.approx(2.0 * same.before)
        assert twice.after == pytest.approx(0.5 * same.after)
        assert sensitivity.low <= 1.0 <= sensitivity.high


def test_above_another_noise_nothing_is_to_be_found_or_a_part_is_not_explained() -> None:
    error = named().held_out.before
    above = noise_sensitivity(named(), [1.5 * error])
    assert above.cases[0].verdict == "nothing missing"
    assert "detection limit" in above.cases[0].reason
    assert above.high < 1.5 * error
    sensitivity = noise_sensitivity(named(), [0.1])
    (case,) = sensitivity.cases
    assert case.verdict == "partly"
    assert "two thirds are required" in case.reason
    assert f"{case.after:.2f} times this noise remains, which is not explained" in case.reason
    assert sensitivity.low > 0.1
    nothing = noise_sensitivity(sound(), [0.1])
    assert nothing.cases[0].verdict is None  # who knows what a search would find
    assert "an effect would be sought" in nothing.cases[0].reason


def test_the_noise_scales_errors_and_what_the_simulation_leaves() -> None:
    evidence = named().evidence
    lumped = replace(evidence, lumping=4.0, step=1.0, limit=4.0)
    assert with_noise(lumped, 0.5).limit == pytest.approx(16.0)
    assert with_noise(lumped, 2.0).limit == pytest.approx(1.0)
    assert with_noise(lumped, 100.0).limit == pytest.approx(0.2)
    back = with_noise(with_noise(evidence, 2.0), 0.5)
    assert back.extrapolated.after == pytest.approx(evidence.extrapolated.after)
    assert back.excess == pytest.approx(evidence.excess)


def test_correlations_are_of_what_was_fitted() -> None:
    outcome = parameter_correlations(named())
    assert outcome is not None
    assert parameter_correlations(replace(named(), search=None)) is None
    assert set(outcome.names) == {"sheath.friction", "sheath.constant_friction"}
    matrix = np.array(outcome.matrix)
    np.testing.assert_allclose(np.diag(matrix), 1.0)
    np.testing.assert_array_equal(matrix, matrix.T)
    context, selection = named().search or pytest.fail("no search")
    jacobian = selection.final.fit.jacobian[context.problem.in_train]
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    expected = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert matrix[0, 1] == pytest.approx(expected)
    one, other, coefficient = outcome.high[0]
    assert {one, other} == set(outcome.names)
    assert coefficient == pytest.approx(matrix[0, 1], rel=1e-12)


def test_white_noise_is_white_and_a_wave_is_not() -> None:
    random = np.random.default_rng(1)
    time = np.arange(2000) * 0.01
    noise = autocorrelation(time, random.normal(0.0, 2.0, time.size))
    assert noise.white
    assert noise.lags[0] == pytest.approx(0.01)
    assert noise.band == pytest.approx(1.96 / np.sqrt(2000))
    wave = autocorrelation(time, np.sin(2.0 * np.pi * time))
    assert not wave.white
    assert wave.values[24] == pytest.approx(0.0, abs=0.02)  # a quarter of the period
    assert wave.values[0] == pytest.approx(np.cos(2.0 * np.pi * 0.01), abs=0.01)
    for count, inside in ((40, 34), (5, 3)):  # white noise has fewer in 1 of 100
        for within in (inside, inside - 1):
            values = np.repeat([0.0, 1.0], (within, count - within))
            assert Autocorrelation(time[:count], values, 0.5).white == (within == inside)
    still = autocorrelation(np.arange(20.0), np.full(20, 3.0))
    np.testing.assert_array_equal(still.values, 0.0)
    assert still.lags.size == 5  # a quarter of the samples


def test_provenance_tells_versions_date_and_the_bytes_of_files(tmp_path: Path) -> None:
    file = tmp_path / "slow.csv"
    file.write_bytes(b"time_s\n")
    outcome = collect_provenance("tendon-mj diagnose slow.csv", [file])
    assert outcome.files == {str(file): hashlib.sha256(b"time_s\n").hexdigest()}
    assert {"python", "mujoco", "numpy", "tendon-mj"} <= outcome.versions.keys()
    assert outcome.result()["command"] == "tendon-mj diagnose slow.csv"
    assert outcome.date[:2] == "20"


@pytest.mark.parametrize("given", ["slow.csv", "slow.toml", "slow"])
def test_the_files_of_a_recording_are_its_data_its_description_and_its_model(
    given: str, tmp_path: Path
) -> None:
    made = recording("slow", 1, {})
    write_recording(made, tmp_path / "slow.csv")
    outcome = files_of([tmp_path / given], None, [made, made])
    assert [file.name for file in outcome] == ["slow.csv", "slow.toml", "bench.xml"]
    assert all(file.is_file() for file in outcome)
    other = files_of([tmp_path / given], tmp_path / "rig.toml", [])
    assert [file.name for file in other] == ["slow.csv", "rig.toml"]
