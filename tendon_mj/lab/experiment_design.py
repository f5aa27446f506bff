"""Search for the experiment, within bounds, in which models that tie differ most against noise.

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
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from scipy.linalg import cho_solve, cholesky

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import (
    CONVERGED,
    DIFFERENCE,
    SMALLEST_EXCESS,
    Diagnosis,
    Fit,
    FittedCandidate,
    MakeSimulator,
    Problem,
    SelectedEffect,
    Selection,
    SelectionContext,
    Term,
    all_samples,
    bounded_least_squares,
    expected,
    intervals,
    search_step,
    session_terms,
    tied,
)
from tendon_mj.lab.experiment import (
    Experiment,
    ExperimentBounds,
    Family,
    check_bounds,
)
from tendon_mj.lab.parameter_names import expand, name_in_session, parameter_of, recording_of
from tendon_mj.lab.progress import Progress, counted, silent
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.replay import Simulates, Simulator, suppress_unsolved_warnings
from tendon_mj.typing import BoolArray, FloatArray

_WIDE = 0.5, 5.0  # of the value, and of the probe: an interval wider than both determines little
_SHRUNK = 0.5, 4  # factor on the way to an end of a profile if that is refuted, and tries
_FIXED = 1e-6  # of the way: half the range of a term that a profile holds
_FOLLOWS = 0.5  # of its interval: a number that moves this far along a profile is part of it

_NAME = "next"
_SAMPLES, _ADAPTED = 64, 12  # experiments that are simulated; those to which models are fitted
_ROUNDS, _NEIGHBOURS = 4, 6  # of the refinement, and experiments in each
_REACH = 0.25, 0.6  # of the cube, of the first round; factor from round to round
_ALTERNATIVES = 2  # for more of them fewer experiments are tried
_BATCH = 8  # experiments simulated between two calls of the progress callback
_APART = float(np.sqrt(SMALLEST_EXCESS))  # noise, rms: less is not worth a name


@dataclass(frozen=True, eq=False)
class Alternative:
    """A model of the recordings."""

    label: str  # its difference to the others
    fit: Fit  # its terms, and their values
    held: BoolArray  # (p,) terms that define it, which are not fitted to another's data


Tie = tuple[Alternative, ...]  # two or more


def find_ties(
    context: SelectionContext, selection: Selection, with_one_more: Sequence[Fit] = ()
) -> list[Tie]:
    """Sets of models that the training data cannot tell from each other.

    Of effects with rivals; if none has any, of the model and each fit ``with_one_more`` effect,
    then of numbers that are not determined.
    """
    final = selection.final
    ties = [tie for effect in selection.effects if (tie := _rivals(context, final, effect))]
    label = " and ".join(e.label for e in final.fit.effects) or "nothing missing"
    model = _alternative(label, final.fit)
    for fit in with_one_more if not ties else ():
        for added in set(fit.effects) - set(final.fit.effects):
            ties.append((model, _alternative(added.label, fit, fit.terms_of(added).start)))
    return ties or _undetermined(context, final)


def _rivals(context: SelectionContext, final: FittedCandidate, effect: SelectedEffect) -> Tie:
    """An effect and its rivals; none if it has no rival."""
    made = [_alternative(effect.candidate.label, final.fit)] if effect.models else []
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
        fitted = context.fit_model(effects, start, rival, near=model.fit, evaluations=CONVERGED)
        made.append(_alternative(rival.label, fitted.fit))
    return tuple(made)


def _alternative(label: str, fit: Fit, held: int | None = None) -> Alternative:
    return Alternative(label, fit, np.arange(len(fit.terms)) == held)


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
            ties.append(tuple(_alternative(_at(end.fit, k), end.fit, k) for end in ends))
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
            effects, start, near=fitted, evaluations=CONVERGED
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

    readings: FloatArray  # (m,) in units of noise; infinite if the simulation failed
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
            scaled[k] += sign * DIFFERENCE
            values = [t.natural(float(z)) for t, z in zip(fitted.terms, scaled, strict=True)]
            sets.append(self._parameters(fitted, np.array(values), experiments))
        stands = self._parameters(fitted, fitted.values, experiments)
        sets += [
            stands | {t.targets[0]: t.natural(DIFFERENCE) for t in terms} for terms in own.values()
        ]
        signs = [*_steps(alternative)[1], *(1.0 for _ in own)]
        moved = self._run(simulate, sets)
        slopes = []
        for n, there in enumerate(near):
            changes = [
                (row[n].readings - there.readings) / (sign * DIFFERENCE)
                for row, sign in zip(moved, signs, strict=True)
            ]
            slopes.append(np.array(changes).reshape(len(sets), -1).T)
        return slopes

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
        return fitted.bounds[:, moves] - fitted.scaled[moves]

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


@dataclass(frozen=True)
class Difference:
    """Difference between the predictions of two explanations."""

    # labels of the two
    one: str
    other: str
    recorded: float  # rms in the recordings [noise]
    # rms in the experiment that is suggested, after a fit of one to the other; without one, the
    # most that an experiment within the bounds reached [noise]
    expected: float

    @property
    def decided(self) -> bool:
        """Whether the experiment tells them apart."""
        return self.expected >= _APART


@dataclass(frozen=True, eq=False)
class Suggestion:
    """An experiment that decides between explanations.

    Attributes:
        experiment: to be run; None if nothing ties, or nothing within the bounds decides.
        differences: of every two explanations that tie.
    """

    experiment: Experiment | None
    differences: tuple[Difference, ...]

    def __repr__(self) -> str:
        return f"Suggestion: {self.sentence}"

    @property
    def decided(self) -> int:
        """Number of the differences that the experiment tells apart."""
        return sum(d.decided for d in self.differences) if self.experiment else 0

    @property
    def recording(self) -> Recording | None:
        """Template of the recording: driven columns and states are given, measured ones are 0."""
        return None if self.experiment is None else self.experiment.recording

    @property
    def sentence(self) -> str:
        """The recommended experiment, and the reason."""
        if not self.differences:
            return (
                "Nothing ties: the recordings decide between all explanations that were compared."
            )
        open_ones = [d for d in self.differences if not d.decided]
        text = ""
        if self.experiment is not None:
            decided = "; ".join(
                f"{d.one} and {d.other} differ by {d.expected:.2g} times the noise; in the"
                f" recordings, by {d.recorded:.2g}"
                for d in self.differences
                if d.decided
            )
            text = f"Record {self.experiment.words}: there {decided}."
        if open_ones:
            pairs = "; ".join(
                f"{d.one} and {d.other}, which differ by {d.expected:.2g} times the noise at most"
                for d in open_ones
            )
            text += f"{' ' if text else ''}No experiment within the bounds tells apart {pairs}."
        return text

    def write(self, path: str | Path) -> Path | None:
        """Write the template as ``<stem>.csv`` and ``<stem>.toml``; None if there is none."""
        return None if self.recording is None else write_recording(self.recording, path)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        experiment = self.experiment
        motions = experiment.motions if experiment else {}
        return {
            "sentence": self.sentence,
            "motions": {column: vars(motion) for column, motion in motions.items()},
            "states": dict(experiment.states) if experiment else {},
            "differences": [vars(difference) for difference in self.differences],
        }


def suggest_experiment(
    diagnosis: Diagnosis,
    bounds: ExperimentBounds,
    simulator: MakeSimulator = Simulator,
    *,
    progress: Progress = silent,
) -> Suggestion:
    """Search the experiments that a rig can run for the one that decides between explanations.

    Rivals are the effects that a diagnosis cannot tell apart, its alternatives, and values of a
    number that trade places with others. Of each pair the difference counts that remains when one
    is fitted to the data of the other, see the module; of an experiment, the smallest of these.
    Experiments are sampled (Sobol), and the best is refined; the answer is the same each time. If
    none separates a pair by the columns measured before, the search is repeated with the further
    sensors of the bounds.

    Args:
        diagnosis: of `diagnose`.
        bounds: of the rig.
        simulator: makes the simulator of recordings, as in `diagnose`.
        progress: called with a label, how much is done, and of how much.

    Raises:
        UnknownNameError: the bounds name a column or parameter that the rig lacks.
        InvalidValueError: the diagnosis was not made by `diagnose`, the bounds call a parameter a
            state which is fitted to all recordings, or no recording of the model lies within them.
    """
    if diagnosis.search is None:
        raise InvalidValueError("this diagnosis does not hold the models that it compared")
    context, selection = diagnosis.search
    check_bounds(context.problem.recordings, bounds, simulator)
    progress("fit ties", 0, 1)
    ties = find_ties(context, selection, [a.fit for a in diagnosis.alternatives if a.fit])
    progress("fit ties", 1, 1)
    if not ties:
        return Suggestion(None, ())
    levels = _levels(context.problem, selection.final.fit)
    best = Suggestion(None, ())
    for besides in (False, True) if bounds.measure else (False,):
        family = Family(context.problem.recordings, bounds, besides)
        if besides:
            levels |= {column: float(m.noise or 0.0) for column, m in bounds.measure.items()}
        step = _step(family, simulator)
        rig = ExperimentSimulations(
            context.problem, context.base, levels, bounds.limits, simulator, step
        )
        tried = _Search(family, rig, ties, progress).run()
        if not besides or tried.decided > best.decided:
            best = tried
        if best.decided == len(best.differences):
            break
    return best


def _levels(problem: Problem, fitted: Fit) -> dict[str, float]:
    """Measured column → its noise, or the residual of the final model if that is larger."""
    left: dict[str, list[FloatArray]] = {}
    noise: dict[str, list[float]] = {}
    for k, column, rows in problem.signals:
        level = problem.noise[k][column]
        error = (fitted.residual[rows] * problem.levels[k][column])[problem.in_train[rows]]
        left.setdefault(column, []).append(error)
        noise.setdefault(column, []).append(level)
    return {
        column: max(float(np.median(noise[column])), _rms(np.concatenate(left[column])))
        for column in problem.recordings[0].measured
    }


def _step(family: Family, simulator: MakeSimulator) -> float:
    """Step of the simulations, in steps of the model: as long as a search allows."""
    middle = family.at(np.full(family.dimensions, 0.5), _NAME).recording
    made = Problem((middle,), simulator([middle]), all_samples([middle]))
    return search_step(made) or 1.0


@dataclass(frozen=True, eq=False)
class _Tried:
    """An experiment, and how far each pair differs in it."""

    point: FloatArray  # of the cube
    predictions: list[Predictions]  # of every alternative
    # (pairs,) rms difference [noise], of which a fit of one to the other may remove some
    most: FloatArray
    # (pairs,) the part that it cannot remove; None until the fit is made
    remaining: FloatArray | None = None


class _Search:
    def __init__(
        self, family: Family, rig: ExperimentSimulations, ties: Sequence[Tie], progress: Progress
    ) -> None:
        self.family, self.rig, self.progress = family, rig, progress
        self.alternatives = list(dict.fromkeys(a for tie in ties for a in tie))
        place = {a: k for k, a in enumerate(self.alternatives)}
        self.pairs = [(place[a], place[b]) for tie in ties for a, b in combinations(tie, 2)]
        self.adaptations = [Adaptation(a, rig.problem.in_train) for a in self.alternatives]

    def run(self) -> Suggestion:
        """Sample, fit the alternatives to each other where they differ most, and refine."""
        share = min(1.0, _ALTERNATIVES / len(self.alternatives))
        count = 2 ** int(np.log2(_SAMPLES * share))
        sobol = scipy.stats.qmc.Sobol(self.family.dimensions, seed=0)
        tried = self._simulate(sobol.random(count), "simulate experiments")
        best_first = max(4, int(_ADAPTED * share))
        every = np.ones(len(self.pairs), bool)
        tried = self._adapt_first(tried, every, best_first)
        for k in np.flatnonzero(self._largest(tried) < _APART):
            tried = self._adapt_first(tried, np.arange(every.size) == k, best_first)
        counts = self._largest(tried) >= _APART  # the pairs that some experiment separates
        if not counts.any():
            return self._suggestion(None, self._largest(tried))
        if not counts.all():
            tried = self._adapt_first(tried, counts, best_first)
        best = max(_adapted(tried), key=lambda t: _score(_known(t), counts))
        best = self._refine(best, counts)
        return self._suggestion(best, _known(best))

    def _refine(self, best: _Tried, counts: BoolArray) -> _Tried:
        """Try neighbours of the best, ever nearer, with motions of the same shapes."""
        random, reach = np.random.default_rng(0), _REACH[0]
        for _ in counted(self.progress, "refine the best", range(_ROUNDS)):
            points = best.point + reach * random.normal(size=(_NEIGHBOURS, best.point.size))
            points = np.clip(np.where(points > 1.0, 2.0 - points, np.abs(points)), 0.0, 1.0)
            points[:, self.family.shapes] = best.point[self.family.shapes]
            promising = [
                t
                for t in self._simulate(points, "")
                if _score(t.most, counts) > _score(_known(best), counts)
            ]
            better = [best, *self._adapt(promising)]
            best = max(better, key=lambda t: _score(_known(t), counts))
            reach *= _REACH[1]
        return best

    def _simulate(self, points: FloatArray, label: str) -> list[_Tried]:
        """Experiments in which every alternative stays within limits."""
        tried = list[_Tried]()
        for first in range(0, len(points), _BATCH):
            if label:
                self.progress(label, first, len(points))
            part = points[first : first + _BATCH]
            experiments = [self.family.at(p, f"{_NAME}_{k}") for k, p in enumerate(part)]
            predicted = self.rig.predict(experiments, self.alternatives)
            for point, row in zip(part, predicted, strict=True):
                if all(p.within_limits for p in row):
                    most = [_rms(row[a].readings - row[b].readings) for a, b in self.pairs]
                    tried.append(_Tried(point, row, np.array(most)))
        if label:
            self.progress(label, len(points), len(points))
        return tried

    def _adapt(self, tried: Sequence[_Tried]) -> list[_Tried]:
        """Fit the alternatives of each pair to each other, in each experiment."""
        if not tried:
            return []
        # by names of their own
        experiments = [self.family.at(t.point, f"{_NAME}_{k}") for k, t in enumerate(tried)]
        own = [list(terms) for terms in zip(*self.rig.sessions(experiments).values(), strict=True)]
        slopes = [
            self.rig.slopes(experiments, a, [t.predictions[k] for t in tried])
            for k, a in enumerate(self.alternatives)
        ]
        adapted = []
        for n, t in enumerate(tried):
            sessions = own[n] if own else []
            remaining = []
            for one, other in self.pairs:
                ways = []
                for a, b in ((one, other), (other, one)):
                    apart = t.predictions[b].readings - t.predictions[a].readings
                    ways.append(self.adaptations[b].remaining(slopes[b][n], apart, sessions))
                remaining.append(min(ways))
            adapted.append(replace(t, remaining=np.array(remaining)))
        return adapted

    def _adapt_first(self, tried: Sequence[_Tried], counts: BoolArray, number: int) -> list[_Tried]:
        """Adapt in those experiments in which the pairs that count differ most, if not done yet."""
        ranked = sorted(tried, key=lambda t: -_score(t.most, counts))
        first = [t for t in ranked[:number] if t.remaining is None]
        return [*self._adapt(first), *(t for t in ranked if t not in first)]

    def _largest(self, tried: Sequence[_Tried]) -> FloatArray:
        """(pairs,) largest difference that remains in any of the experiments."""
        reached = np.array([np.zeros(len(self.pairs)), *map(_known, _adapted(tried))])
        most: FloatArray = reached.max(axis=0)
        return most

    def _suggestion(self, best: _Tried | None, remaining: FloatArray) -> Suggestion:
        used = self.rig.problem.in_train
        differences = []
        for (a, b), reached in zip(self.pairs, remaining, strict=True):
            one, other = self.alternatives[a], self.alternatives[b]
            recorded = _rms((one.fit.residual - other.fit.residual)[used])
            differences.append(Difference(one.label, other.label, recorded, float(reached)))
        experiment = None if best is None else self.family.at(best.point, _NAME)
        return Suggestion(experiment, tuple(differences))


def _score(differences: FloatArray, counts: BoolArray) -> float:
    return float(differences[counts].min())


def _adapted(tried: Sequence[_Tried]) -> list[_Tried]:
    return [t for t in tried if t.remaining is not None]


def _known(tried: _Tried) -> FloatArray:
    assert tried.remaining is not None
    return tried.remaining


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
