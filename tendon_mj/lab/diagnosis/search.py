"""Screening of candidates for a residual, and ways out of a local minimum.

Screening fits no candidate. Each is switched on by a little. Its trace t in the residuals and the
Jacobian J of the fitted terms predict, to first order, with which strength and which corrections of
the others the residual r would be smallest: min |r + J Δ + t a|. The next pass simulates just that
point, which gives the true remainder and the change of the trace; candidates that promise little
drop out. The trace of a wide play is nothing like that of a narrow one: such effects are also
switched on by more, and go on from the strength that promises most. Where the model's own terms
still change the response alike, so do candidates: their traces at a fit before take the place of
the first pass.

Where a tendon or a joint sticks and slips, least squares ends in the local minimum where it began.
Most of that misfit lies in the few samples between one slip and the other. A logarithm of the
squares (Cauchy loss) is robust to them, and slopes over a distance, by which the response should
change by as much as the fit leaves, see through what is rough on a smaller scale. Gauss-Newton
steps with both lead down in some ten simulations each, and end where the response is linear over
such distances; a fit follows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.fitting import (
    Fit,
    bounded_least_squares,
    natural,
    natural_in_range,
    written,
)
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.replay import suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_INVISIBLE = 1e-8  # mean square trace, in noise, below which an effect has no place on a model
_LARGER, _TRIES = 1e3, 3  # factor by which a probe without a trace is enlarged, and how often
_BATCH = 8  # parameter sets simulated between two calls of the progress callback
_PASSES = ("screen, first pass", "screen, second pass", "screen, third pass")

_LONGEST = 0.1  # of its range: the step of a term
_NONLINEAR = 0.2  # of the mean square change of the response, at most
_DESCENTS = 10  # steps with slopes over a distance
_SHARES = 1.0, 0.5, 0.2  # of such a step, that are tried
_DISTANCES = 1.0, 0.2, 0.04, math.inf  # of what is left, that they should explain; the longest
_LESS = 0.98  # of the loss, which a step has to leave
_OUTLIER = 3.0  # scale of the Cauchy loss [noise]


@dataclass(frozen=True, eq=False)
class ScreeningScore:
    """Reduction of χ² that screening finds for a candidate."""

    candidate: Candidate  # screened effect
    # (fitted terms and the candidate's,) values to begin a fit from [their units]
    start: FloatArray
    explained: float  # reduction of the reduced χ² at these values [-]
    attempt: int  # which of the candidate's starts it came from
    seen: FloatArray | None = None  # (m,) simulated residual at these values

    @property
    def key(self) -> tuple[str, int]:
        """Candidate and attempt."""
        return self.candidate.label, self.attempt

    def slope(self, fitted: Fit) -> FloatArray:
        """(m,) derivative by the scaled strength, from the fit to here."""
        assert self.seen is not None
        count, strength = len(fitted.terms), self.candidate.terms[0]
        moved = [t.scaled(v) for t, v in zip(fitted.terms, self.start[:count], strict=True)]
        trace = self.seen + fitted.correction - fitted.residual
        trace -= fitted.jacobian @ (np.array(moved) - fitted.scaled)
        return trace / strength.scaled(float(self.start[count]))

    def jacobian(self, fitted: Fit) -> FloatArray:
        """(m, p) derivatives by the scaled terms; NaN for those of a shape, and of an event.

        If an event is not, its slope has what is not linear in the others, and should be 0.
        """
        matrix = np.full((fitted.residual.size, len(self.start)), np.nan)
        matrix[:, : len(fitted.terms)] = fitted.jacobian
        if not self.candidate.effect.event:
            matrix[:, len(fitted.terms)] = self.slope(fitted)
        return matrix


_Pair = tuple[ScreeningScore, ScreeningScore]  # simulated, and predicted at the best strength
Slopes = dict[tuple[str, int], FloatArray]  # key of a score → its slope


@suppress_unsolved_warnings()
def screen(
    problem: Problem,
    base: Mapping[str, float],
    fitted: Fit,
    candidates: Sequence[Candidate],
    progress: Progress,
    known: Slopes,
    kept: Sequence[float],
) -> list[ScreeningScore]:
    """Score candidates that change the residual of a fit, best first, once for each start.

    Slopes that are ``known`` from another fit predict in place of the first pass; others are added,
    0 of what leaves no trace, which is not simulated again.
    ``kept`` are shares of the best reduction of χ², to be in the second and in the third pass;
    empty: there is the first pass alone.
    """
    scores = [score for candidate in candidates for score in starts(fitted, candidate)]
    screening = _Screening(problem, base, fitted, progress)
    predicted = [
        screening.predict(s, known[s.key]) for s in scores if s.key in known and known[s.key].any()
    ]
    new = [score for score in scores if score.key not in known]
    seen = screening.run(new, _PASSES[0])
    seen += screening.enlarge_probes(new, seen)
    lasting = [score for score in new if not score.candidate.effect.event]
    slopes = {score.key: score.slope(fitted) for score, _ in seen}
    known |= {s.key: slopes.get(s.key, np.zeros(fitted.residual.size)) for s in lasting}
    achieved = [score for score, _ in seen]
    for share, label in zip(kept, _PASSES[1:], strict=False):
        predicted = _ranked(
            [*predicted, *(prediction for _, prediction in seen)], len(fitted.terms)
        )
        seen, predicted = screening.run(_promising(predicted, share), label), []
        achieved += [score for score, _ in seen]
    return _promising(_ranked(achieved, len(fitted.terms)), 0.0)


def _ranked(scores: Sequence[ScreeningScore], fitted: int) -> list[ScreeningScore]:
    """The best strength of each candidate and shape, best first; ``fitted`` terms precede it."""
    ranked = sorted(scores, key=lambda score: -score.explained)
    shapes = [(score.candidate.label, *score.start[fitted + 1 :]) for score in ranked]
    first = dict(zip(reversed(shapes), reversed(ranked), strict=True))
    return [score for shape, score in zip(shapes, ranked, strict=True) if score is first[shape]]


def starts(fitted: Fit, candidate: Candidate) -> list[ScreeningScore]:
    """Where the screening of a candidate begins: each strength, once for each shape."""
    strength, *shape = candidate.terms
    values = [(_probe(candidate), *strength.larger), *(t.starts or (t.inert,) for t in shape)]
    return [
        ScreeningScore(candidate, np.array([*fitted.values, *own]), 0.0, k)
        for k, own in enumerate(product(*values))
    ]


def _promising(scores: Sequence[ScreeningScore], share: float) -> list[ScreeningScore]:
    least = share * max((score.explained for score in scores), default=0.0)
    return [score for score in scores if score.explained > 0.0 and score.explained >= least]


@dataclass(frozen=True, eq=False)
class _Screening:
    """Simulations of candidates added to one fitted model."""

    problem: Problem
    base: Mapping[str, float]
    fitted: Fit
    progress: Progress

    def run(self, scores: Sequence[ScreeningScore], label: str) -> list[_Pair]:
        """Score each where it stands, and predict where it would explain most."""
        seen = []
        for k in range(0, len(scores), _BATCH):
            self.progress(label, k, len(scores))
            part = scores[k : k + _BATCH]
            sets = [
                written((*self.fitted.terms, *s.candidate.terms), s.start, self.base) for s in part
            ]
            for score, row in zip(part, self.problem.residuals(sets), strict=True):
                if np.isfinite(row).all():
                    seen += self._score(replace(score, seen=row))
        if scores:
            self.progress(label, len(scores), len(scores))
        return seen

    def enlarge_probes(
        self, scores: Sequence[ScreeningScore], seen: Sequence[_Pair]
    ) -> list[_Pair]:
        """Screen those that left no trace again, with larger probes.

        A probe that is large for a hinge, in N m/rad, is negligible for a slide, in N/m.
        """
        larger: list[_Pair] = []
        for _ in range(_TRIES):
            traced = {score.key for score, _ in [*seen, *larger]}
            scores = [
                _enlarged(score, len(self.fitted.terms))
                for score in scores
                if score.key not in traced
            ]
            if not scores:
                break
            larger += self.run(scores, _PASSES[0])
        return larger

    def _score(self, score: ScreeningScore) -> list[_Pair]:
        """Score one simulation of a candidate; nothing if it leaves no trace."""
        assert score.seen is not None
        fitted, used = self.fitted, self.problem.in_train
        row, residual = (score.seen + fitted.correction)[used], fitted.residual[used]
        strength, terms, count = score.candidate.terms[0], fitted.terms, len(fitted.terms)
        tried = score.start[count] - strength.inert
        if tried == 0.0:
            return []
        slope = score.slope(fitted)
        if np.mean((slope[used] * tried / strength.probe) ** 2) < _INVISIBLE:
            return []
        achieved = replace(score, explained=float(residual @ residual - row @ row) / row.size)
        if achieved.explained < 0.0 < score.explained:
            return [(achieved, _shortened(score, natural(terms, fitted.scaled)))]
        return [(achieved, self.predict(score, slope))]

    def predict(self, score: ScreeningScore, slope: FloatArray) -> ScreeningScore:
        """Where a candidate would explain most, by its slope (m,), and how much."""
        fitted, used, count = self.fitted, self.problem.in_train, len(self.fitted.terms)
        strength, terms = score.candidate.terms[0], fitted.terms
        matrix = np.column_stack([fitted.jacobian, slope])[used]
        ends = [strength.scaled(strength.low), strength.scaled(strength.high)]
        bounds = np.column_stack([fitted.bounds - fitted.scaled, ends])
        residual = fitted.residual[used]
        step = bounded_least_squares(matrix, residual, bounds)
        left = residual + matrix @ step
        values = natural_in_range(terms, fitted.scaled + step[:-1])
        best = min(max(strength.natural(float(step[-1])), strength.low), strength.high)
        return replace(
            score,
            start=np.array([*values, best, *score.start[count + 1 :]]),
            explained=float(residual @ residual - left @ left) / residual.size,
            seen=None,
        )


def _shortened(score: ScreeningScore, values: FloatArray) -> ScreeningScore:
    """Score half way back to the fit's ``values``, where the prediction failed."""
    count = values.size
    strength = score.candidate.terms[0]
    origin = np.array([*values, strength.inert, *score.start[count + 1 :]])
    return replace(score, start=0.5 * (origin + score.start), explained=0.5 * score.explained)


def _enlarged(score: ScreeningScore, index: int) -> ScreeningScore:
    """Score of the candidate with a larger probe; ``index`` of its strength among the values."""
    strength, *shape = score.candidate.terms
    span = max(strength.high - strength.inert, strength.inert - strength.low)
    strength = replace(strength, probe=min(_LARGER * strength.probe, span))
    candidate = replace(score.candidate, terms=(strength, *shape))
    start = score.start.copy()
    start[index] = _probe(candidate)
    return replace(score, candidate=candidate, start=start)


def _probe(candidate: Candidate) -> float:
    """Strength a probe away from inert, on the side where the range allows it."""
    term = candidate.terms[0]
    return term.inert + (term.probe if term.high - term.inert >= term.probe else -term.probe)


@suppress_unsolved_warnings()
def descend(problem: Problem, base: Mapping[str, float], fitted: Fit) -> FloatArray | None:
    """(p,) values of a fit's terms that leave less, None where no other minimum is in reach.

    Gauss-Newton steps on a robust loss, with slopes over the distances in which the response should
    change by what is left, then over shorter ones, and at last over the longest. They end where
    that linearisation holds, or nothing is gained.
    """
    used = problem.in_train
    point, residual = fitted.scaled, fitted.residual[used]
    slopes = fitted.jacobian[used] * _slope_of_robust(residual)[:, np.newaxis]
    residual, distance, improved = _robust(residual), 0, False
    for _ in range(_DESCENTS):
        points = _within_reach(fitted, point, slopes, residual, _DISTANCES[distance])
        linear = (points - point) @ slopes.T
        rows = _robust(_simulated(problem, base, fitted, points))
        rows = np.where(np.isfinite(rows), rows, residual + linear)  # where one failed
        if distance == 0 and _are_linear(rows - residual, linear):
            break
        ahead, behind = np.split(points, 2)
        across = np.maximum(np.diag(ahead - behind), np.finfo(float).tiny)
        slopes = ((rows[: len(point)] - rows[len(point) :]) / across[:, np.newaxis]).T
        step = bounded_least_squares(slopes, residual, fitted.bounds - point)
        steps = point + np.outer(_SHARES, step)
        points = np.vstack([points, steps])
        rows = np.vstack([rows, _robust(_simulated(problem, base, fitted, steps))])
        best = int(np.nanargmin(np.sum(rows**2, axis=1)))
        if np.sum(rows[best] ** 2) < _LESS * np.sum(residual**2):
            point, residual, improved = points[best], rows[best], True
        else:
            distance += 1
            if distance == len(_DISTANCES):
                break
    return natural(fitted.terms, point) if improved else None


def _robust(residual: FloatArray) -> FloatArray:
    """Residuals whose squares are the Cauchy loss, so that few large ones do not outweigh many."""
    size: FloatArray = _OUTLIER * np.sqrt(np.log1p((residual / _OUTLIER) ** 2))
    return np.copysign(size, residual)


def _slope_of_robust(residual: FloatArray) -> FloatArray:
    """Derivative of `_robust`."""
    squares = np.maximum((residual / _OUTLIER) ** 2, np.finfo(float).tiny)
    return np.sqrt(squares / np.log1p(squares)) / (1.0 + squares)


def _are_linear(changes: FloatArray, linear: FloatArray) -> bool:
    """Return whether changes of the response are as their linearisation says."""
    return bool(np.sum((changes - linear) ** 2) < _NONLINEAR * np.sum(changes**2))


def _within_reach(
    fitted: Fit, point: FloatArray, slopes: FloatArray, residual: FloatArray, share: float
) -> FloatArray:
    """(2p, p) points a step ahead and behind by each term, a share of what is left by its slope."""
    longest = _LONGEST * np.ptp(fitted.bounds, axis=0)
    left = share * np.sqrt(max(float(np.mean(residual**2)) - 1.0, np.finfo(float).tiny))
    steep = np.sqrt(np.mean(slopes**2, axis=0))
    reach = np.divide(left, steep, out=longest.copy(), where=steep * longest > left)
    points: FloatArray = np.clip(
        point + np.vstack([np.diag(reach), -np.diag(reach)]), *fitted.bounds
    )
    return points


def _simulated(
    problem: Problem, base: Mapping[str, float], fitted: Fit, points: FloatArray
) -> FloatArray:
    """(points, training samples) residuals, with the correction of a fit."""
    sets = [fitted.parameters(base, natural(fitted.terms, point)) for point in points]
    return (problem.residuals(sets) + fitted.correction)[:, problem.in_train]
