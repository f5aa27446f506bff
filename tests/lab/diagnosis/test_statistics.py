"""Cross-validation and intervals, where the exact answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tendon_mj.lab.diagnosis import Candidate, Fit, Problem, Term, all_samples, fit, intervals
from tendon_mj.lab.diagnosis.proof import parameters_beyond_range
from tendon_mj.lab.diagnosis.statistics import beyond_range, cross_validate
from tendon_mj.lab.diagnosis.thresholds import reducible_excess
from tests.lab.diagnosis.linear_rig import BLOCKS, Shape, context, effect
from tests.lab.diagnosis.toy import Toy, recording

TERM = Term(("sheath.constant_friction",), "N", 0.0, -50.0, 50.0, 1.0)
SLOPE = Term(("sheath.friction_drift",), "1/s", 0.0, -50.0, 50.0, 1.0)


def problem(seed: int = 0) -> Problem:
    made = (recording("a", seed, {}), recording("b", seed + 1, {}))
    return Problem(made, Toy(made), all_samples(made))


def linear(data: Problem, jacobian: np.ndarray, noise: np.ndarray) -> Fit:
    """The least-squares fit of noise by the columns of a matrix."""
    solution = np.linalg.lstsq(jacobian, -noise, rcond=None)[0]
    bounds = np.array([[-50.0, -50.0], [50.0, 50.0]])
    left = noise + jacobian @ solution
    nothing = np.zeros(left.size)
    return Fit((TERM, SLOPE), (), solution, left, nothing, jacobian, solution, bounds)


def test_cross_validation_of_a_linear_model_is_that_of_refits() -> None:
    data = problem()
    random = np.random.default_rng(1)
    size = data.blocks.size
    jacobian, noise = random.normal(size=(size, 2)), random.normal(size=size)
    found = cross_validate(data, linear(data, jacobian, noise))
    for block, chi2 in zip(np.unique(data.blocks), found.chi2, strict=True):
        inside = data.blocks == block
        refit = np.linalg.lstsq(jacobian[~inside], -noise[~inside], rcond=None)[0]
        left = noise[inside] + jacobian[inside] @ refit
        assert chi2 == pytest.approx(float(left @ left), rel=1e-6)


def test_beside_a_non_smooth_effect_no_block_is_left_out() -> None:
    data = problem()
    random = np.random.default_rng(1)
    size = data.blocks.size
    fitted = linear(data, random.normal(size=(size, 2)), random.normal(size=size))
    effect = Candidate("drift", "missing", "sheath", (SLOPE,), non_smooth=True)
    found = cross_validate(data, replace(fitted, calibrated=(TERM,), effects=(effect,)))
    assert found.excess == pytest.approx(float(np.mean(fitted.residual**2)) - 1.0)
    assert found.excess < cross_validate(data, fitted).excess


def test_cross_validated_noise_has_no_excess() -> None:
    data = problem()
    random = np.random.default_rng(2)
    size = data.blocks.size
    excesses = [
        cross_validate(
            data, linear(data, random.normal(size=(size, 2)), random.normal(size=size))
        ).excess
        for _ in range(20)
    ]
    assert abs(np.mean(excesses)) < 3.0 * np.std(excesses) / np.sqrt(20.0) + 4.0 / size


@pytest.mark.parametrize("correlated", [False, True])
def test_intervals_cover_though_residuals_are_correlated(correlated: bool) -> None:
    data = problem()
    random = np.random.default_rng(3)
    size = data.blocks.size
    covered = 0
    for _ in range(200):
        jacobian, noise = random.normal(size=(size, 2)), random.normal(size=size)
        if correlated:  # over a tenth of a second
            window = np.ones(10) / np.sqrt(10.0)
            jacobian = np.apply_along_axis(np.convolve, 0, jacobian, window, "same")
            noise = np.convolve(noise, window, "same")
        low, high = intervals(data, linear(data, jacobian, noise))[0]
        covered += low <= 0.0 <= high  # the truth
    assert 180 <= covered <= 200


@pytest.mark.parametrize(("pull", "beyond"), [(0.5, True), (0.001, False), (-0.5, False)])
def test_a_term_that_the_data_pull_past_its_end_is_told(pull: float, beyond: bool) -> None:
    data = problem()
    random = np.random.default_rng(4)
    size = data.blocks.size
    jacobian, noise = random.normal(size=(size, 2)), random.normal(size=size)
    at_end = np.array([50.0, 0.0])
    bounds = np.array([[-50.0, -50.0], [50.0, 50.0]])
    left = noise - pull * jacobian[:, 0]
    stuck = Fit((TERM, SLOPE), (), at_end, left, np.zeros(size), jacobian, at_end, bounds)
    near = np.array([True, False])
    assert list(beyond_range(data, stuck, near)) == [beyond, False]
    assert not beyond_range(data, stuck, ~near).any()


def test_values_that_compensate_each_other_have_no_interval() -> None:
    data = problem()
    random = np.random.default_rng(6)
    size = data.blocks.size
    column = random.normal(size=size)
    both = np.column_stack([column, 1.001 * column])
    ranges = intervals(data, linear(data, both, random.normal(size=size)))
    assert ranges.tolist() == [[-50.0, 50.0], [-50.0, 50.0]]


SAMPLES = 200 * BLOCKS  # of the linear rig
QUANTILE = float(stats.t.ppf(0.975, 2 * BLOCKS - 1))


def interval(unmodelled: float, correction: float = 0.0) -> tuple[float, float]:
    """95 % interval of w = 3 beside an error of that rms, with a correction for the step."""
    given = context({"w": {"w": 1.0}}, {"w": 3.0, "a": unmodelled}, [])
    fitted = given.fit_model([effect("w")], [3.0]).fit
    fitted = replace(fitted, correction=np.full(SAMPLES, correction))
    low, high = intervals(given.problem, fitted)[0]
    return float(low), float(high)


@pytest.mark.parametrize("unmodelled", [0.0, 0.5, 5.0])
def test_an_unmodelled_error_widens_intervals_by_the_bias_that_it_may_cause(
    unmodelled: float,
) -> None:
    """Of a correlation of 0.2 with a waveform of rms 1 it would shift the value by 0.2 rms."""
    low, high = interval(unmodelled)
    assert 0.5 * (low + high) == pytest.approx(3.0, abs=1e-6)
    deviation = np.hypot(1.0 / np.sqrt(SAMPLES), 0.2 * unmodelled)
    assert 0.5 * (high - low) == pytest.approx(QUANTILE * deviation, rel=1e-3)


def test_the_error_of_the_step_widens_intervals_as_an_unmodelled_one_does() -> None:
    """Halving the step changes the residual by half of the correction."""
    assert interval(0.0, correction=4.0) == pytest.approx(interval(2.0), rel=1e-4)


@pytest.mark.parametrize("end", [1.0, -1.0])
@pytest.mark.parametrize(
    ("unmodelled", "half"),
    [(0.0, QUANTILE / np.sqrt(SAMPLES)), (5.0, QUANTILE * np.hypot(1.0 / np.sqrt(SAMPLES), 1.0))],
    ids=["noise", "unmodelled"],
)
def test_a_parameter_is_beyond_its_range_by_more_than_half_of_its_interval(
    end: float, unmodelled: float, half: float
) -> None:
    """Within that the data allow the end of its range itself."""

    def beyond(distance: float) -> list[str]:
        truth: Shape = {"w": end * (4.0 + distance), "a": unmodelled}
        problem = context({"w": {"w": 1.0}}, truth, []).problem
        term = Term(("w",), "-", 0.0, -4.0, 4.0, 0.1)
        return parameters_beyond_range(problem, fit(problem, {}, [term], (), np.array([4.0 * end])))

    assert beyond(0.7 * half) == []
    assert beyond(1.7 * half) == ["w"]


def test_an_error_counts_as_no_more_than_its_signal_varies() -> None:
    data = problem()
    series = [
        data.recordings[k].columns[column] / data.noise[k][column] for k, column, _ in data.layout()
    ]
    most = np.mean([np.var(one) for one in series])
    size = sum(count for _, _, count in data.layout())
    assert reducible_excess(data, np.full(size, 1e6)) == pytest.approx(most)
    assert reducible_excess(data, np.full(size, 1.1)) == pytest.approx(0.21)
