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

from tendon_mj.diagnosis.effect import Candidate, Term
from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]

_DIFFERENCE = 1e-2  # of a probe: above the grain of stick and slip, below what bends the response
_AT_END = 1e-5, 1e-3  # of its range, and of its probe: nearer to an end a term is held by it
_HOPELESS = 1e6  # what a failed simulation counts as, in noise


@dataclass(frozen=True, eq=False)
class Fit:
    """Terms and the values at which they fit best.

    Attributes:
        calibrated: terms of what the recordings call uncertain; they come first.
        effects: candidates in the model, whose terms follow.
        values: (p,) of the terms [their units].
        residual: (m,) of the problem at these values [-].
        jacobian: (m, p) by the scaled terms.
        scaled: (p,) the terms as the fit saw them.
        bounds: (2, p) of these.
    """

    calibrated: tuple[Term, ...]
    effects: tuple[Candidate, ...]
    values: FloatArray
    residual: FloatArray
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

    def parameters(self, base: Mapping[str, float]) -> dict[str, float]:
        """Parameter → value of the fitted model, of what the terms write."""
        return write(self.terms, self.values, base)

    def measures(self, candidate: Candidate) -> bool:
        """Whether a candidate's strength is held by the data, and not by an end of its range."""
        return bool(self.free[self._first(candidate)])

    def own(self, candidate: Candidate) -> FloatArray:
        """Values of one candidate's terms."""
        first = self._first(candidate)
        return self.values[first : first + len(candidate.terms)]

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


def fit(
    problem: Problem,
    base: Mapping[str, float],
    calibrated: Sequence[Term],
    effects: Sequence[Candidate],
    start: FloatArray,
    *,
    trials: int = 8,
    tolerance: float = 3e-3,
) -> Fit:
    """Least squares over what may be used in choices, from ``start`` (p,) [the terms' units].

    Ends after ``trials`` points, or when neither the terms nor what is left change by more than
    ``tolerance`` of themselves.
    """
    terms = terms_of(calibrated, effects)
    bounds = np.array(
        [[t.scaled(t.low) for t in terms], [t.scaled(t.high) for t in terms]]
    ).reshape(2, -1)

    def simulate(points: Sequence[FloatArray]) -> FloatArray:
        """(k, m) residuals at scaled points."""
        return problem.residuals(
            [
                write(terms, [t.natural(z) for t, z in zip(terms, point, strict=True)], base)
                for point in points
            ]
        )

    at: dict[bytes, FloatArray] = {}
    slopes: dict[bytes, FloatArray] = {}

    def residual(point: FloatArray) -> FloatArray:
        """(m,) of one point."""
        if point.tobytes() not in at:
            at[point.tobytes()] = simulate([point])[0]
        return at[point.tobytes()]

    def used(point: FloatArray) -> FloatArray:
        rows = residual(point)[problem.chosen]
        return np.where(np.isfinite(rows), rows, _HOPELESS)

    def slope(point: FloatArray) -> FloatArray:
        """(m used, p) by one-sided differences, away from the nearer bound."""
        step = np.where(point > bounds.mean(axis=0), -_DIFFERENCE, _DIFFERENCE)
        moved = simulate(list(point + np.diag(step)))
        matrix = (moved - residual(point)).T / step
        slopes.clear()  # a minute of recordings is megabytes
        slopes[point.tobytes()] = np.nan_to_num(matrix, posinf=0.0, neginf=0.0)
        return slopes[point.tobytes()][problem.chosen]

    point = np.array([t.scaled(v) for t, v in zip(terms, start, strict=True)])
    jacobian = np.zeros((problem.chosen.size, 0))
    if terms:
        inside = 0.5 * _margin(bounds)
        solution = least_squares(
            used,
            np.clip(point, bounds[0] + inside, bounds[1] - inside),
            jac=slope,
            bounds=(bounds[0], bounds[1]),
            ftol=tolerance,
            xtol=tolerance,
            gtol=None,
            max_nfev=trials,
        )
        point = solution.x
        jacobian = next(iter(slopes.values()))  # at the last point but one, where it ended there
    values = np.array([t.natural(z) for t, z in zip(terms, point, strict=True)])
    return Fit(tuple(calibrated), tuple(effects), values, residual(point), jacobian, point, bounds)
