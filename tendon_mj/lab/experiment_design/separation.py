"""How far alternatives differ in an experiment, once each has been fitted to the other.

Alternative A would record y_A where B predicts y_B. Before they are told apart, the terms of B are
fitted to the new data too, as far as the old ones let them. To first order, with J the Jacobian of
y_B, H the information on the terms of B in the old data and everything in units of noise,

    d² = min_δ (|y_B + J δ − y_A|² + δᵀ H δ)/m,

for terms within their bounds; m is the number of samples. Of "A fitted to B" and "B fitted to A"
the smaller counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, cholesky

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import (
    Fit,
    MakeSimulator,
    Problem,
    Term,
    bounded_least_squares,
    expected,
    session_terms,
)
from tendon_mj.lab.experiment_design.alternatives import Alternative
from tendon_mj.lab.experiment_design.experiment import Experiment
from tendon_mj.lab.replay import (
    Simulates,
    expand,
    name_in_session,
    parameter_of,
    recording_of,
    suppress_unsolved_warnings,
)
from tendon_mj.typing import FloatArray

_DIFFERENCE = 1e-2  # of a probe, as in fits


@dataclass(frozen=True, eq=False)
class Predictions:
    """Readings that an alternative predicts for one experiment.

    Attributes:
        readings: (m,) in units of noise; infinite where the simulation failed.
        within_limits: whether no reading leaves the limits.
    """

    readings: FloatArray
    within_limits: bool


@dataclass(frozen=True, eq=False)
class Rig:
    """Simulations of experiments that have not been run.

    Attributes:
        problem: recordings that there are.
        base: parameter → value of the model.
        levels: measured column → what counts as noise [its unit].
        limits: measured column → (low, high) that no reading may leave [its unit].
        make: makes the simulator of recordings.
        step: of the simulation, in steps of the model.
    """

    problem: Problem
    base: Mapping[str, float]
    levels: Mapping[str, float]
    limits: Mapping[str, tuple[float, float]]
    make: MakeSimulator
    step: float = 1.0

    def predict(
        self, experiments: Sequence[Experiment], alternatives: Sequence[Alternative]
    ) -> list[list[Predictions]]:
        """Predictions of every alternative, for every experiment."""
        simulate = self._simulator(experiments)
        sets = [self._parameters(a.fit, a.fit.values, experiments) for a in alternatives]
        return [list(row) for row in zip(*self._run(simulate, sets, experiments), strict=True)]

    def slopes(
        self, experiments: Sequence[Experiment], alternative: Alternative, near: list[Predictions]
    ) -> list[FloatArray]:
        """(m, p) Jacobian of each experiment by the scaled terms of `adaptable`."""
        simulate, fitted = self._simulator(experiments), alternative.fit
        own = self.sessions(experiments)
        sets = []
        for k, sign in zip(*_steps(alternative), strict=True):
            scaled = fitted.scaled.copy()
            scaled[k] += sign * _DIFFERENCE
            values = [t.natural(float(z)) for t, z in zip(fitted.terms, scaled, strict=True)]
            sets.append(self._parameters(fitted, np.array(values), experiments))
        stands = self._parameters(fitted, fitted.values, experiments)
        sets += [
            stands | {t.targets[0]: t.natural(_DIFFERENCE) for t in terms} for terms in own.values()
        ]
        signs = [*_steps(alternative)[1], *(1.0 for _ in own)]
        moved = self._run(simulate, sets, experiments)
        return [
            np.array(
                [
                    (row[n].readings - near[n].readings) / (sign * _DIFFERENCE)
                    for row, sign in zip(moved, signs, strict=True)
                ]
            )
            .reshape(len(sets), -1)
            .T
            for n in range(len(experiments))
        ]

    def sessions(self, experiments: Sequence[Experiment]) -> dict[str, list[Term]]:
        """Parameter → its own term in each experiment, of what is set anew for a recording."""
        found: dict[str, list[Term]] = {}
        recordings = [e.recording for e in experiments]
        for term in session_terms(recordings, self.problem.simulate):
            found.setdefault(parameter_of(term.targets[0]), []).append(term)
        return found

    def _simulator(self, experiments: Sequence[Experiment]) -> Simulates:
        return self.make([e.recording for e in experiments]).in_steps(self.step)

    def _parameters(
        self, fitted: Fit, values: FloatArray, experiments: Sequence[Experiment]
    ) -> dict[str, float]:
        """Parameters of a model in all experiments, of which each may have a state of its own.

        A parameter that is both a state and an effect of the model is what the user sets, and what
        the effect adds to it.
        """
        written = fitted.parameters(self.base, values)
        shared = {name: value for name, value in written.items() if not recording_of(name)}
        for experiment in experiments:
            states = expand(experiment.states, self.problem.simulate.parameters)
            for name in states.keys() & shared.keys():
                if not self.problem.simulate.sessions:
                    raise InvalidValueError(
                        f"bounds, [states] {name!r}: an explanation changes it too, and simulator"
                        f" {type(self.problem.simulate).__name__!r} takes no values for single"
                        " recordings; see `sessions` of tendon_mj.Simulates"
                    )
                own = name_in_session(name, experiment.recording.name)
                written[own] = states[name] + shared[name] - self.base[name]
        names = {experiment.recording.name for experiment in experiments}
        return shared | {n: v for n, v in written.items() if recording_of(n) in names}

    @suppress_unsolved_warnings()
    def _run(
        self,
        simulate: Simulates,
        sets: Sequence[Mapping[str, float]],
        experiments: Sequence[Experiment],
    ) -> list[list[Predictions]]:
        """Predictions of every set, for every experiment."""
        return [
            [self._predictions(series) for series in row]
            for row in simulate([{**self.problem.fixed, **s} for s in sets])
        ]

    def _predictions(self, series: Mapping[str, FloatArray]) -> Predictions:
        readings = np.concatenate([series[c] / level for c, level in self.levels.items()])
        finite = bool(np.isfinite(readings).all())
        inside = finite and all(
            low <= float(series[c].min()) and float(series[c].max()) <= high
            for c, (low, high) in self.limits.items()
            if c in series
        )
        return Predictions(readings, inside)


@dataclass(frozen=True, eq=False)
class Adaptation:
    """Terms of an alternative that are fitted to new data, and what the old data say of them.

    Attributes:
        alternative: whose terms.
        in_train: (samples of the old data,) which of them it was fitted to.
    """

    alternative: Alternative
    in_train: NDArray[np.bool_]

    @cached_property
    def root(self) -> FloatArray:
        """(p, p) R with RᵀR = H, the values of old sessions being fitted to each other datum."""
        fitted = self.alternative.fit
        moves, own = np.array(_steps(self.alternative)[0], int), np.flatnonzero(~fitted.shared)
        rows = fitted.jacobian[self.in_train]
        normal = rows.T @ rows + np.diag(fitted.weights**2)
        normal /= max(1.0, float(np.mean(fitted.residual[self.in_train] ** 2)))
        matrix = normal[np.ix_(moves, moves)]
        if own.size:
            across = normal[np.ix_(own, moves)]
            matrix = matrix - across.T @ cho_solve(
                (cholesky(normal[np.ix_(own, own)]), False), across
            )
        values, vectors = np.linalg.eigh(matrix)
        root: FloatArray = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        return root

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, p) within which the scaled terms may move from where they are."""
        fitted, moves = self.alternative.fit, _steps(self.alternative)[0]
        bounds: FloatArray = fitted.bounds[:, moves] - fitted.scaled[moves]
        return bounds

    def remaining(
        self, slopes: FloatArray, difference: FloatArray, sessions: Sequence[Term]
    ) -> float:
        """Distance d that remains of a ``difference`` (m,) for ``slopes`` (m, p + sessions)."""
        count, own = self.root.shape[1], len(sessions)
        if not np.isfinite(slopes).all():
            return 0.0
        ranges = np.array([[t.scaled(t.low), t.scaled(t.high)] for t in sessions]).reshape(own, 2)
        known = np.zeros((count + own, count + own))
        known[:count, :count] = self.root
        known[count:, count:] = np.diag(expected(sessions))
        matrix = np.vstack([slopes, known])
        residual = np.append(difference, np.zeros(count + own))
        if matrix.shape[1]:
            bounds = np.hstack([self.bounds, ranges.T])
            residual = residual + matrix @ bounded_least_squares(matrix, residual, bounds)
        return float(np.linalg.norm(residual)) / float(np.sqrt(difference.size))


def _steps(alternative: Alternative) -> tuple[list[int], list[float]]:
    """Terms that are fitted to new data, and on which side of each its slope is taken."""
    fitted = alternative.fit
    moves = np.flatnonzero(fitted.shared & ~alternative.held)
    sides = np.where(fitted.scaled > fitted.bounds.mean(axis=0), -1.0, 1.0)
    return [int(k) for k in moves], [float(sides[k]) for k in moves]
