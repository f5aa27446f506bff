"""Global search for the minimum of a non-smooth cost.

With stick and slip the squared misfit has many local minima, and least squares ends in the one
where it began. Most of that misfit lies in the few samples between one slip and the other. A
logarithm of the squares (Cauchy loss) is robust to them and leaves one wide basin; differential
evolution (SciPy's) finds its bottom without derivatives in some three hundred simulations. Where
the linearisation of the response holds there is no local minimum to leave, which ten simulations
tell.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.model_selection.fit import Fit, natural
from tendon_mj.lab.diagnosis.model_selection.intervals import half_widths
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.replay import suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_LONGEST = 0.1  # of its range: the step of a term
_NONLINEAR = 0.2  # of the mean square change of the response, at most
_WIDE = 4.0  # half intervals to either side
_OUTLIER = 3.0  # scale of the Cauchy loss [noise]
_GENERATIONS = 9
_POPULATION = 6  # points of a generation, for every term


@suppress_unsolved_warnings()
def linearisation_holds(problem: Problem, base: Mapping[str, float], fitted: Fit) -> bool:
    """Whether the response about a fit changes as its Jacobian says, so its minimum is global.

    Each term takes a step to either side within its range, by which, to first order, the response
    changes by as much as the fit leaves. With Δ_k the change of step k and d_k its linearisation,
    the criterion is Σ |Δ_k − d_k|² < 0.2 Σ |Δ_k|².

    Args:
        problem, base: data, and parameter → value of the model.
        fitted: end of a least-squares fit.
    """
    used, longest = problem.in_train, _LONGEST * np.ptp(fitted.bounds, axis=0)
    slopes = fitted.jacobian[used]
    left = np.sqrt(max(float(np.mean(fitted.residual[used] ** 2)) - 1.0, 0.0))
    steep = np.sqrt(np.mean(slopes**2, axis=0))
    reach = np.divide(left, steep, out=longest.copy(), where=steep * longest > left)
    steps = np.vstack([np.diag(reach), -np.diag(reach)])
    points = np.clip(fitted.scaled + steps, *fitted.bounds)
    sets = [fitted.parameters(base, natural(fitted.terms, point)) for point in points]
    here, *there = problem.residuals([fitted.parameters(base), *sets])[:, used]
    changed = nonlinear = 0.0
    for point, residual in zip(points, there, strict=True):
        linear = slopes @ (point - fitted.scaled)
        changed += float(np.sum((residual - here) ** 2))
        nonlinear += float(np.sum((residual - here - linear) ** 2))
    return nonlinear < _NONLINEAR * changed


@suppress_unsolved_warnings()
def search_globally(
    problem: Problem, base: Mapping[str, float], fitted: Fit, widely: slice, progress: Progress
) -> FloatArray:
    """(p,) start values of the terms, from which another fit may end lower.

    Deterministic: the random numbers are seeded.

    Args:
        problem, base: data, and parameter → value of the model.
        fitted: centre of the search; the neighbourhood of its free terms is searched.
        widely: terms searched in their whole range.
        progress: called with a label, how many generations are done, and of how many.
    """
    free, used = fitted.free.copy(), problem.in_train
    half = np.full(free.size, np.inf)
    half[free] = half_widths(problem, fitted, free)
    free[widely], half[widely] = True, np.inf
    if not free.any():
        return fitted.values.copy()
    low = np.maximum(fitted.scaled - _WIDE * half, fitted.bounds[0])[free]
    high = np.minimum(fitted.scaled + _WIDE * half, fitted.bounds[1])[free]
    generation = 0

    def values(point: FloatArray) -> FloatArray:
        scaled = fitted.scaled.copy()
        scaled[free] = point
        return natural(fitted.terms, scaled)

    def losses(points: FloatArray) -> FloatArray:
        """(k,) losses at (free terms, k) points."""
        nonlocal generation
        progress("global search", min(generation, _GENERATIONS), _GENERATIONS + 1)
        generation += 1
        sets = [fitted.parameters(base, values(point)) for point in points.T]
        rows = problem.residuals(sets)
        return np.array([float(np.mean(np.log1p((row[used] / _OUTLIER) ** 2))) for row in rows])

    random = np.random.default_rng(0)
    first = qmc.scale(
        qmc.LatinHypercube(low.size, rng=random).random(_POPULATION * low.size), low, high
    )
    first[0] = fitted.scaled[free]
    found = differential_evolution(
        losses,
        list(zip(low, high, strict=True)),
        init=first,
        maxiter=_GENERATIONS,
        mutation=(0.4, 0.8),
        recombination=0.8,
        tol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=random,
    )
    progress("global search", _GENERATIONS + 1, _GENERATIONS + 1)
    return values(found.x)
