"""Models that explain the recordings as well as each other, and how far they differ elsewhere.

Two kinds of models tie: an effect and its rivals, each fitted with the rest of the model; and one
model at two values of a number that the recordings do not determine, with everything else fitted to
each of them (the ends of its profile likelihood, Raue et al. 2009, Bioinformatics 25(15)).

Alternative A would record y_A where B predicts y_B. Before they are told apart, the terms of B are
fitted to the new data too, as far as the old ones let them. To first order, with J the Jacobian of
y_B, H the information on the terms of B in the old data and everything in units of noise,

    d² = min_δ (|y_B + J δ − y_A|² + δᵀ H δ)/m,

for terms within their bounds; m is the number of samples. Of "A fitted to B" and "B fitted to A"
the smaller counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import (
    Fit,
    FittedCandidate,
    MakeSimulator,
    Problem,
    SelectedEffect,
    Selection,
    SelectionContext,
    Term,
    bounded_least_squares,
    expected,
    intervals,
    session_terms,
    tied,
)
from tendon_mj.lab.experiment_design.experiment import Experiment
from tendon_mj.lab.replay import (
    Simulates,
    expand,
    name_in_session,
    parameter_of,
    recording_of,
    suppress_unsolved_warnings,
)
from tendon_mj.typing import BoolArray, FloatArray

_EVALUATIONS = 8  # of a fit from where it is nearly done
_WIDE = 0.5, 5.0  # of the value, and of the probe: an interval wider than both determines little
_SHRUNK = 0.5, 4  # factor on the way to an end of a profile where that is refuted, and tries
_FIXED = 1e-6  # of the way: half the range of a term that a profile holds
_FOLLOWS = 0.5  # of its interval: a number that moves this far along a profile is part of it
_DIFFERENCE = 1e-2  # of a probe, as in fits


@dataclass(frozen=True, eq=False)
class Alternative:
    """A model of the recordings."""

    label: str  # its difference to the others
    fit: Fit  # its terms, and their values
    held: BoolArray  # (p,) terms that define it, which are not fitted to another's data


Tie = tuple[Alternative, ...]  # two or more


def find_ties(context: SelectionContext, selection: Selection) -> list[Tie]:
    """Sets of models that the training data cannot tell from each other.

    Of effects with rivals; where none has any, of numbers that are not determined.
    """
    rivals = [_rivals(context, selection.final, effect) for effect in selection.effects]
    return [tie for tie in rivals if tie] or _undetermined(context, selection.final)


def _rivals(context: SelectionContext, final: FittedCandidate, effect: SelectedEffect) -> Tie:
    """An effect and its rivals; none where it has no rival."""
    made = [_alternative(effect.candidate.label, final)] if effect.models else []
    for model in effect.models:
        rival = model.candidate
        assert rival is not None
        effects = tuple(rival if e == effect.candidate else e for e in final.fit.effects)
        own = {e.label: (model if e == rival else final).fit for e in effects}
        start = [
            *final.fit.values[: len(final.fit.calibrated)],
            *(v for e in effects for v in own[e.label].values[own[e.label].terms_of(e)]),
        ]
        if set(effects) == set(model.fit.effects):
            effects, start = model.fit.effects, [*model.fit.values]
        fitted = context.fit_model(effects, start, rival, near=model.fit, evaluations=_EVALUATIONS)
        made.append(_alternative(rival.label, fitted))
    return tuple(made)


def _alternative(label: str, model: FittedCandidate, held: int | None = None) -> Alternative:
    return Alternative(label, model.fit, np.arange(len(model.fit.terms)) == held)


def _undetermined(context: SelectionContext, final: FittedCandidate) -> list[Tie]:
    """The model at both ends of the profile of each number that is not determined by itself."""
    fitted, ties = final.fit, list[Tie]()
    ranges = intervals(context.problem, fitted)
    for k in map(int, np.flatnonzero(fitted.shared)):
        width, value = float(np.ptp(ranges[k])), abs(float(fitted.values[k]))
        if width <= max(_WIDE[0] * value, _WIDE[1] * fitted.terms[k].probe):
            continue
        moved = (abs(float(tie[1].fit.values[k] - tie[0].fit.values[k])) for tie in ties)
        if any(way > _FOLLOWS * width for way in moved):  # part of another profile
            continue
        ends = [_end_of_profile(context, final, k, float(end)) for end in ranges[k]]
        if ends[0] is not ends[1]:
            ties.append(tuple(_alternative(_at(end.fit, k), end, k) for end in ends))
    return ties


def _end_of_profile(
    context: SelectionContext, final: FittedCandidate, k: int, end: float
) -> FittedCandidate:
    """The model fitted with term k held as far towards ``end`` as the data do not refute it."""
    fitted, value = final.fit, float(final.fit.values[k])
    for attempt in range(_SHRUNK[1]):
        at = value + (end - value) * _SHRUNK[0] ** attempt
        half = _FIXED * abs(at - value)
        if half == 0.0:
            break
        start = fitted.values.copy()
        start[k] = at
        terms = [
            replace(term, low=at - half, high=at + half) if j == k else term
            for j, term in enumerate(fitted.terms)
        ]
        calibrated = tuple(terms[: len(fitted.calibrated)])
        effects = [replace(e, terms=tuple(terms[fitted.terms_of(e)])) for e in fitted.effects]
        held = replace(context, calibrated=calibrated).fit_model(
            effects, start, near=fitted, evaluations=_EVALUATIONS
        )
        if tied(final, held):
            return held
    return final


def _at(fitted: Fit, k: int) -> str:
    term = fitted.terms[k]
    unit = "" if term.unit in ("", "-") else f" {term.unit}"
    return f"{' = '.join(term.targets)} = {fitted.values[k]:.3g}{unit}"


@dataclass(frozen=True, eq=False)
class Predictions:
    """Readings that an alternative predicts for one experiment."""

    readings: FloatArray  # (m,) in units of noise; infinite where the simulation failed
    within_limits: bool  # whether no reading leaves the limits


@dataclass(frozen=True, eq=False)
class ExperimentSimulations:
    """Simulations of experiments that have not been run."""

    problem: Problem  # recordings that there are
    base: Mapping[str, float]  # parameter → value of the model
    levels: Mapping[str, float]  # measured column → noise [its unit]
    # measured column → (low, high) that no reading may leave [its unit]
    limits: Mapping[str, tuple[float, float]]
    make: MakeSimulator  # makes the simulator of recordings
    step: float = 1.0  # of the simulation, in steps of the model

    def predict(
        self, experiments: Sequence[Experiment], alternatives: Sequence[Alternative]
    ) -> list[list[Predictions]]:
        """Predictions of every alternative, for every experiment."""
        simulate = self._simulator(experiments)
        sets = [self._parameters(a.fit, a.fit.values, experiments) for a in alternatives]
        return [list(row) for row in zip(*self._run(simulate, sets), strict=True)]

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
        moved = self._run(simulate, sets)
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
        """Parameter that is set for each recording → its term in each experiment."""
        terms: dict[str, list[Term]] = {}
        recordings = [e.recording for e in experiments]
        for term in session_terms(recordings, self.problem.simulate):
            terms.setdefault(parameter_of(term.targets[0]), []).append(term)
        return terms

    def _simulator(self, experiments: Sequence[Experiment]) -> Simulates:
        return self.make([e.recording for e in experiments]).in_steps(self.step)

    def _parameters(
        self, fitted: Fit, values: FloatArray, experiments: Sequence[Experiment]
    ) -> dict[str, float]:
        """Parameters of a model in all experiments, each of which may have its own state.

        A parameter that is both a state and an effect of the model is the sum of the user's value
        and of that of the effect.
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
        self, simulate: Simulates, sets: Sequence[Mapping[str, float]]
    ) -> list[list[Predictions]]:
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
    """Terms of an alternative that new data may change, and their information in the old data."""

    alternative: Alternative  # that has the terms
    in_train: BoolArray  # (samples of the old data,) which of them it was fitted to

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
