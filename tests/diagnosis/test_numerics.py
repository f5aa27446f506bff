"""Steps of the simulation: what is searched, what is judged, and the way out of local minima."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.diagnosis.around import look_around, slopes_hold
from tendon_mj.diagnosis.contest import Setting
from tendon_mj.diagnosis.effects.effect import Candidate, Term
from tendon_mj.diagnosis.fit import fit
from tendon_mj.diagnosis.numerics import in_steps, searching_steps, step_error
from tendon_mj.diagnosis.problem import Problem, whole
from tendon_mj.recordings.recording import Measured, Recording
from tendon_mj.replay.simulator import Simulator
from tests.diagnosis.toy import COLUMNS, NOISE, WEIGHTS, FloatArray, Toy, recording, waveform
from tests.replay.test_simulator import bench_recording

FRICTION = Term(("sheath.friction",), "", 0.15, 0.05, 0.4, 0.0175)
SETTLED = {"sheath.friction": 0.2}


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


class Rugged(Toy):
    """The toy rig where friction also makes a ripple that no other friction makes."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        friction = changed.get("sheath.friction", 0.15)
        ripple = 0.1 * np.sin(900.0 * friction + 40.0 * recording.time)
        return {c: s + ripple for c, s in super()._one(changed, recording).items()}


def test_what_is_searched_in_long_steps_is_judged_without_their_error() -> None:
    made = (recording("a", 1, SETTLED), recording("b", 2, SETTLED))
    rough = Problem(made, Stepped(made, 1.0), whole(made))
    both = Problem(made, Stepped(made, 1.0), whole(made), finer=Stepped(made, 0.5))
    biased = fit(rough, {}, [FRICTION], (), np.array([0.15])).values[0]
    found = fit(both, {}, [FRICTION], (), np.array([0.15]))
    assert abs(biased - 0.2) > 0.004
    assert found.values[0] == pytest.approx(0.2, abs=5e-4)
    assert np.mean(found.residual**2) == pytest.approx(1.0, abs=0.1)
    (again,) = both.residuals([{"sheath.friction": found.values[0]}])
    assert found.residual == pytest.approx(again + found.refined, abs=1e-12)


def test_refining_leaves_less_than_the_shorter_of_both_steps() -> None:
    stated = {c: Measured(c.removesuffix("_N"), NOISE) for c in COLUMNS}
    made = [bench_recording(0.3, rate, measured=stated) for rate in (20.0, 35.0)]
    own = Problem(tuple(made), Simulator(made), whole(made))
    steps = searching_steps(own)
    assert steps == 2.0
    long = in_steps(own, steps)
    (rough,), (finer,) = long.residuals([{}]), own.residuals([{}])
    refined = long.refine({}, rough)
    assert refined == pytest.approx(2.0 * finer - rough, abs=1e-12)
    (nearly,) = in_steps(own, 0.125).residuals([{}])
    assert np.linalg.norm(refined - nearly) < 0.5 * np.linalg.norm(finer - nearly)
    assert step_error(refined - rough) == pytest.approx(np.mean((finer - rough) ** 2))


def test_a_simulator_of_ones_own_is_taken_at_its_word() -> None:
    made = (recording("a", 1, SETTLED),)
    problem = Problem(made, Toy(made), whole(made))
    assert searching_steps(problem) is None
    assert in_steps(problem, None) is problem
    (residual,) = problem.residuals([{}])
    assert problem.refine({}, residual) is residual


def rugged_problem() -> Problem:
    random = np.random.default_rng(5)
    made = []
    for blank in (recording("a", 1, {}), recording("b", 2, {})):
        truth = Rugged([blank])([SETTLED])[0][0]
        noisy = {c: s + random.normal(0.0, NOISE, s.size) for c, s in truth.items()}
        made.append(replace(blank, columns=blank.columns | noisy))
    return Problem(tuple(made), Rugged(made), whole(made))


def test_looking_around_leads_out_of_a_local_minimum() -> None:
    problem = rugged_problem()
    stuck = fit(problem, {}, [FRICTION], (), np.array([0.15]), trials=30)
    assert np.mean(stuck.residual**2) > 5.0
    around = look_around(problem, {}, stuck, slice(1), lambda *_: None)
    free = fit(problem, {}, [FRICTION], (), around, refined=stuck.refined, trials=30)
    assert free.values[0] == pytest.approx(0.2, abs=5e-4)
    assert np.array_equal(around, look_around(problem, {}, stuck, slice(1), lambda *_: None))


def test_slopes_hold_where_the_response_is_smooth_and_not_among_many_valleys() -> None:
    rugged = rugged_problem()
    smooth = replace(rugged, simulate=Toy(rugged.recordings))  # leaves the ripple unexplained
    for problem in (smooth, rugged):
        stuck = fit(problem, {}, [FRICTION], (), np.array([0.15]), trials=30)
        assert np.mean(stuck.residual**2) > 2.0
        assert slopes_hold(problem, {}, stuck) == (problem is smooth)


@pytest.mark.parametrize("rugged", [False, True])
def test_only_a_rugged_effect_is_looked_for_in_all_its_range(rugged: bool) -> None:
    setting = Setting(rugged_problem(), {}, (), (), 0.0, lambda *_: None)
    effect = Candidate("friction", "missing", "sheath", (FRICTION,), rugged)
    found = setting.settle(setting.enter((effect,), [0.15], effect), whole=20.0)
    assert (found.gap < 0.1) == rugged
    assert (abs(found.fit.values[0] - 0.2) < 5e-4) == rugged
