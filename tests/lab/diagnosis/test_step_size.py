"""Step size of the simulation, and the global search for the minimum of a non-smooth cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    Candidate,
    Problem,
    SelectionContext,
    Term,
    all_samples,
    fit,
    search_step,
    with_step,
)
from tendon_mj.lab.diagnosis.data import step_error
from tendon_mj.lab.diagnosis.search import linearisation_holds, search_globally
from tendon_mj.lab.diagnosis.selection import select_effects
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import COLUMNS, NOISE, WEIGHTS, Toy, recording, waveform
from tests.lab.replay.test_simulator import bench_recording

FRICTION = Term(("sheath.friction",), "", 0.15, 0.05, 0.4, 0.0175)
TRUTH = {"sheath.friction": 0.2}


class Stepped(Toy):
    """The toy rig with an error of its steps that looks like a little less friction."""

    def __init__(self, recordings: Sequence[Recording], step: float) -> None:
        super().__init__(recordings)
        self.step = step

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        friction = changed.get("sheath.friction", 0.15)
        error = -0.1 * self.step * friction * waveform("sheath.friction", recording)
        shares = WEIGHTS["sheath.friction"][1]
        series = super()._one(changed, recording)
        return {c: s + w * error for (c, s), w in zip(series.items(), shares, strict=True)}


class NonSmooth(Toy):
    """The toy rig where friction also makes a ripple that no other friction makes."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        friction = changed.get("sheath.friction", 0.15)
        ripple = 0.1 * np.sin(900.0 * friction + 40.0 * recording.time)
        return {c: s + ripple for c, s in super()._one(changed, recording).items()}


def test_a_fit_with_a_long_step_is_extrapolated_to_a_step_of_zero() -> None:
    made = (recording("a", 1, TRUTH), recording("b", 2, TRUTH))
    coarse = Problem(made, Stepped(made, 1.0), all_samples(made))
    both = Problem(made, Stepped(made, 1.0), all_samples(made), half_step=Stepped(made, 0.5))
    biased = fit(coarse, {}, [FRICTION], (), np.array([0.15])).values[0]
    found = fit(both, {}, [FRICTION], (), np.array([0.15]))
    assert abs(biased - 0.2) > 0.004
    assert found.values[0] == pytest.approx(0.2, abs=5e-4)
    assert np.mean(found.residual**2) == pytest.approx(1.0, abs=0.1)
    (again,) = both.residuals([{"sheath.friction": found.values[0]}])
    assert found.residual == pytest.approx(again + found.correction, abs=1e-12)


def test_extrapolation_is_better_than_the_shorter_of_both_steps() -> None:
    stated = {c: Measured(c.removesuffix("_N"), NOISE) for c in COLUMNS}
    made = [bench_recording(0.3, rate, measured=stated) for rate in (20.0, 35.0)]
    own = Problem(tuple(made), Simulator(made), all_samples(made))
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
    problem = Problem(made, Toy(made), all_samples(made))
    assert search_step(problem) is None
    assert with_step(problem, None) is problem
    (residual,) = problem.residuals([{}])
    assert problem.extrapolate({}, residual) is residual


def non_smooth_problem() -> Problem:
    random = np.random.default_rng(5)
    made = []
    for blank in (recording("a", 1, {}), recording("b", 2, {})):
        truth = NonSmooth([blank])([TRUTH])[0][0]
        noisy = {c: s + random.normal(0.0, NOISE, s.size) for c, s in truth.items()}
        made.append(replace(blank, columns=blank.columns | noisy))
    return Problem(tuple(made), NonSmooth(made), all_samples(made))


def test_a_global_search_leaves_a_local_minimum() -> None:
    problem = non_smooth_problem()
    stuck = fit(problem, {}, [FRICTION], (), np.array([0.15]), evaluations=30)
    assert np.mean(stuck.residual**2) > 5.0
    around = search_globally(problem, {}, stuck, slice(1), lambda *_: None)
    free = fit(problem, {}, [FRICTION], (), around, correction=stuck.correction, evaluations=30)
    assert free.values[0] == pytest.approx(0.2, abs=5e-4)
    assert np.array_equal(around, search_globally(problem, {}, stuck, slice(1), lambda *_: None))


def test_the_linearisation_holds_on_a_smooth_cost_only() -> None:
    non_smooth = non_smooth_problem()
    smooth = replace(non_smooth, simulate=Toy(non_smooth.recordings))  # cannot explain the ripple
    for problem in (smooth, non_smooth):
        stuck = fit(problem, {}, [FRICTION], (), np.array([0.15]), evaluations=30)
        assert np.mean(stuck.residual**2) > 2.0
        assert linearisation_holds(problem, {}, stuck) == (problem is smooth)


@pytest.mark.parametrize("non_smooth", [False, True])
def test_only_a_non_smooth_effect_is_searched_globally(non_smooth: bool) -> None:
    term = replace(FRICTION, inert=0.06, probe=0.1)
    effect = Candidate("friction", "missing", "sheath", (term,), non_smooth=non_smooth)
    context = SelectionContext(
        non_smooth_problem(), {"sheath.friction": 0.06}, (), (effect,), 0.0, 0.0, lambda *_: None
    )
    selection = select_effects(context, context.fit_model((), ()))
    assert [selected.candidate for selected in selection.effects] == [effect]
    assert (selection.final.excess < 0.1) == non_smooth
    assert (abs(selection.final.fit.values[0] - 0.2) < 5e-4) == non_smooth
