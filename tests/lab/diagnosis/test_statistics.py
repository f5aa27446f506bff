"""Cross-validation, comparison, intervals and thresholds, where the exact answer is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tendon_mj.lab.diagnosis import (
    Candidate,
    Fit,
    FittedCandidate,
    Problem,
    Term,
    all_samples,
    fit,
    intervals,
    tied,
)
from tendon_mj.lab.diagnosis.fitting import near_differences, rings
from tendon_mj.lab.diagnosis.limits import (
    CLOSED,
    detection_limit,
    discretisation_error,
    least_share,
    reducible_excess,
    unexplained_excess,
)
from tendon_mj.lab.diagnosis.proof import is_narrower, parameters_beyond_range
from tendon_mj.lab.diagnosis.statistics import (
    CrossValidation,
    beyond_range,
    cross_validate,
    gain,
    over_intervals,
    rate_effect,
    sides,
    simplest,
)
from tendon_mj.lab.recordings import Measured, Recording
from tests.lab.diagnosis.linear_rig import BLOCKS, LinearRig, Shape, context, effect, named
from tests.lab.diagnosis.toy import Toy, problem_of, recording, ringing

TERM = Term(("sheath.constant_friction",), "N", 0.0, -50.0, 50.0, 1.0)
SLOPE = Term(("sheath.friction_drift",), "1/s", 0.0, -50.0, 50.0, 1.0)


def problem(seed: int = 0) -> Problem:
    made = (recording("a", seed, {}), recording("b", seed + 1, {}))
    return problem_of(Toy, made)


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
    result = cross_validate(data, linear(data, jacobian, noise))
    for block, chi2 in zip(np.unique(data.blocks), result.chi2, strict=True):
        inside = data.blocks == block
        refit = np.linalg.lstsq(jacobian[~inside], -noise[~inside], rcond=None)[0]
        left = noise[inside] + jacobian[inside] @ refit
        assert chi2 == pytest.approx(float(left @ left), rel=1e-6)


def test_a_part_that_slopes_foretell_badly_is_left_out_of_another_fit() -> None:
    data = problem()
    random = np.random.default_rng(1)
    size, first = data.blocks.size, np.unique(data.blocks)[0]
    jacobian, noise = random.normal(size=(size, 2)), random.normal(size=size)
    steep = data.blocks == first
    seen = noise + 3.0 * random.normal(size=size) * steep
    fitted = linear(data, jacobian, seen)
    kinked = linear(data, np.where(steep[:, None], 1e3 * jacobian, jacobian), seen)

    def refit(part: int) -> Fit:
        others = data.without(part).in_train
        assert np.array_equal(others, data.blocks != part)
        solution = np.linalg.lstsq(jacobian[others], -seen[others], rcond=None)[0]
        return replace(fitted, scaled=solution, residual=seen + jacobian @ solution)

    foretold, true = cross_validate(data, kinked), cross_validate(data, kinked, refit)
    assert foretold.chi2[0] > 10.0 * true.chi2[0], "by slopes a thousand times too steep"
    assert true.chi2[0] == pytest.approx(cross_validate(data, fitted).chi2[0], rel=1e-6)
    assert np.array_equal(foretold.chi2[1:], true.chi2[1:])
    same = cross_validate(data, fitted, refit).chi2
    assert same == pytest.approx(cross_validate(data, fitted).chi2), "where slopes are right"


def test_beside_a_non_smooth_effect_no_block_is_left_out() -> None:
    data = problem()
    random = np.random.default_rng(1)
    size = data.blocks.size
    fitted = linear(data, random.normal(size=(size, 2)), random.normal(size=size))
    effect = Candidate(named("drift", non_smooth=True), "sheath", (SLOPE,))
    result = cross_validate(data, replace(fitted, calibrated=(TERM,), effects=(effect,)))
    assert result.excess == pytest.approx(float(np.mean(fitted.residual**2)) - 1.0)
    assert result.excess < cross_validate(data, fitted).excess


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


@pytest.mark.parametrize(("pull", "determined"), [(2.0, True), (0.1, False)])
def test_a_value_is_determined_by_another_at_its_end_where_the_data_hold_it_there(
    pull: float, determined: bool
) -> None:
    """The other compensates it, unless the data would take that beyond its end."""
    data = problem()
    random = np.random.default_rng(6)
    size = data.blocks.size
    column, noise = random.normal(size=size), random.normal(size=size)
    both = np.column_stack([column, column + 0.1 * random.normal(size=size)])
    left = noise - pull * (both[:, 1] - column)
    at_end = np.array([0.0, 50.0])
    bounds = np.array([[-50.0, -50.0], [50.0, 50.0]])
    stuck = Fit((TERM, SLOPE), (), at_end, left, np.zeros(size), both, at_end, bounds)
    width, alone = (
        float(np.ptp(intervals(data, stuck, moving=moving)[0])) for moving in (None, stuck.free)
    )
    assert width == pytest.approx(alone) if determined else width > 5.0 * alone


def test_intervals_reach_the_values_that_sheaths_without_lumping_have() -> None:
    data = problem()
    random = np.random.default_rng(7)
    jacobian = random.normal(size=(data.blocks.size, 2))
    noise, lumped = random.normal(size=data.blocks.size), jacobian @ [3.0, -1.0]
    ranges = intervals(replace(data, lumped=lumped), linear(data, jacobian, noise))
    for sign in (-1.0, 1.0):
        values = linear(data, jacobian, noise + sign * lumped).values
        assert all(ranges[:, 0] < values)
        assert all(values < ranges[:, 1])


def test_values_that_compensate_each_other_are_told_by_their_ranges_alone() -> None:
    data = problem()
    random = np.random.default_rng(6)
    size = data.blocks.size
    column = random.normal(size=size)
    both = np.column_stack([column, 1.001 * column])
    ranges = intervals(data, linear(data, both, random.normal(size=size)))
    assert ranges == pytest.approx(np.array([[-50.0, 50.0], [-50.0, 50.0]]), rel=0.01)


@pytest.mark.parametrize("end", [0, 1])
def test_a_value_goes_no_farther_than_another_s_range_allows_and_not_beyond_its_end(end) -> None:
    data = problem()
    random = np.random.default_rng(6)
    column, other, noise = random.normal(size=(3, data.blocks.size))
    fit = linear(data, np.column_stack([column, column + 1e-3 * other]), noise)
    bounds = np.array([[-50.0, -3.0], [50.0, 3.0]])
    fit = replace(fit, bounds=bounds, scaled=np.array([0.0, bounds[end, 1]]))
    reach = sides(data, fit, np.array([True, True]))[:, 0]
    alone = sides(data, fit, np.array([True, False]))[:, 0]
    assert reach[1 - end] == pytest.approx(alone[1 - end], rel=0.05)
    assert reach[end] == pytest.approx(np.hypot(6.0, alone[end]), rel=0.05)


@pytest.mark.parametrize("size", [1.0, 1e3, 1e5])
@pytest.mark.parametrize("room", [20.0, 500.0, 1e4])
def test_two_values_with_one_trace_are_told_by_their_ranges_however_sharp_it_is(size, room) -> None:
    data = problem()
    column, noise = np.random.default_rng(6).normal(size=(2, data.blocks.size))
    fit = linear(data, size * np.column_stack([column, column]), noise)
    fit = replace(fit, bounds=room * np.array([[-1.0, -1.0], [1.0, 1.0]]), scaled=np.zeros(2))
    assert sides(data, fit, np.array([True, True])) == pytest.approx(room, rel=0.01)


def test_a_value_without_a_trace_has_no_interval_and_spoils_none() -> None:
    data = problem()
    column, noise = np.random.default_rng(6).normal(size=(2, data.blocks.size))
    fit = linear(data, np.column_stack([column, 0.0 * column]), noise)
    reach = sides(data, fit, np.array([True, True]))
    assert np.isinf(reach[:, 1]).all()
    assert reach[:, 0] == pytest.approx(sides(data, fit, np.array([True, False]))[:, 0], rel=0.05)


@pytest.mark.parametrize(("high", "told"), [(3.1, True), (3.3, False)])
def test_a_number_is_told_by_an_interval_that_excludes_a_fifth_of_its_range(high, told) -> None:
    term = Term(("a",), "-", 1.0, 0.0, 4.0, 0.1)
    assert is_narrower(np.array([0.0, high]), term) is told


SAMPLES = 200 * BLOCKS  # of the linear rig
QUANTILE = float(stats.t.ppf(0.975, 2 * BLOCKS - 1))


class Rough(Toy):
    """A toy whose readings jump by a fiftieth of their noise at the smallest change of a force."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, np.ndarray]:
        force = changed.get(TERM.targets[0], 0.0)
        jumps = 1e-3 * np.random.default_rng(7).normal(size=recording.time.size)
        smooth = super()._one(changed, recording)
        return {c: s + jumps * np.sin(force / 1e-4) for c, s in smooth.items()}


def corrected(given: Problem, fitted: Fit) -> Fit:
    """A fit with a Jacobian over its intervals."""
    return over_intervals(given, {}, fitted, near_differences(given, {}, fitted))


def test_where_a_response_is_rough_intervals_are_those_of_the_smooth_one() -> None:
    def width(rig: type[Toy], *, over: bool) -> float:
        made = (recording("a", 1, {}), recording("b", 2, {}))
        given = problem_of(rig, made)
        fitted = fit(given, {}, (replace(TERM, probe=1e-3),), (), np.zeros(1))
        used = corrected(given, fitted) if over else fitted
        return float(np.ptp(intervals(given, used)[0]))

    smooth = width(Toy, over=False)
    assert width(Toy, over=True) == pytest.approx(smooth, rel=1e-3)
    assert width(Rough, over=False) < 0.5 * smooth
    assert width(Rough, over=True) == pytest.approx(smooth, rel=0.4)


class Curved(Toy):
    """A toy that shows the product of 1 + x and 1 + y, and x by itself a little."""

    room = 0.6  # [N], beyond which it shows x by itself less and less

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, np.ndarray]:
        x, y = (changed.get(term.targets[0], 0.0) for term in (TERM, SLOPE))
        alone = 0.015 * self.room * np.tanh(x / self.room)
        together = (1.0 + x) * (1.0 + y) - 1.0
        return super()._one({TERM.targets[0]: alone, SLOPE.targets[0]: together}, recording)


class Straight(Curved):
    """The same without an end of what x by itself shows."""

    room = 1e3


def test_an_interval_ends_where_the_error_grows_by_chance_with_the_others_fitted_anew() -> None:
    """Where 1 + x grows 1 + y falls, so that the product stays, which no straight step does."""
    terms = [replace(term, low=-0.9, high=9.0, probe=0.1) for term in (TERM, SLOPE)]

    def rises(rig: type[Toy]) -> list[float]:
        """What a value at the low end of its interval leaves more, as fitted and over it."""
        made = (recording("a", 1, {}), recording("b", 2, {}))
        given = problem_of(rig, made)
        fitted = fit(given, {}, terms, (), np.zeros(2))
        x, y = fitted.values

        def left(end: float) -> float:
            least = (1.0 + x) * (1.0 + y) / (1.0 + end) - 1.0
            values = {TERM.targets[0]: end, SLOPE.targets[0]: least}
            return float(np.sum(given.residuals([values])[0] ** 2))

        both = fitted, corrected(given, fitted)
        return [left(float(intervals(given, one)[0, 0])) - left(x) for one in both]

    (expected, same), (near, over) = rises(Straight), rises(Curved)
    assert same == pytest.approx(expected, rel=0.1)
    assert near < 0.8 * expected
    assert over == pytest.approx(expected, rel=0.1)


class Ringing(Curved):
    """A toy that shows the product alone, in a simulation that rings: rounding moves all of it."""

    room = 1e-9
    random = 0.03  # of a sample [N]

    draw = 0

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, np.ndarray]:
        drawn = {**changed, "draw": float(self.draw)} if self.draw else changed
        return ringing(super()._one(changed, recording), drawn, self.random)


def near_and_over() -> tuple[np.ndarray, np.ndarray]:
    """Widths of 1 + x and 1 + y, of which only the product is told, by small steps and far off."""
    terms = [replace(term, low=-0.5, high=1.0, probe=0.1) for term in (TERM, SLOPE)]
    given = problem_of(Ringing, (recording("a", 1, {}), recording("b", 2, {})))
    fitted = fit(given, {}, terms, (), np.zeros(2))
    assert rings(near_differences(given, {}, fitted))
    near, over = (
        np.ptp(intervals(given, one), axis=1) for one in (fitted, corrected(given, fitted))
    )
    return near, over


def test_what_a_simulation_that_rings_does_by_rounding_tells_nothing() -> None:
    near, over = near_and_over()
    assert near.max() < 0.1
    assert over.min() > 0.9


@pytest.mark.parametrize("draw", range(1, 12))
def test_nor_does_it_whatever_rounding_does(draw: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Ringing, "draw", draw)
    near, over = near_and_over()
    assert near.max() < 0.1
    assert over.min() > 0.5


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
        data.recordings[k].columns[column] / data.noise[k][column] for k, column, _ in data.signals
    ]
    most = np.mean([np.var(one) for one in series])
    size = data.in_train.size
    assert reducible_excess(data, np.full(size, 1e6)) == pytest.approx(most)
    assert reducible_excess(data, np.full(size, 1.1)) == pytest.approx(0.21)


IN_BLOCKS = 100  # in 10 blocks
NOTHING = np.zeros(0)
FIT = Fit((), (), NOTHING, NOTHING, NOTHING, np.zeros((0, 0)), NOTHING, np.zeros((2, 0)))
A, B = effect("a"), effect("b")
LONG = effect("b", shape="d")


def model(candidate: Candidate | None, excess: float, moved: float = 0.0) -> FittedCandidate:
    """Model with an excess χ², of which ``moved`` is in the other half of the blocks."""
    chi2 = np.full(10, (1.0 + excess) * IN_BLOCKS / 10.0)
    chi2[:5] += moved * IN_BLOCKS / 5.0
    chi2[5:] -= moved * IN_BLOCKS / 5.0
    return FittedCandidate(candidate, FIT, CrossValidation(chi2, IN_BLOCKS))


def test_the_standard_error_of_a_gain_comes_from_the_blocks_that_get_worse() -> None:
    before = CrossValidation(np.array([30.0, 30.0, 30.0, 30.0]), 100)
    after = CrossValidation(np.array([10.0, 10.0, 33.0, 34.0]), 100)
    got = gain(before, after)
    assert got.mean == pytest.approx(0.33)
    assert got.standard_error == pytest.approx(np.sqrt(2.0 * (3.0**2 + 4.0**2)) / 100.0)
    assert gain(before, before).standard_error == 0.0


def test_a_tie_is_a_quarter_of_what_the_best_leaves() -> None:
    assert tied(model(A, 0.0), model(B, 0.019))
    assert not tied(model(A, 0.0), model(B, 0.021))
    assert tied(model(A, 0.4), model(B, 0.4 + 0.119))
    assert not tied(model(A, 0.4), model(B, 0.4 + 0.121))


def test_a_difference_within_two_standard_errors_is_a_tie() -> None:
    """Half of the blocks of b are better by 0.1 each, so the standard error is 0.063."""
    assert tied(model(A, 0.0), model(B, 0.05, moved=0.1))
    assert not tied(model(A, 0.0), model(B, 0.2, moved=0.1))


def test_of_ties_the_simplest_goes_first_and_of_equals_the_best() -> None:
    parameter = effect("c", "parameter")
    ranked = [model(A, 0.0), model(B, 0.005), model(parameter, 0.01), model(LONG, 0.015)]
    assert simplest(ranked).candidate == parameter
    assert simplest(ranked[:2]).candidate == A
    assert simplest([model(LONG, 0.0), *ranked[:2]]).candidate == A
    assert simplest([model(A, 0.0), model(parameter, 0.1)]).candidate == A
    assert simplest([*ranked, model(None, 0.015)]).candidate is None


def test_the_detection_limit_is_the_largest_error_of_the_simulation() -> None:
    """Steps, lumping (0.25 % of the range) where there is a sheath, or 0.45 noise rms."""
    small, large = (context({}, {"a": a}, []).problem for a in (1.0, 100.0 * np.sqrt(2.0)))
    assert detection_limit(small, 0.0) == 0.2
    assert detection_limit(small, 3.0) == 3.0
    assert detection_limit(large, 0.0) == 0.2
    sheath = replace(large, simulate=LinearRig(large.recordings, {"sheath.friction": {}}))
    assert detection_limit(sheath, 0.0) == pytest.approx((0.0025 * 400.0) ** 2, rel=0.05)


def test_what_a_precise_signal_may_be_off_by_does_not_hide_another() -> None:
    """Lumping makes 1 noise of the first signal's and 1000 of the second's, which is not off."""
    rough, precise = context({}, {"a": 100.0 * np.sqrt(2.0)}, []).problem.recordings
    (column,) = precise.measured
    precise = replace(
        precise,
        measured={"fine_N": Measured("tension", 1e-3)},
        columns={"fine_N": precise.columns[column]},
    )
    both = [rough, precise]
    problem = Problem(tuple(both), LinearRig(both, {"sheath.friction": {}}), all_samples(both))
    (_, _, first), _ = problem.signals
    off = np.ones(problem.in_train.size)
    hidden = detection_limit(problem, 0.0)
    assert hidden > 1e5
    off[first] = 2.0  # within twice its own
    assert detection_limit(problem, 0.0, residual=off) == hidden
    off[first] = 10.0
    assert detection_limit(problem, 0.0, residual=off) == pytest.approx(0.5 * 2.0**2, rel=0.05)


def test_confidence_falls_with_every_effect_that_explains_as_much() -> None:
    others = [model(effect(name), 0.0) for name in "bcd"]
    for count in range(4):
        rated = rate_effect(A, [model(A, 0.0), *others[:count]])
        assert rated.confidence == pytest.approx(1.0 / (1.0 + count))
        assert len(rated.rivals) == count


def test_confidence_is_certain_where_the_next_effect_leaves_much_more() -> None:
    rated = rate_effect(A, [model(A, 0.0), model(B, 1.0)])
    assert rated.confidence == pytest.approx(1.0)
    assert rated.rivals == ()


def test_the_same_effect_elsewhere_is_a_rival_and_no_doubt_of_the_effect() -> None:
    elsewhere = effect("a", where="another")
    rated = rate_effect(A, [model(A, 0.0), model(elsewhere, 0.0)])
    assert rated.confidence == 1.0
    assert rated.rivals == (elsewhere,)


def test_more_terms_count_as_a_rival_only_where_they_gain() -> None:
    assert rate_effect(A, [model(A, 0.1), model(LONG, 0.101)]).confidence == 1.0
    assert rate_effect(A, [model(LONG, 0.0), model(A, 0.1)]).confidence == pytest.approx(0.5)


def test_a_difference_that_is_uncertain_leaves_doubt_of_the_effect() -> None:
    """b leaves 0.1 more, of which half of the blocks say the contrary by 0.4 each."""
    uncertain = np.sqrt(2.0 * 5.0 * (0.04 - 0.01) ** 2)
    assert uncertain > 2.0 * 0.02
    rated = rate_effect(A, [model(A, 0.0), model(B, 0.1, moved=0.2)])
    assert rated.confidence == pytest.approx(1.0 / (1.0 + np.exp(-0.1 / uncertain)))
    assert rated.rivals == (B,)


def test_more_terms_that_gain_no_more_than_chance_are_no_rival() -> None:
    better = model(LONG, 0.0, moved=0.2)
    assert rate_effect(A, [better, model(A, 0.05)]).confidence == 1.0
    assert rate_effect(A, [model(LONG, 0.0), model(A, 0.05)]).confidence < 1.0


def rig_of(count, known=None):
    recordings = [recording(f"r{k}", k, {}) for k in range(count)]
    if known:
        recordings = [replace(r, known={known: 0.1 * k}) for k, r in enumerate(recordings)]
    return problem_of(Toy, recordings)


def test_across_states_of_a_rig_an_effect_has_to_gain_more():
    alike, differing = rig_of(3), rig_of(3, known="sheath.constant_friction")
    assert least_share(differing) > least_share(alike) > 0.0


def test_lumping_leaves_less_where_residuals_are_judged_by_wider_bars():
    rig = rig_of(2)
    size = rig.residuals([{}]).shape[1]
    plain = discretisation_error(rig)
    assert plain > 0.0
    assert discretisation_error(rig, np.ones(size)) == pytest.approx(plain)
    assert discretisation_error(rig, np.full(size, 4.0)) == pytest.approx(plain / 16.0)


@pytest.mark.parametrize("rms", [1.0, 1.5, 4.0, 100.0])  # over the noise
def test_what_may_remain_is_a_part_of_the_error_above_the_noise(rms):
    left = np.sqrt(1.0 + unexplained_excess(rms**2 - 1.0))
    assert left - 1.0 == pytest.approx((1.0 - CLOSED) * (rms - 1.0), abs=1e-12)


def test_of_an_error_below_the_noise_nothing_may_remain():
    assert unexplained_excess(-0.5) == 0.0


def test_no_effect_is_sought_beside_numbers_that_are_not_determined() -> None:
    """Those leave much in the cross-validation alone; an unmodelled error does so in the fit."""
    for unmodelled, sought in ((0.0, False), (5.0, True)):
        given = context({"w": {"w": 1.0}}, {"w": 3.0, "a": unmodelled}, [])
        fitted = given.fit_model([effect("w")], [3.0])
        validation = fitted.validation
        left_out = CrossValidation(validation.chi2 + validation.samples, validation.samples)
        assert given.leaves_much(replace(fitted, validation=left_out)) == sought
