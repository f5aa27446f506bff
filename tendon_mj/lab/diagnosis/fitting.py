"""Least-squares fit of a model's terms to recordings.

SciPy's trust-region solver keeps to bounds and stops after a given number of simulations, so that
a candidate that does not fit costs no more than one that does. `mujoco.minimize`, which
`mujoco.sysid` uses, searches its damping until a step succeeds, up to a hundred simulations where
stick and slip make the cost non-smooth.

Derivatives are differences. A term of one recording changes nothing in others. Terms that no
recording has in common are moved together, in one simulation; each gets the rows of its own
recordings, which are the same to the bit as if it had been moved alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Term
from tendon_mj.lab.replay import recording_of, suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_DIFFERENCE = 1e-2  # of a probe: above the roughness of stick and slip, below curvature
_AT_END = 1e-5, 1e-3  # of its range, and of its probe: a term this near to a bound is held by it
_TOLERANCE = 3e-3  # relative change of the cost, or of the terms, at which a round ends
_FAILED = 1e6  # residual of a failed simulation, in noise
_NEXT_ROUND = 3  # evaluations in each further round, which begins where the one before ended
_FLAT = float(np.finfo(float).eps)  # no term does anything: SciPy's step would be 0/0
_UNCHANGED = 0.02  # mean square [-] by which the correction has changed at most
_ROUNDS = 3
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

    def parameters(
        self, base: Mapping[str, float], values: FloatArray | None = None
    ) -> dict[str, float]:
        """Parameter → value that the terms write, fitted or at other ``values`` (p,)."""
        return written(self.terms, self.values if values is None else values, base)

    def determines(self, candidate: Candidate) -> bool:
        """Whether a candidate's strength is held by the data, not by an end of its range."""
        return bool(self.free[self.terms_of(candidate).start])

    def terms_of(self, candidate: Candidate) -> slice:
        """Position of one candidate's terms among the terms of the model."""
        before = self.effects[: self.effects.index(candidate)]
        first = len(self.calibrated) + sum(len(effect.terms) for effect in before)
        return slice(first, first + len(candidate.terms))


def _margin(bounds: FloatArray) -> FloatArray:
    """(p,) distance from (2, p) bounds within which a scaled term is held by them."""
    margin: FloatArray = np.minimum(_AT_END[0] * (bounds[1] - bounds[0]), _AT_END[1])
    return margin


def expected(terms: Sequence[Term]) -> FloatArray:
    """(p,) probes of terms over the spread that is expected of them; 0 where none is."""
    return np.array([t.probe / t.spread if t.spread > 0.0 else 0.0 for t in terms])


def natural(terms: Sequence[Term], scaled: Sequence[float] | FloatArray) -> FloatArray:
    """(p,) values of terms [their units] from scaled ones, see `Term.natural`."""
    return np.array([term.natural(float(z)) for term, z in zip(terms, scaled, strict=True)])


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
    evaluations: int = 8,
) -> Fit:
    """Minimise the squared training residuals from ``start`` (p,) [the terms' units].

    The solver works in rounds. Within a round the correction of `Problem.extrapolate` keeps its
    value at the end of the previous round: it depends strongly on the step, weakly on the terms.

    A term with a `spread` adds its deviation from inert, over the spread, as one more residual.

    ``base`` is parameter → value of the model, ``correction`` (m,) is that near ``start``, if it is
    known, and ``evaluations`` are at most in the first round.
    """
    terms = (*calibrated, *(term for effect in effects for term in effect.terms))
    solver = _Solver(problem, base, terms, correction)
    best = at = solver.solve(solver.interior(np.asarray(start, float)), evaluations)
    for _ in range(_ROUNDS - 1):
        if at.change <= _UNCHANGED:
            break
        again = solver.interior(natural(terms, at.point))
        at = solver.solve(again, _NEXT_ROUND)
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


@dataclass(frozen=True, eq=False)
class _Solution:
    """Result of one round."""

    point: FloatArray  # (p,) scaled terms
    # as in Fit
    residual: FloatArray
    correction: FloatArray
    jacobian: FloatArray
    cost: float  # mean square of the training residuals
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
        self.own = self.weights > 0.0
        self._simulated: dict[bytes, FloatArray] = {}
        self._jacobian: dict[bytes, FloatArray] = {}

    def interior(self, values: FloatArray) -> FloatArray:
        """(p,) scaled values, a little off their bounds."""
        point = np.array([t.scaled(v) for t, v in zip(self.terms, values, strict=True)])
        margin = 0.5 * _margin(self.bounds)
        clipped: FloatArray = np.clip(point, self.bounds[0] + margin, self.bounds[1] - margin)
        return clipped

    def solve(self, point: FloatArray, evaluations: int) -> _Solution:
        """Run one round from a scaled point, and extrapolate where it ends."""
        jacobian = np.zeros((self.problem.in_train.size, 0))
        if self.terms:
            # SciPy's first step is as long as its variables are large: at least one probe each
            shift = np.where(np.abs(point) < 1.0, np.copysign(1.0, point) - point, 0.0)
            solution = least_squares(
                lambda moved: self._train_residual(moved - shift),
                point + shift,
                jac=lambda moved: self._train_jacobian(moved - shift),
                bounds=(self.bounds[0] + shift, self.bounds[1] + shift),
                ftol=_TOLERANCE,
                xtol=_TOLERANCE,
                gtol=_FLAT,
                max_nfev=evaluations,
            )
            point = solution.x - shift
            jacobian = next(iter(self._jacobian.values()))  # maybe of the last point but one
        coarse = self._residual(point)
        residual = self.problem.extrapolate(self._parameters(point), coarse)
        before, used = self.correction, self.problem.in_train
        with np.errstate(invalid="ignore"):
            added = residual - coarse
            self.correction = np.where(np.isfinite(added), added, 0.0)
        cost = float(np.mean(residual[used] ** 2))
        change = float(np.mean((self.correction - before)[used] ** 2))
        return _Solution(point, residual, self.correction, jacobian, cost, change)

    def _parameters(self, point: FloatArray) -> dict[str, float]:
        return written(self.terms, natural(self.terms, point), self.base)

    def _residual(self, point: FloatArray) -> FloatArray:
        key = point.tobytes()
        if key not in self._simulated:
            self._simulated[key] = self.problem.residuals([self._parameters(point)])[0]
        return self._simulated[key]

    def _train_residual(self, point: FloatArray) -> FloatArray:
        rows = (self._residual(point) + self.correction)[self.problem.in_train]
        return np.append(
            np.where(np.isfinite(rows), rows, _FAILED), (self.weights * point)[self.own]
        )

    def _train_jacobian(self, point: FloatArray) -> FloatArray:
        """(training samples, p) by one-sided differences, away from the nearer bound."""
        key = point.tobytes()
        if key not in self._jacobian:
            step = np.where(point > self.bounds.mean(axis=0), -_DIFFERENCE, _DIFFERENCE)
            matrix = differences(
                self.problem, self.terms, self._parameters, point, step, self._residual(point)
            )
            self._jacobian.clear()  # a minute of recordings is megabytes
            self._jacobian[key] = np.nan_to_num(matrix, posinf=0.0, neginf=0.0)
        rows = self._jacobian[key][self.problem.in_train]
        return np.vstack([rows, np.diag(self.weights)[self.own]])


def differences(
    problem: Problem,
    terms: Sequence[Term],
    parameters: Callable[[FloatArray], dict[str, float]],
    point: FloatArray,
    step: FloatArray,
    residual: FloatArray,
) -> FloatArray:
    """(m, p) derivatives of the residuals by scaled terms; infinite where a simulation failed.

    ``parameters`` maps scaled terms (p,) to parameters; at ``point`` (p,), where the residual is
    ``residual`` (m,), each term is moved by its ``step`` (p,).
    """
    acting = [recordings_of(term, problem) for term in terms]
    groups = _disjoint(acting)
    numbers = np.arange(point.size)

    def moved(members: list[int]) -> dict[str, float]:
        return parameters(point + np.where(np.isin(numbers, members), step, 0.0))

    changes = problem.residuals([moved(members) for members in groups]) - residual
    matrix = np.zeros((residual.size, point.size))
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
