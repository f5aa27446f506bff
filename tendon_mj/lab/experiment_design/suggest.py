"""Search for the experiment, within bounds, in which models that tie differ most against noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import (
    SMALLEST_EXCESS,
    Diagnosis,
    Fit,
    MakeSimulator,
    Problem,
    all_samples,
    search_step,
)
from tendon_mj.lab.experiment_design.experiment import (
    Experiment,
    ExperimentBounds,
    Family,
    check_bounds,
)
from tendon_mj.lab.experiment_design.separation import (
    Adaptation,
    ExperimentSimulations,
    Predictions,
    Tie,
    find_ties,
)
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import BoolArray, FloatArray

_NAME = "next"
_SEED = 0
_SAMPLES, _ADAPTED = 64, 12  # experiments that are simulated; those to which models are fitted
_ROUNDS, _NEIGHBOURS = 4, 6  # of the refinement, and experiments in each
_REACH = 0.25, 0.6  # of the cube, of the first round; factor from round to round
_ALTERNATIVES = 2  # for more of them fewer experiments are tried
_BATCH = 8  # experiments simulated between two calls of the progress callback
_APART = float(np.sqrt(SMALLEST_EXCESS))  # noise, rms: less is not worth a name


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
        experiment: to be run; None where nothing ties, or nothing within the bounds decides.
        differences: of every two explanations that tie.
    """

    experiment: Experiment | None
    differences: tuple[Difference, ...]

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
        """Write the template as ``<stem>.csv`` and ``<stem>.toml``; None where there is none."""
        return None if self.recording is None else write_recording(self.recording, path)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        experiment = self.experiment
        return {
            "sentence": self.sentence,
            "motions": {
                column: vars(motion)
                for column, motion in (experiment.motions if experiment else {}).items()
            },
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

    Rivals are the effects that a diagnosis cannot tell apart, and values of a number that trade
    places with others. Of each pair the difference counts that remains when one is fitted to the
    data of the other, see `separation`; of an experiment, the smallest of these. Experiments are
    sampled (Sobol), and the best is refined; the answer is the same each time. If none separates a
    pair by the columns measured before, the search is repeated with the further sensors of the
    bounds.

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
    ties = find_ties(context, selection)
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
        left.setdefault(column, []).append(fitted.residual[rows][problem.in_train[rows]] * level)
        noise.setdefault(column, []).append(level)
    return {
        column: max(
            float(np.median(noise[column])),
            float(np.sqrt(np.mean(np.concatenate(left[column]) ** 2))),
        )
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
        self.alternatives = [a for tie in ties for a in tie]
        place = {a: k for k, a in enumerate(self.alternatives)}
        self.pairs = [(place[a], place[b]) for tie in ties for a, b in combinations(tie, 2)]
        self.adaptations = [Adaptation(a, rig.problem.in_train) for a in self.alternatives]

    def run(self) -> Suggestion:
        """Sample, fit the alternatives to each other where they differ most, and refine."""
        share = min(1.0, _ALTERNATIVES / len(self.alternatives))
        count = 2 ** int(np.log2(_SAMPLES * share))
        sobol = qmc.Sobol(self.family.dimensions, seed=_SEED)
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
        random, reach = np.random.default_rng(_SEED), _REACH[0]
        label = "refine the best"
        for k in range(_ROUNDS):
            self.progress(label, k, _ROUNDS)
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
        self.progress(label, _ROUNDS, _ROUNDS)
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
        experiments = [
            self.family.at(t.point, f"{_NAME}_{k}") for k, t in enumerate(tried)
        ]  # by names of their own
        own = [list(terms) for terms in zip(*self.rig.sessions(experiments).values(), strict=True)]
        slopes = [
            self.rig.slopes(experiments, a, [t.predictions[k] for t in tried])
            for k, a in enumerate(self.alternatives)
        ]
        adapted = []
        for n, t in enumerate(tried):
            sessions = own[n] if own else []
            remaining = np.array(
                [
                    min(
                        self.adaptations[b].remaining(
                            slopes[b][n],
                            t.predictions[b].readings - t.predictions[a].readings,
                            sessions,
                        )
                        for a, b in ((one, other), (other, one))
                    )
                    for one, other in self.pairs
                ]
            )
            adapted.append(replace(t, remaining=remaining))
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
    """Smallest difference of the pairs that count."""
    return float(differences[counts].min())


def _adapted(tried: Sequence[_Tried]) -> list[_Tried]:
    return [t for t in tried if t.remaining is not None]


def _known(tried: _Tried) -> FloatArray:
    assert tried.remaining is not None
    return tried.remaining


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
