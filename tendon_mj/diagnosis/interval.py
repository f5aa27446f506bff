"""How sure fitted values are, with residuals that are correlated in time.

Least squares takes every sample for news. Where model and rig differ by more than white noise
neighbouring residuals repeat each other, and the honest spread comes from how the gradient
varies between whole stretches of time (a clustered sandwich estimate):

    Cov = A⁻¹ (Σ_b g_b g_bᵀ) A⁻¹,   A = JᵀJ,   g_b = J_bᵀ r_b.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tendon_mj.diagnosis.fit import Fit
from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]

_LEVEL = 0.95


def intervals(problem: Problem, fit: Fit) -> FloatArray:
    """(p, 2) 95 % intervals of a fit's values [the terms' units]; the whole range where not free."""
    used, free = problem.chosen, fit.free
    jacobian, residual = fit.jacobian[used][:, free], fit.residual[used]
    numbers = problem.segments[used]
    names = np.unique(numbers)
    gradients = np.array([jacobian[numbers == b].T @ residual[numbers == b] for b in names])
    inverse = np.linalg.pinv(jacobian.T @ jacobian)
    clusters = gradients.T @ gradients * names.size / max(names.size - free.sum(), 1)
    spread = np.sqrt(np.maximum(np.diag(inverse @ clusters @ inverse), np.diag(inverse)))
    width = float(stats.t.ppf(0.5 + _LEVEL / 2.0, max(names.size - int(free.sum()), 1))) * spread
    ranges = np.array([[term.low, term.high] for term in fit.terms]).reshape(-1, 2)
    for k, half in zip(np.flatnonzero(free), width, strict=True):
        term = fit.terms[k]
        ends = [term.natural(fit.scaled[k] + sign * half) for sign in (-1.0, 1.0)]
        ranges[k] = np.clip(sorted(ends), *sorted(ranges[k]))
    return ranges
