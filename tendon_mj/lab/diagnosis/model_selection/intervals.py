"""95 % intervals of fitted values, with residuals that are correlated in time.

Least squares takes every residual for independent. Where model and rig differ by more than white
noise neighbouring residuals repeat each other, and the spread comes from how the gradient varies
between whole blocks of time (a clustered sandwich estimate):

    Cov = A⁻¹ (Σ_b g_b g_bᵀ) A⁻¹,   A = JᵀJ,   g_b = J_bᵀ r_b.

Unmodelled structure biases the values: an error of mean square g with correlation ρ to a column of
J shifts the value by ρ √(g m (A⁻¹)_kk). The fit has removed the correlated part from the residual,
so ρ = 0.2 is assumed of what remains; the error of the simulation's step is added to g. A direction
in which several values compensate each other has no interval.

Where recordings are of different states of the rig, blocks of one recording repeat each other too.
The interval is then no narrower than that of the jackknife over recordings, of variance
(R−1)/R Σ_b Δ_b², with Δ_b the shift of the value where recording b is left out of the fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.data.step_size import step_error
from tendon_mj.lab.diagnosis.model_selection.fit import Fit
from tendon_mj.typing import FloatArray

_LEVEL = 0.95
_SINGULAR = 1e-5  # eigenvalue of JᵀJ scaled to a unit diagonal
_LOADING = 0.1  # component of its eigenvector
_CORRELATION = 0.2  # ρ, of unmodelled structure with a column of J


def intervals(problem: Problem, fit: Fit, refits: Sequence[Fit] = ()) -> FloatArray:
    """(p, 2) 95 % intervals of a fit's values [the terms' units]; the range where not free.

    ``refits`` are of the same model, with each recording left out in turn.
    """
    ranges = np.array([[term.low, term.high] for term in fit.terms]).reshape(-1, 2)
    widths = half_widths(problem, fit, fit.free)
    if len(refits) > 1:
        widths = np.maximum(widths, _jackknife(fit, refits)[fit.free])
    for k, half in zip(np.flatnonzero(fit.free), widths, strict=True):
        term = fit.terms[k]
        ends = [term.natural(fit.scaled[k] + sign * half) for sign in (-1.0, 1.0)]
        ranges[k] = np.clip(sorted(ends), *sorted(ranges[k]))
    return ranges


def correlation_matrix(problem: Problem, fit: Fit, chosen: NDArray[np.bool_]) -> FloatArray:
    """(k, k) correlations of the estimates of ``chosen`` (p,) terms, others free beside them.

    Those of independent residuals, A⁻¹ scaled to a unit diagonal.
    """
    free = fit.free | chosen
    jacobian = fit.jacobian[problem.in_train][:, free]
    inverse, _ = _inverse(jacobian.T @ jacobian)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(inverse), np.finfo(float).tiny))
    correlations: FloatArray = (inverse * np.outer(scale, scale))[chosen[free]][:, chosen[free]]
    return np.clip(correlations, -1.0, 1.0)


def beyond_range(problem: Problem, fit: Fit, near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(p,) which of the terms ``near`` a bound the data would take beyond it.

    By more than half of the 95 % interval that they would have without the bound.
    """
    used, freed = problem.in_train, (fit.free | near) & (np.abs(fit.jacobian).max(axis=0) > 0.0)
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
    """(free terms,) half of the 95 % intervals, of the scaled terms."""
    used = problem.in_train
    jacobian, residual = fit.jacobian[used][:, free], fit.residual[used]
    blocks = problem.blocks[used]
    names = np.unique(blocks)
    gradients = np.array([jacobian[blocks == b].T @ residual[blocks == b] for b in names])
    inverse, undetermined = _inverse(jacobian.T @ jacobian)
    clusters = gradients.T @ gradients * names.size / max(names.size - free.sum(), 1)
    alone = np.diag(inverse)
    remains = max(float(np.mean(residual**2)) - 1.0, 0.0) + step_error(fit.correction[used])
    bias = _CORRELATION**2 * remains * residual.size * alone
    deviation = np.sqrt(np.maximum(np.diag(inverse @ clusters @ inverse), alone) + bias)
    quantile = stats.t.ppf(0.5 + _LEVEL / 2.0, max(names.size - int(free.sum()), 1))
    widths: FloatArray = np.where(undetermined, np.inf, float(quantile) * deviation)
    return widths


def _jackknife(fit: Fit, refits: Sequence[Fit]) -> FloatArray:
    """(p,) half of the 95 % intervals of the scaled terms from leaving out whole recordings."""
    shifts = np.array([refitted.scaled for refitted in refits]) - fit.scaled
    count = len(refits)
    quantile = stats.t.ppf(0.5 + _LEVEL / 2.0, count - 1)
    widths: FloatArray = quantile * np.sqrt((count - 1) / count * (shifts**2).sum(axis=0))
    return widths


def _inverse(normal: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """(p, p) pseudoinverse of JᵀJ, and (p,) which terms it leaves undetermined."""
    scale = 1.0 / np.sqrt(np.diag(normal))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    held = values > _SINGULAR
    inverse = (vectors[:, held] / values[held]) @ vectors[:, held].T
    inverse = 0.5 * (inverse + inverse.T)  # its halves differ in rounding, by the processor
    undetermined = (np.abs(vectors[:, ~held]) > _LOADING).any(axis=1)
    return inverse * np.outer(scale, scale), undetermined
