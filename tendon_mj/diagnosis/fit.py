"""Fits terms of a model to recordings by least squares.

Through SciPy's trust region, which keeps to bounds and ends after so many simulations: a candidate
that does not fit is to cost no more than one that does. `mujoco.minimize`, and `mujoco.sysid` with
it, searches its damping until a step succeeds, up to a hundred simulations where stick
and slip make the response rough. What `mujoco.sysid` makes of the same data is what a diagnosis is
compared with, see `tendon_mj.diagnosis.sysid`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendon_mj.diagnosis.effects.effect import Candidate, Term
from tendon_mj.diagnosis.problem import Problem
from tendon_mj.replay.suppression import suppress_unsolved_warnings

FloatArray = NDArray[np.float64]

_DIFFERENCE = 1e-2  # of a probe: above the grain of stick and slip, below what bends the response
_AT_END = 1e-5, 1e-3  # of its range, and of its probe: nearer to an end a term is held by it
_HOPELESS = 1e6  # what a failed simulation counts as, in noise
_AGAIN = 3  # points in each further round, which begins where the one before ended
_FLAT = float(np.finfo(float).eps)  # no term does anything: SciPy's step would be 0/0
_SETTLED = 0.02  # mean square [noise power]: what refining adds has changed by less
_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Fit:
    """Terms and the values at which they fit best.

    Attributes:
        calibrated: terms of what the recordings call uncertain; they come first.
        effects: candidates in the model, whose terms follow.
        values: (p,) of the terms [their units].
        residual: (m,) of the problem at these values, refined [-].
        refined: (m,) what refining has added to it.
        jacobian: (m, p) by the scaled terms.
        scaled: (p,) the terms as the fit saw them.
        bounds: (2, p) of these.
    """

    calibrated: tuple[Term, ...]
    effects: tuple[Candidate, ...]
    values: FloatArray
    residual: FloatArray
    refined: FloatArray
    jacobian: FloatArray
    scaled: FloatArray
    bounds: FloatArray

    @property
    def terms(self) -> tuple[Term, ...]:
        """All terms in the order of the values."""
        return terms_of(self.calibrated, self.effects)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(p,) which terms are not held by a bound and do something."""
        low, high = self.bounds
        margin = _margin(self.bounds)
        inside = (self.scaled > low + margin) & (self.scaled < high - margin)
        visible = np.abs(self.jacobian).max(axis=0, initial=0.0) > 0.0
        free: NDArray[np.bool_] = inside & visible
        return free

    def parameters(
        self, base: Mapping[str, float], values: FloatArray | None = None
    ) -> dict[str, float]:
        """Parameter → value of what the terms write, fitted or at other ``values`` (p,)."""
        return write(self.terms, self.values if values is None else values, base)

    def measures(self, candidate: Candidate) -> bool:
        """Whether a candidate's strength is held by the data, and not by an end of its range."""
        return bool(self.free[self._first(candidate)])

    def own(self, candidate: Candidate) -> slice:
        """Which of the terms are one candidate's."""
        first = self._first(candidate)
        return slice(first, first + len(candidate.terms))

    def _first(self, candidate: Candidate) -> int:
        before = self.effects[: self.effects.index(candidate)]
        return len(self.calibrated) + sum(len(effect.terms) for effect in before)


def _margin(bounds: FloatArray) -> FloatArray:
    """How near to an end of its range a scaled term is held by it: (p,), for (2, p) bounds."""
    margin: FloatArray = np.minimum(_AT_END[0] * (bounds[1] - bounds[0]), _AT_END[1])
    return margin


def terms_of(calibrated: Sequence[Term], effects: Sequence[Candidate]) -> tuple[Term, ...]:
    """Terms in the order of a fit's values."""
    return (*calibrated, *(term for effect in effects for term in effect.terms))


def natural(terms: Sequence[Term], scaled: Sequence[float] | FloatArray) -> FloatArray:
    """(p,) values of terms [their units] from what a fit sees, see `Term.natural`."""
    return np.array([term.natural(float(z)) for term, z in zip(terms, scaled, strict=True)])


def write(
    terms: Sequence[Term], values: Sequence[float] | FloatArray, base: Mapping[str, float]
) -> dict[str, float]:
    """Parameter → value; terms relative to another parameter see what the others wrote."""
    written: dict[str, float] = {}
    for relative in (False, True):
        for term, value in zip(terms, values, strict=True):
            if bool(term.relative_to) == relative:
                written |= term.write(float(value), {**base, **written})
    return written


@suppress_unsolved_warnings()
def fit(
    problem: Problem,
    base: Mapping[str, float],
    calibrated: Sequence[Term],
    effects: Sequence[Candidate],
    start: FloatArray,
    *,
    refined: FloatArray | None = None,
    trials: int = 8,
    tolerance: float = 3e-3,
) -> Fit:
    """Least squares over what may be used in choices, from ``start`` (p,) [the terms' units].

    Searches in rounds. In each one, what `Problem.refine` added where the last ended is taken to
    be the same everywhere: it depends on the steps much, and on the terms little.

    Args:
        problem, base: the data, and the parameters that the model has.
        calibrated, effects: whose terms are fitted.
        start: the terms' values.
        refined: (m,) what refining adds near ``start``; default: nothing.
        trials: points at which the first round ends; or when neither the terms nor what is left
            change by more than ``tolerance`` of themselves.
        tolerance: see there.
    """
    search = _Search(problem, base, terms_of(calibrated, effects), refined)
    best = at = search.end(search.inside(np.asarray(start, float)), trials, tolerance)
    for _ in range(_ROUNDS - 1):
        if at.change <= _SETTLED:
            break
        at = search.end(search.inside(natural(search.terms, at.point)), _AGAIN, tolerance)
        best = min(best, at, key=lambda end: end.cost)
    return Fit(
        calibrated=tuple(calibrated),
        effects=tuple(effects),
        values=natural(search.terms, best.point),
        residual=best.residual,
        refined=best.refined,
        jacobian=best.jacobian,
        scaled=best.point,
        bounds=search.bounds,
    )


@dataclass(frozen=True, eq=False)
class _End:
    """Where a round of a search ended.

    Attributes:
        point: (p,) scaled terms.
        residual, refined, jacobian: as in `Fit`.
        cost: mean square of what may be used.
        change: of ``refined`` since the round before, mean square.
    """

    point: FloatArray
    residual: FloatArray
    refined: FloatArray
    jacobian: FloatArray
    cost: float
    change: float


class _Search:
    """A problem as a function of scaled terms, in long steps, and what refining adds to it."""

    def __init__(
        self,
        problem: Problem,
        base: Mapping[str, float],
        terms: Sequence[Term],
        refined: FloatArray | None,
    ) -> None:
        self.problem, self.base, self.terms = problem, base, terms
        self.bounds = np.array(
            [[t.scaled(t.low) for t in terms], [t.scaled(t.high) for t in terms]]
        ).reshape(2, -1)
        self.refined = np.zeros(problem.chosen.size) if refined is None else refined
        self._rough: dict[bytes, FloatArray] = {}
        self._slopes: dict[bytes, FloatArray] = {}

    def inside(self, values: FloatArray) -> FloatArray:
        """(p,) scaled values, a little off the ends of their ranges."""
        point = np.array([t.scaled(v) for t, v in zip(self.terms, values, strict=True)])
        margin = 0.5 * _margin(self.bounds)
        clipped: FloatArray = np.clip(point, self.bounds[0] + margin, self.bounds[1] - margin)
        return clipped

    def end(self, point: FloatArray, trials: int, tolerance: float) -> _End:
        """Least squares from a point, and what is left where it ends."""
        jacobian = np.zeros((self.problem.chosen.size, 0))
        if self.terms:
            # SciPy's first step is as long as its variables are large: at least one probe each
            shift = np.where(np.abs(point) < 1.0, np.copysign(1.0, point) - point, 0.0)
            solution = least_squares(
                lambda moved: self._used(moved - shift),
                point + shift,
                jac=lambda moved: self._slope(moved - shift),
                bounds=(self.bounds[0] + shift, self.bounds[1] + shift),
                ftol=tolerance,
                xtol=tolerance,
                gtol=_FLAT,
                max_nfev=trials,
            )
            point = solution.x - shift
            jacobian = next(iter(self._slopes.values()))  # maybe of the last point but one
        rough = self._at(point)
        residual = self.problem.refine(self._parameters(point), rough)
        before, chosen = self.refined, self.problem.chosen
        with np.errstate(invalid="ignore"):
            added = residual - rough
            self.refined = np.where(np.isfinite(added), added, 0.0)
        cost = float(np.mean(residual[chosen] ** 2))
        change = float(np.mean((self.refined - before)[chosen] ** 2))
        return _End(point, residual, self.refined, jacobian, cost, change)

    def _parameters(self, point: FloatArray) -> dict[str, float]:
        return write(self.terms, natural(self.terms, point), self.base)

    def _at(self, point: FloatArray) -> FloatArray:
        """(m,) of one point, in long steps."""
        key = point.tobytes()
        if key not in self._rough:
            self._rough[key] = self.problem.residuals([self._parameters(point)])[0]
        return self._rough[key]

    def _used(self, point: FloatArray) -> FloatArray:
        rows = (self._at(point) + self.refined)[self.problem.chosen]
        return np.where(np.isfinite(rows), rows, _HOPELESS)

    def _slope(self, point: FloatArray) -> FloatArray:
        """(m used, p) by one-sided differences, away from the nearer bound."""
        key = point.tobytes()
        if key not in self._slopes:
            step = np.where(point > self.bounds.mean(axis=0), -_DIFFERENCE, _DIFFERENCE)
            moved = [self._parameters(nudged) for nudged in point + np.diag(step)]
            matrix = (self.problem.residuals(moved) - self._at(point)).T / step
            self._slopes.clear()  # a minute of recordings is megabytes
            self._slopes[key] = np.nan_to_num(matrix, posinf=0.0, neginf=0.0)
        return self._slopes[key][self.problem.chosen]
