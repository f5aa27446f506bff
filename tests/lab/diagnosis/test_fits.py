"""Steps of a simulation, derivatives, bounded steps, and the way out of a local minimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    Candidate,
    Problem,
    SelectionContext,
    Term,
    all_samples,
    bounded_least_squares,
    fit,
    search_step,
    with_step,
    written,
)
from tendon_mj.lab.diagnosis.data import step_error
from tendon_mj.lab.diagnosis.fitting import differences, natural
from tendon_mj.lab.diagnosis.search import descend
from tendon_mj.lab.diagnosis.selection import select_effects
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Series, Simulator
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.linear_rig import named
from tests.lab.diagnosis.toy import (
    COLUMNS,
    NOISE,
    Stepped,
    Toy,
    bench_recording,
    measured_by,
    problem_of,
    recording,
)

FRICTION = Term(("sheath.friction",), "", 0.15, 0.05, 0.4, 0.0175)
TRUTH = {"sheath.friction": 0.2}


class NonSmooth(Toy):
    """The toy rig where friction also makes a ripple that no other friction makes."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        friction = changed.get("sheath.friction", 0.15)
        ripple = 0.2 * np.sin(900.0 * friction + 40.0 * recording.time)
        return {c: s + ripple for c, s in super()._one(changed, recording).items()}


def test_a_fit_with_a_long_step_is_extrapolated_to_a_step_of_zero() -> None:
    made = (recording("a", 1, TRUTH), recording("b", 2, TRUTH))
    long = Stepped(made, error=0.1)
    coarse = Problem(made, long, all_samples(made))
    both = replace(coarse, half_step=long.in_steps(0.5))
    biased = fit(coarse, {}, [FRICTION], (), np.array([0.15])).values[0]
    result = fit(both, {}, [FRICTION], (), np.array([0.15]))
    assert abs(biased - 0.2) > 0.004
    assert result.values[0] == pytest.approx(0.2, abs=5e-4)
    assert np.mean(result.residual**2) == pytest.approx(1.0, abs=0.1)
    (again,) = both.residuals([{"sheath.friction": result.values[0]}])
    assert result.residual == pytest.approx(again + result.correction, abs=1e-12)


class Counted(Toy):
    """The toy rig, which counts its simulations."""

    made = 0

    def __call__(self, parameter_sets: Sequence[Mapping[str, float]]) -> list[list[Series]]:
        self.made += len(parameter_sets)
        return super().__call__(parameter_sets)


def test_a_jacobian_and_a_residual_that_are_known_are_not_simulated_again() -> None:
    """Waveforms are linear in their terms: one step ends where it should."""
    terms = [FRICTION, Term(("output_tension.offset",), "N", 0.0, -5.0, 5.0, 0.1)]
    made = (recording("a", 1, {**TRUTH, "output_tension.offset": 0.4}),)
    problem, begin = problem_of(Counted, made), np.array([0.15, 0.0])
    first = fit(problem, {}, terms, (), begin)
    assert first.values == pytest.approx([0.2, 0.4], rel=0.02)
    problem = problem_of(Counted, made)
    (seen,) = problem.residuals([{}])
    again = fit(problem, {}, terms, (), begin, jacobian=first.jacobian, seen=seen)
    assert again.values == pytest.approx(first.values, rel=1e-6)
    assert isinstance(problem.simulate, Counted)
    used, problem.simulate.made = problem.simulate.made, 0
    partly = np.where([True, False], first.jacobian, np.nan)
    fit(problem, {}, terms, (), begin, jacobian=partly, seen=seen)
    assert problem.simulate.made == used  # the column in place of what is seen


def test_secants_lead_to_the_minimum_of_a_curved_response() -> None:
    """A Jacobian that is wrong by half is corrected by the steps that it leads to."""
    made = (recording("a", 1, TRUTH), recording("b", 2, TRUTH))
    problem = problem_of(Toy, made)
    right = fit(problem, {}, [FRICTION], (), np.array([0.15]))
    wrong = 1.5 * right.jacobian
    led = fit(problem, {}, [FRICTION], (), np.array([0.15]), jacobian=wrong, evaluations=12)
    assert led.values == pytest.approx(right.values, rel=1e-5)
    assert led.jacobian == pytest.approx(right.jacobian, rel=1e-6)


def test_extrapolation_is_better_than_the_shorter_of_both_steps() -> None:
    time = np.arange(0.0, 0.3, 0.002)
    drives = [1e-3 * np.sin(rate * time) + 2e-4 for rate in (20.0, 35.0)]
    made = [bench_recording("pull", time, drive, NOISE, list(COLUMNS)) for drive in drives]
    own = problem_of(Simulator, made)
    step = search_step(own)
    assert step == 2.0
    long = with_step(own, step)
    (coarse,), (finer,) = long.residuals([{}]), own.residuals([{}])
    extrapolated = long.extrapolate({}, coarse)
    assert extrapolated == pytest.approx(2.0 * finer - coarse, abs=1e-12)
    (nearly,) = with_step(own, 0.125).residuals([{}])
    assert np.linalg.norm(extrapolated - nearly) < 0.5 * np.linalg.norm(finer - nearly)
    assert step_error(extrapolated - coarse) == pytest.approx(np.mean((finer - coarse) ** 2))


def test_the_step_of_a_users_own_simulator_is_not_touched() -> None:
    made = (recording("a", 1, TRUTH),)
    problem = problem_of(Toy, made)
    assert search_step(problem) is None
    assert with_step(problem, None) is problem
    (residual,) = problem.residuals([{}])
    assert problem.extrapolate({}, residual) is residual


def non_smooth_problem() -> Problem:
    random, blanks = np.random.default_rng(5), (recording("a", 1, {}), recording("b", 2, {}))
    made = [measured_by(NonSmooth, blank, TRUTH, random) for blank in blanks]
    return problem_of(NonSmooth, made)


def test_a_descent_leaves_a_local_minimum_and_ends_where_the_response_is_linear() -> None:
    non_smooth = non_smooth_problem()
    smooth = replace(non_smooth, simulate=Toy(non_smooth.recordings))  # cannot explain the ripple
    for problem in (smooth, non_smooth):
        stuck = fit(problem, {}, [FRICTION], (), np.array([0.15]), evaluations=30)
        assert np.mean(stuck.residual**2) > 2.0
        around = descend(problem, {}, stuck)
        assert (around is None) == (problem is smooth)
    free = fit(problem, {}, [FRICTION], (), around, correction=stuck.correction, evaluations=30)
    assert free.values[0] == pytest.approx(0.2, abs=5e-4)


@pytest.mark.parametrize(("curvature", "holds"), [(4.5, True), (5.5, False)])
def test_the_linearisation_is_tried_a_tenth_of_a_range_away(curvature: float, holds: bool) -> None:
    """A curvature of 5 makes a fifth of the response to steps of 0.1: 0.5² / (1 + 0.5²)."""
    fitted = SimpleNamespace(
        terms=(replace(FRICTION, inert=0.0, low=-0.5, high=0.5, probe=1.0),),
        bounds=np.array([[-0.5], [0.5]]),
        scaled=np.zeros(1),
        residual=np.full(3, 3.0),  # more than the range can change
        correction=3.0,
        jacobian=np.ones((3, 1)),
        parameters=lambda base, values=(0.0,): {"": values[0]},
    )
    problem = SimpleNamespace(
        in_train=np.ones(3, bool),
        residuals=lambda sets: np.array([[s[""] + curvature * s[""] ** 2] * 3 for s in sets]),
    )
    assert (descend(problem, {}, fitted) is None) == holds


@pytest.mark.parametrize("non_smooth", [False, True])
def test_the_lowest_of_many_minima_is_found(non_smooth: bool) -> None:
    term = replace(FRICTION, inert=0.06, probe=0.1)
    effect = Candidate(named("friction", non_smooth=non_smooth), "sheath", (term,))
    context = SelectionContext(
        non_smooth_problem(), {"sheath.friction": 0.06}, (), (effect,), 0.0, 0.0, lambda *_: None
    )
    selection = select_effects(context, context.fit_model((), ()))
    assert [selected.candidate for selected in selection.effects] == [effect]
    assert selection.final.excess < 0.1
    assert selection.final.fit.values[0] == pytest.approx(0.2, abs=5e-4)


TIME = np.arange(0.0, 0.6, 0.02)
BARE = bench_recording("a", TIME, 1e-3 * np.sin(12.0 * TIME), 0.1, ["input_tension_N"])


class Counting:
    """A problem that counts its simulations, and fails where one parameter has one value."""

    def __init__(self, fails=None):
        recordings = tuple(replace(BARE, name=name) for name in "abc")
        simulate = Simulator(recordings, threads=1)
        self._problem = Problem(recordings, simulate, all_samples(recordings))
        self.sets, self._fails = 0, fails

    def __getattr__(self, name):
        return getattr(self._problem, name)

    def residuals(self, parameter_sets):
        self.sets += len(parameter_sets)
        rows = self._problem.residuals(parameter_sets)
        for row, values in zip(rows, parameter_sets, strict=True):
            if self._fails in values and values[self._fails] > 20.0:
                row[:] = np.inf
        return rows


def terms():
    shared = Term(("sheath.friction",), "-", 0.15, 0.05, 0.4, 0.02)
    own = [
        Term((f"sheath.{p} @ {r}",), u, v, low, high, probe)
        for r in "abc"
        for p, u, v, low, high, probe in (
            ("pretension", "N", 20.0, 15.0, 25.0, 0.5),
            ("axial_stiffness", "N", 2e4, 1e4, 3e4, 5e2),
        )
    ]
    return (shared, *own)


def both(problem):
    result = terms()
    point, step = np.zeros(len(result)), np.full(len(result), 1e-2)

    def parameters(scaled):
        return written(result, natural(result, scaled), {})

    residual = problem.residuals([parameters(point)])[0]
    problem.sets = 0
    packed = differences(problem, result, parameters, point, step, residual)
    used = problem.sets
    alone = [
        (problem.residuals([parameters(point + row)])[0] - residual) / 1e-2 for row in np.diag(step)
    ]
    return packed, np.array(alone).T, used


def test_packed_derivatives_are_those_of_each_term_to_the_bit():
    packed, alone, used = both(Counting())
    assert used == 3  # the shared one, and the two kinds of the others
    assert np.array_equal(packed, alone)
    assert np.abs(alone).max(axis=0).min() > 0.0


def test_a_term_whose_simulation_fails_takes_no_other_with_it():
    packed, alone, _ = both(Counting(fails="sheath.pretension @ b"))
    bad = [k for k, term in enumerate(terms()) if term.targets == ("sheath.pretension @ b",)]
    assert not np.isfinite(packed[:, bad]).any()
    assert np.array_equal(np.delete(packed, bad, axis=1), np.delete(alone, bad, axis=1))


@pytest.mark.parametrize("decades", [0, 3, 6])
@pytest.mark.parametrize("seed", range(20))
def test_the_step_ends_where_nothing_within_its_bounds_is_less(decades: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 9))
    lengths = 10.0 ** random.uniform(-decades / 2, decades / 2, count)
    matrix = random.normal(size=(300, count)) @ random.normal(size=(count, count)) * lengths
    residual = random.normal(size=300)
    bounds = np.array([-1.0, 1.0])[:, None] * 10.0 ** random.uniform(-3, 1, (2, count)) / lengths
    step = bounded_least_squares(matrix, residual, bounds)
    assert (bounds[0] <= step).all()
    assert (step <= bounds[1]).all()
    # what is gained by moving a term by its width, of what there is to gain
    slope = matrix.T @ (residual + matrix @ step) * (bounds[1] - bounds[0]) / residual.size
    inside = 1e-9 * (bounds[1] - bounds[0])
    assert (slope[step > bounds[0] + inside] < 1e-6).all()
    assert (slope[step < bounds[1] - inside] > -1e-6).all()


@pytest.mark.parametrize("seed", range(20))
def test_columns_that_differ_by_more_than_a_number_has_digits_come_to_an_end(seed: int) -> None:
    """As those of a session's spread of 1e29 are."""
    random = np.random.default_rng(seed)
    lengths = 10.0 ** random.uniform(-30.0, 30.0, 6)
    matrix = random.normal(size=(300, 6)) @ random.normal(size=(6, 6)) * lengths
    bounds = np.array([-1.0, 1.0])[:, None] * 10.0 ** random.uniform(-9, 9, (2, 6))
    step = bounded_least_squares(matrix, random.normal(size=300), bounds)
    assert (bounds[0] <= step).all()
    assert (step <= bounds[1]).all()
