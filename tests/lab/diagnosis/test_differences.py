"""Derivatives of several terms from one simulation are those of each by itself, to the bit."""

import dataclasses

import numpy as np

from tendon_mj.lab.diagnosis import Problem, Term, all_samples, written
from tendon_mj.lab.diagnosis.fitting import differences, natural
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Simulator

TIME = np.arange(0.0, 0.6, 0.02)
BARE = Recording(
    name="a",
    model="bench",
    source="made for a test",
    time=TIME,
    columns={"reel_m": 1e-3 * np.sin(12.0 * TIME), "input_N": 20.0 + 0.0 * TIME},
    drive={"reel_m": "reel"},
    measured={"input_N": Measured("input_tension", 0.1)},
)


class Counting:
    """A problem that counts its simulations, and fails where one parameter has one value."""

    def __init__(self, fails=None):
        recordings = tuple(dataclasses.replace(BARE, name=name) for name in "abc")
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
    found = terms()
    point, step = np.zeros(len(found)), np.full(len(found), 1e-2)

    def parameters(scaled):
        return written(found, natural(found, scaled), {})

    residual = problem.residuals([parameters(point)])[0]
    problem.sets = 0
    packed = differences(problem, found, parameters, point, step, residual)
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
