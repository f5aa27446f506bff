"""Least-squares fit of a model's terms to recordings.

Gauss-Newton steps within the terms' ranges and a trust region. A simulation costs far more than a
step's algebra, and a Jacobian one for each term. It is therefore taken over from a fit nearby where
there is one, and each simulation that follows corrects it along the step just made (Broyden's
secant update); a fit that takes no Jacobian over ends only if its own, computed anew, finds no
more to gain.

Derivatives are differences. A term of one recording changes nothing in others. Terms that no
recording has in common are moved together, in one simulation; each gets the rows of its own
recordings, which are the same to the bit as if it had been moved alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Term
from tendon_mj.lab.parameter_names import recording_of
from tendon_mj.lab.replay import suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

DIFFERENCE = 1e-2  # of a probe: above the roughness of stick and slip, below curvature
_ROUGH = 0.3  # second over first difference: smooth rigs have a few hundredths
_AT_END = 1e-5, 1e-3  # of its range, and of its probe: a term this near to a bound is held by it
_TOLERANCE = 3e-3  # relative change of the cost, or of the terms, at which a round ends
_FAILED = 1e6  # residual of a failed simulation, in noise
_NEXT_ROUND = 3  # evaluations in each further round, which begins where the one before ended
_NEGLIGIBLE = 1e-3  # of the mean square residual: a smaller fall of χ² moves no value by its error
_ACTIVE_SETS = 100  # tried at most; some ten terms take as many
UNCHANGED = 0.02  # mean square [-] by which the correction has changed at most
_ROUNDS = 3
_REFIT = 6  # evaluations: a model changes little when a part of the data is left out
_FARTHEST = 1e9  # probes: a farther end of a range does not count


@dataclass(frozen=True, eq=False)
class Fit:
    """Terms of a model and the values at which they fit best."""

    calibrated: tuple[Term, ...]  # terms of the uncertain parameters; they come first
    effects: tuple[Candidate, ...]  # candidates in the model; their terms follow
    values: FloatArray  # (p,) of the terms [their units]
    residual: FloatArray  # (m,) of the problem at these values, extrapolated [-]
    correction: FloatArray  # (m,) extrapolated less simulated residual
    jacobian: FloatArray  # (m, p) by the scaled terms
    scaled: FloatArray  # (p,) values as the solver sees them
    bounds: FloatArray  # (2, p) of the scaled values

    @property
    def terms(self) -> tuple[Term, ...]:
        """All terms in the order of the values."""
        return (*self.calibrated, *(t for effect in self.effects for t in effect.terms))

    @property
    def weights(self) -> FloatArray:
        """(p,) by which a scaled term's deviation from inert counts as a residual."""
        return expected(self.terms)

    @property
    def shared(self) -> NDArray[np.bool_]:
        """(p,) which terms hold in all recordings, and are not of one alone."""
        return np.array([not recording_of(term.targets[0]) for term in self.terms], bool)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(p,) which terms are not held by a bound and change a residual.

        The low end of a strength at which the effect is absent is a value, not a bound.
        """
        low, high = self.bounds
        margin = _margin(self.bounds)
        inside = (self.scaled > low + margin) & (self.scaled < high - margin)
        for candidate in self.effects:
            strength, term = self.terms_of(candidate).start, candidate.terms[0]
            if term.low == candidate.effect.absent != term.inert:
                inside[strength] = self.scaled[strength] < (high - margin)[strength]
        visible = np.abs(self.jacobian).max(axis=0, initial=0.0) > 0.0
        free: NDArray[np.bool_] = inside & visible
        return free

    @property
    def targets(self) -> frozenset[str]:
        """Parameters that its effects write."""
        return frozenset[str]().union(*(effect.targets for effect in self.effects))

    def parameters(
        self, base: Mapping[str, float], values: FloatArray | None = None
    ) -> dict[str, float]:
        """Parameter → value that the terms write, fitted or at other ``values`` (p,)."""
        return written(self.terms, self.values if values is None else values, base)

    def responds_like(self, other: Fit) -> bool:
        """Return whether the terms of both change residuals alike.

        Their slopes s, s' are alike if the mean of |s − s'|² / |s| |s'| is below 1. Nothing is
        known of fits that have no terms in common.
        """
        slopes = dict(zip(other.terms, other.jacobian.T, strict=True))
        both = zip(self.terms, self.jacobian.T, strict=True)
        pairs = [(own, slopes[term]) for term, own in both if term in slopes]
        changes = [
            float(np.sum((own - its) ** 2)) / size
            for own, its in pairs
            if (size := float(np.linalg.norm(own) * np.linalg.norm(its)))
        ]
        return bool(changes) and sum(changes) < len(changes)

    def determines(self, candidate: Candidate) -> bool:
        """Return whether the data hold a candidate's strength, not an end of its range.

        Nor do they with a shape at its least: what then acts at once is another effect, as creep in
        no time is a softer cable.
        """
        own = self.terms_of(candidate)
        least = self.scaled[own] <= (self.bounds[0] + _margin(self.bounds))[own]
        shapes = np.array([bool(term.starts) for term in candidate.terms])
        return bool(self.free[own.start]) and not (least & shapes).any()

    def terms_of(self, candidate: Candidate) -> slice:
        """Position of one candidate's terms among the terms of the model."""
        before = self.effects[: self.effects.index(candidate)]
        first = len(self.calibrated) + sum(len(effect.terms) for effect in before)
        return slice(first, first + len(candidate.terms))


def inward(point: FloatArray, bounds: FloatArray) -> FloatArray:
    """(p,) sense away from the nearer of (2, p) bounds, −1 or 1."""
    return np.where(point > bounds.mean(axis=0), -1.0, 1.0)


def _margin(bounds: FloatArray) -> FloatArray:
    """(p,) distance from (2, p) bounds within which a scaled term is held by them."""
    margin: FloatArray = np.minimum(_AT_END[0] * (bounds[1] - bounds[0]), _AT_END[1])
    return margin


def expected(terms: Sequence[Term]) -> FloatArray:
    """(p,) probes of terms over the spread that is expected of them; 0 if none is."""
    return np.array([t.probe / t.spread if t.spread > 0.0 else 0.0 for t in terms])


def natural(terms: Sequence[Term], scaled: Sequence[float] | FloatArray) -> FloatArray:
    """(p,) values of terms [their units] from scaled ones, see `Term.natural`."""
    return np.array([term.natural(float(z)) for term, z in zip(terms, scaled, strict=True)])


def natural_in_range(terms: Sequence[Term], scaled: Sequence[float] | FloatArray) -> FloatArray:
    """`natural`, within the terms' ranges, which a step or rounding may leave."""
    low, high = [term.low for term in terms], [term.high for term in terms]
    return np.clip(natural(terms, scaled), low, high)


def written(
    terms: Sequence[Term], values: Sequence[float] | FloatArray, base: Mapping[str, float]
) -> dict[str, float]:
    """Parameter → value; terms relative to another parameter see the values of the others."""
    parameters: dict[str, float] = {}
    for relative in (False, True):  # to another parameter
        for term, value in zip(terms, values, strict=True):
            if bool(term.depends_on) == relative:
                parameters |= term.write(float(value), {**base, **parameters})
    return parameters


@suppress_unsolved_warnings()
def fit(
    problem: Problem,
    base: Mapping[str, float],
    calibrated: Sequence[Term],
    effects: Sequence[Candidate],
    start: FloatArray,
    *,
    correction: FloatArray | None = None,
    jacobian: FloatArray | None = None,
    seen: FloatArray | None = None,
    evaluations: int = 8,
) -> Fit:
    """Minimise the squared training residuals from ``start`` (p,) [the terms' units].

    The solver works in rounds. Within a round the correction of `Problem.extrapolate` keeps its
    value at the end of the previous round: it depends strongly on the step, weakly on the terms.

    A term with a `spread` adds its deviation from inert, over the spread, as one more residual.

    ``base`` is parameter → value of the model. What is known at or near ``start`` is not simulated
    again: ``correction`` (m,), ``seen`` (m,), the simulated residual, and ``jacobian`` (m, p) by
    the scaled terms, NaN in the columns of terms of which it is not known. ``evaluations`` are at
    most in the first round.
    """
    terms = (*calibrated, *(term for effect in effects for term in effect.terms))
    solver = _Solver(problem, base, terms, correction)
    begin = solver.interior(np.asarray(start, float))
    best = at = solver.solve(begin, evaluations, jacobian, seen)
    for _ in range(_ROUNDS - 1):
        ended = jacobian is not None or at.gained < _TOLERANCE * at.cost
        if ended and at.change <= UNCHANGED:
            break
        again = None if jacobian is None else at.jacobian
        at = solver.solve(at.point, _NEXT_ROUND, again, at.simulated)
        best = min(best, at, key=lambda solution: solution.cost)
    return Fit(
        calibrated=tuple(calibrated),
        effects=tuple(effects),
        values=natural(terms, best.point),
        residual=best.residual,
        correction=best.correction,
        jacobian=best.jacobian,
        scaled=best.point,
        bounds=solver.bounds,
    )


def fit_without(problem: Problem, base: Mapping[str, float], fitted: Fit, part: int) -> Fit:
    """The terms of a fit, fitted again to all data but one of the problem's `parts`."""
    return fit(
        problem.without(part),
        base,
        fitted.calibrated,
        fitted.effects,
        fitted.values,
        correction=fitted.correction,
        jacobian=fitted.jacobian,
        seen=fitted.residual - fitted.correction,
        evaluations=_REFIT,
    )


def near_differences(
    problem: Problem, base: Mapping[str, float], fitted: Fit
) -> tuple[float, float]:
    """Norms of the first and second difference of residuals over two steps as for derivatives.

    Where the response is smooth the second is small. Where the simulation rings from step to step
    rounding decides what it does: the second is √6 times what is random in one residual.
    """
    step = DIFFERENCE * inward(fitted.scaled, fitted.bounds)
    points = [natural_in_range(fitted.terms, fitted.scaled + k * step) for k in range(3)]
    near, middle, far = problem.residuals([written(fitted.terms, x, base) for x in points])
    used = problem.in_train & np.isfinite(near) & np.isfinite(middle) & np.isfinite(far)
    near, middle, far = near[used], middle[used], far[used]
    return float(np.linalg.norm(far - near)), float(np.linalg.norm(far - 2.0 * middle + near))


def rings(near: tuple[float, float]) -> bool:
    """Return whether rounding decides what a simulation does, by its `near_differences`."""
    return near[1] > _ROUGH * near[0]


@dataclass(frozen=True, eq=False)
class _Solution:
    """Result of one round."""

    point: FloatArray  # (p,) scaled terms
    simulated: FloatArray  # (m,) residual, not extrapolated
    # as in Fit
    residual: FloatArray
    correction: FloatArray
    jacobian: FloatArray
    cost: float  # mean square of the training residuals
    gained: float  # of the cost, in this round
    change: float  # of the correction since the round before, mean square


class _Solver:
    """Least squares over scaled terms, with long steps and a correction for them."""

    def __init__(
        self,
        problem: Problem,
        base: Mapping[str, float],
        terms: Sequence[Term],
        correction: FloatArray | None,
    ) -> None:
        self.problem, self.base, self.terms = problem, base, terms
        ends = [[t.scaled(t.low) for t in terms], [t.scaled(t.high) for t in terms]]
        self.bounds = np.clip(np.array(ends).reshape(2, -1), -_FARTHEST, _FARTHEST)
        self.correction = np.zeros(problem.in_train.size) if correction is None else correction
        self.weights = expected(terms)

    def interior(self, values: FloatArray) -> FloatArray:
        """(p,) scaled values, a little off their bounds."""
        point = np.array([t.scaled(v) for t, v in zip(self.terms, values, strict=True)])
        clipped: FloatArray = np.clip(point, *self._inside)
        return clipped

    @property
    def _inside(self) -> FloatArray:
        """(2, p) bounds, a little narrower."""
        inside: FloatArray = self.bounds + np.outer([0.5, -0.5], _margin(self.bounds))
        return inside

    def solve(
        self,
        point: FloatArray,
        evaluations: int,
        jacobian: FloatArray | None,
        seen: FloatArray | None,
    ) -> _Solution:
        """Run one round from a scaled point, and extrapolate where it ends."""
        used, radius = self.problem.in_train, 1.0
        residual = self._residual(point) if seen is None else seen
        matrix = self._jacobian(point, residual, jacobian)
        cost = first = self._cost(point, residual)
        for _ in range(evaluations - 1 if self.terms else 0):
            left = np.append(self._left(residual), self.weights * point)
            rows = np.vstack([matrix[used], np.diag(self.weights)])
            reach = radius * np.maximum(np.abs(point), 1.0)  # at least a probe
            step = bounded_least_squares(rows, left, np.clip(self._inside - point, -reach, reach))
            promised = cost - float(np.sum((left + rows @ step) ** 2))
            if promised <= _NEGLIGIBLE * cost / left.size:
                break
            there = self._residual(point + step)
            gained = cost - self._cost(point + step, there)
            if np.isfinite(there).all():
                matrix = self._secant(matrix, step, there - residual)
            share = float(np.max(np.abs(step) / np.maximum(np.abs(point), 1.0)))
            limited = share > 0.9 * radius
            converged = 0.25 * promised < gained < _TOLERANCE * cost and not limited
            if gained < 0.25 * promised:
                radius = 0.25 * share
            elif gained > 0.75 * promised and limited:
                radius *= 2.0
            if gained > 0.0:
                point, residual, cost = point + step, there, cost - gained
            if converged or share < _TOLERANCE:
                break
        extrapolated = self.problem.extrapolate(self._parameters(point), residual)
        before = self.correction
        with np.errstate(invalid="ignore"):
            added = extrapolated - residual
            self.correction = np.where(np.isfinite(added), added, 0.0)
        return _Solution(
            point,
            residual,
            extrapolated,
            self.correction,
            matrix,
            cost=float(np.mean(extrapolated[used] ** 2)),
            gained=(first - cost) / np.count_nonzero(used),
            change=float(np.mean((self.correction - before)[used] ** 2)),
        )

    def _parameters(self, point: FloatArray) -> dict[str, float]:
        return written(self.terms, natural(self.terms, point), self.base)

    def _residual(self, point: FloatArray) -> FloatArray:
        row: FloatArray = self.problem.residuals([self._parameters(point)])[0]
        return row

    def _left(self, residual: FloatArray) -> FloatArray:
        """(training samples,) corrected residuals; a failed simulation's are large."""
        rows = (residual + self.correction)[self.problem.in_train]
        return np.where(np.isfinite(rows), rows, _FAILED)

    def _cost(self, point: FloatArray, residual: FloatArray) -> float:
        own = self.weights * point
        return float(np.sum(self._left(residual) ** 2) + own @ own)

    def _jacobian(
        self, point: FloatArray, residual: FloatArray, known: FloatArray | None
    ) -> FloatArray:
        """(m, p) by one-sided differences, away from the nearer bound, where it is not known."""
        matrix = np.full((residual.size, point.size), np.nan) if known is None else known.copy()
        wanted = np.isnan(matrix).all(axis=0)
        if wanted.any():
            step = DIFFERENCE * inward(point, self.bounds) * wanted
            found = differences(self.problem, self.terms, self._parameters, point, step, residual)
            matrix[:, wanted] = found[:, wanted]
        return np.nan_to_num(matrix, copy=False, posinf=0.0, neginf=0.0)

    def _secant(self, matrix: FloatArray, step: FloatArray, change: FloatArray) -> FloatArray:
        """The Jacobian corrected along a step; where a term changes nothing, it stays 0.

        Cross-validation tells by it which samples a term of one recording, or an event, is in.
        """
        own = np.where(matrix != 0.0, step, 0.0)
        length = np.maximum((own**2).sum(axis=1), DIFFERENCE**2)  # shorter, it is roughness
        corrected: FloatArray = matrix + own * ((change - matrix @ step) / length)[:, None]
        return corrected


def bounded_least_squares(
    matrix: FloatArray, residual: FloatArray, bounds: FloatArray
) -> FloatArray:
    """(p,) step x that minimises |r + M x| within ``bounds`` (2, p).

    By active sets on columns of length 1: SciPy's other method never ends where their lengths
    differ by more than a number has digits.
    """
    normal = matrix.T @ matrix
    normal += 1e-9 * np.diag(np.diag(normal)) + 1e-12 * np.eye(len(normal))
    lengths = np.sqrt(np.diag(normal))
    factor = cholesky(normal / np.outer(lengths, lengths))  # (p, p) in place of all samples
    aim = solve_triangular(factor, -(matrix.T @ residual) / lengths, trans="T")
    scaled = scipy.optimize.lsq_linear(
        factor, aim, bounds * lengths, method="bvls", max_iter=_ACTIVE_SETS
    ).x
    step: FloatArray = np.clip(scaled / lengths, bounds[0], bounds[1])
    return step


def differences(
    problem: Problem,
    terms: Sequence[Term],
    parameters: Callable[[FloatArray], dict[str, float]],
    point: FloatArray,
    step: FloatArray,
    residual: FloatArray,
) -> FloatArray:
    """(m, p) derivatives of the residuals by scaled terms; infinite if a simulation failed.

    ``parameters`` maps scaled terms (p,) to parameters; at ``point`` (p,), where the residual is
    ``residual`` (m,), each term is moved by its ``step`` (p,). If that is 0, so is the column.
    """
    acting = [recordings_of(term, problem) for term in terms]
    wanted, numbers = np.flatnonzero(step), np.arange(point.size)
    groups = [wanted[group] for group in _disjoint([acting[k] for k in wanted])]

    def moved(members: Sequence[int] | NDArray[np.intp]) -> dict[str, float]:
        return parameters(point + np.where(np.isin(numbers, members), step, 0.0))

    matrix = np.zeros((residual.size, point.size))
    if not groups:
        return matrix
    changes = problem.residuals([moved(members) for members in groups]) - residual
    for members, change in zip(groups, changes, strict=True):
        for k in members:
            own = change
            if len(members) > 1 and not np.isfinite(change).all():  # maybe by another's fault
                own = problem.residuals([moved([k])])[0] - residual
            elif len(members) > 1:
                own = np.where(np.isin(problem.recording_of, list(acting[k])), change, 0.0)
            matrix[:, k] = own / step[k]
    return matrix


def recordings_of(term: Term, problem: Problem) -> frozenset[int]:
    """Numbers of the recordings that a term may change."""
    names = {recording_of(target) for target in term.targets}
    return frozenset(
        k for k, one in enumerate(problem.recordings) if "" in names or one.name in names
    )


def _disjoint(recordings: Sequence[frozenset[int]]) -> list[list[int]]:
    """Groups of terms that no recording has in common; each term is in one."""
    groups: list[tuple[set[int], list[int]]] = []
    for k, own in enumerate(recordings):
        for taken, members in groups:
            if not taken & own:
                taken |= own
                members.append(k)
                break
        else:
            groups.append((set(own), [k]))
    return [members for _, members in groups]
