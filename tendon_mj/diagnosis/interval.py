"""How sure fitted values are, with residuals that are correlated in time.

Least squares takes every sample for news. Where model and rig differ by more than white noise
neighbouring residuals repeat each other, and the honest spread comes from how the gradient
varies between whole stretches of time (a clustered sandwich estimate):

    Cov = A⁻¹ (Σ_b g_b g_bᵀ) A⁻¹,   A = JᵀJ,   g_b = J_bᵀ r_b.

What the model cannot imitate it still leans on: an error of mean square g that has the correlation
ρ with a slope shifts the value by ρ √(g m (A⁻¹)_kk). The fit has taken that part out of the
residual, so it is taken to be as in what remains, with ρ = 0.2; what halving the simulation's steps
changes is counted to it. A direction in which several values only trade places has no interval.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tendon_mj.diagnosis.fit import Fit
from tendon_mj.diagnosis.numerics import step_error
from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]

_LEVEL = 0.95
_SINGULAR = 1e-5  # eigenvalue of JᵀJ with a unit diagonal
_TAKES_PART = 0.1  # component of its vector
_CORRELATION = 0.2  # of unmodelled structure with a slope


def intervals(problem: Problem, fit: Fit) -> FloatArray:
    """(p, 2) 95 % intervals of a fit's values [the terms' units]; the range where not free."""
    ranges = np.array([[term.low, term.high] for term in fit.terms]).reshape(-1, 2)
    widths = half_widths(problem, fit, fit.free)
    for k, half in zip(np.flatnonzero(fit.free), widths, strict=True):
        term = fit.terms[k]
        ends = [term.natural(fit.scaled[k] + sign * half) for sign in (-1.0, 1.0)]
        ranges[k] = np.clip(sorted(ends), *sorted(ranges[k]))
    return ranges


def beyond_range(problem: Problem, fit: Fit, near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(p,) which of the terms ``near`` an end of their ranges the data would take beyond it.

    By more than half of the 95 % interval that they would have without the end.
    """
    used, freed = problem.chosen, (fit.free | near) & (np.abs(fit.jacobian).max(axis=0) > 0.0)
    jacobian = fit.jacobian[used][:, freed]
    step = np.zeros(len(fit.terms))
    step[freed] = -np.linalg.pinv(jacobian) @ fit.residual[used]
    half = np.full(len(fit.terms), np.inf)
    half[freed] = half_widths(problem, fit, freed)
    low, high = fit.bounds
    out = np.where(
        fit.scaled > 0.5 * (low + high), fit.scaled + step - high, low - fit.scaled - step
    )
    beyond: NDArray[np.bool_] = near & (out > half)
    return beyond


def half_widths(problem: Problem, fit: Fit, free: NDArray[np.bool_]) -> FloatArray:
    """(free terms,) half of the 95 % intervals, scaled as the fit saw the terms."""
    used = problem.chosen
    jacobian, residual = fit.jacobian[used][:, free], fit.residual[used]
    numbers = problem.segments[used]
    names = np.unique(numbers)
    gradients = np.array([jacobian[numbers == b].T @ residual[numbers == b] for b in names])
    inverse, open_ended = _inverse(jacobian.T @ jacobian)
    clusters = gradients.T @ gradients * names.size / max(names.size - free.sum(), 1)
    alone = np.diag(inverse)
    remains = max(float(np.mean(residual**2)) - 1.0, 0.0) + step_error(fit.refined[used])
    leaning = _CORRELATION**2 * remains * residual.size * alone
    deviation = np.sqrt(np.maximum(np.diag(inverse @ clusters @ inverse), alone) + leaning)
    quantile = stats.t.ppf(0.5 + _LEVEL / 2.0, max(names.size - int(free.sum()), 1))
    widths: FloatArray = np.where(open_ended, np.inf, float(quantile) * deviation)
    return widths


def _inverse(normal: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """(p, p) inverse of JᵀJ where it has one, and (p,) which terms it leaves open."""
    scale = 1.0 / np.sqrt(np.diag(normal))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    held = values > _SINGULAR
    inverse = (vectors[:, held] / values[held]) @ vectors[:, held].T
    open_ended = (np.abs(vectors[:, ~held]) > _TAKES_PART).any(axis=1)
    return inverse * np.outer(scale, scale), open_ended
