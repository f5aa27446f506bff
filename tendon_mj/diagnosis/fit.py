"""Fits terms of a model to recordings by least squares.

Through `mujoco.minimize`, whose Gauss-Newton steps keep to the bounds and ask for the residuals of
many parameter sets at once. `mujoco.sysid`, which is built on the same function, wants a
model recompiled for every parameter set and every sensor of the model in the data: it is what the
result is compared with, see `tendon_mj.diagnosis.sysid`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mujoco import minimize
from numpy.typing import NDArray

from tendon_mj.diagnosis.effect import Candidate, Term
from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]

_DIFFERENCE = 1e-2  # of a probe: above the grain of stick and slip, below what bends the response
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
        inside = (self.scaled > self.bounds[0] + 1e-6) & (self.scaled < self.bounds[1] - 1e-6)
        visible = np.abs(self.jacobian).max(axis=0, initial=0.0) > 0.0
        free: NDArray[np.bool_] = inside & visible
        return free

    def parameters(self, base: Mapping[str, float]) -> dict[str, float]:
        """Parameter → value of the fitted model, of what the terms write."""
        return write(self.terms, self.values, base)

    def own(self, candidate: Candidate) -> FloatArray:
        """Values of one candidate's terms."""
        first = len(self.calibrated)
        for effect in self.effects:
            if effect == candidate:
                return self.values[first : first + len(effect.terms)]
            first += len(effect.terms)
        raise KeyError(candidate.label)


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
    iterations: int = 8,
    tolerance: float = 3e-3,
) -> Fit:
    """Least squares over what may be used in choices, from ``start`` (p,) [the terms' units].

    Ends after ``iterations``, or when no term moves by more than ``tolerance`` of its probe.
    """
    terms = terms_of(calibrated, effects)
    bounds = np.array(
        [[t.scaled(t.low) for t in terms], [t.scaled(t.high) for t in terms]]
    ).reshape(2, -1)
    seen: dict[bytes, FloatArray] = {}
    slopes: dict[bytes, FloatArray] = {}

    def evaluate(points: FloatArray) -> FloatArray:
        """(m, k) residuals at the columns of (p, k) scaled points."""
        keys = [np.ascontiguousarray(points[:, k]).tobytes() for k in range(points.shape[1])]
        missing = [k for k, key in enumerate(keys) if key not in seen]
        if missing:
            sets = [
                write(terms, [t.natural(z) for t, z in zip(terms, points[:, k], strict=True)], base)
                for k in missing
            ]
            for k, row in zip(missing, problem.residuals(sets), strict=True):
                seen[keys[k]] = row
        return np.stack([seen[key] for key in keys], axis=1)

    def used(points: FloatArray) -> FloatArray:
        rows = evaluate(points)[problem.chosen]
        return np.where(np.isfinite(rows), rows, _HOPELESS)

    def slope(point: FloatArray, _: FloatArray) -> FloatArray:
        """(m used, p) by one-sided differences, away from the nearer bound."""
        at = point.reshape(-1, 1)
        key = at.tobytes()
        if key not in slopes:
            middle = bounds.mean(axis=0)
            step = np.where(at[:, 0] > middle, -_DIFFERENCE, _DIFFERENCE)
            moved = evaluate(at + np.diag(step))
            slopes[key] = np.nan_to_num((moved - evaluate(at)) / step, posinf=0.0, neginf=0.0)
            for other in [k for k in seen if k != key]:
                del seen[other]  # a minute of recordings is megabytes
        return slopes[key][problem.chosen]

    origin = np.array([t.scaled(v) for t, v in zip(terms, start, strict=True)])
    point = np.clip(origin, bounds[0], bounds[1]) if terms else origin
    if terms:
        solution, _ = minimize.least_squares(
            point,
            used,
            bounds=[bounds[0], bounds[1]],
            jacobian=slope,
            xtol=tolerance,
            gtol=1e-9,
            max_iter=iterations,
            verbose=0,
        )
        point = np.asarray(solution).ravel()
    residual = evaluate(point.reshape(-1, 1))[:, 0]
    key = point.reshape(-1, 1).tobytes()
    jacobian = slopes.get(key, next(reversed(slopes.values())) if slopes else None)
    if jacobian is None:
        jacobian = np.zeros((residual.size, 0))
    values = np.array([t.natural(z) for t, z in zip(terms, point, strict=True)])
    return Fit(tuple(calibrated), tuple(effects), values, residual, jacobian, point, bounds)
