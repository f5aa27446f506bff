"""Out of local minima: where a sheath breaks loose a moment later, the response is another one.

With stick and slip the squares of the misfit have many small valleys, and least squares ends in the
one where it began. The few samples between one slip and the other are most of such squares; a
logarithm of them (Cauchy's loss) counts them for little, and what it leaves has one wide valley.
Differential evolution (SciPy's) finds its bottom, without slopes, for some three hundred
simulations. Where slopes tell what the response does there is no stick and slip to get lost in, and
that is seen from ten.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from tendon_mj.diagnosis.fit import Fit, natural
from tendon_mj.diagnosis.interval import half_widths
from tendon_mj.diagnosis.problem import Problem
from tendon_mj.diagnosis.screen import Report
from tendon_mj.replay.suppression import suppress_unsolved_warnings

FloatArray = NDArray[np.float64]

_LONGEST = 0.1  # of its range: the stride of a term
_BENT = 0.2  # of what strides change, mean square: slopes that tell all but this hold
_WIDE = 4.0  # half intervals to either side
_SLIP = 3.0  # residual [noise] from which it counts for less
_GENERATIONS = 9
_EACH = 6  # points of a generation, for every term


@suppress_unsolved_warnings()
def slopes_hold(problem: Problem, base: Mapping[str, float], fitted: Fit) -> bool:
    """Whether the response about a fit changes as its slopes say: least squares did not get lost.

    Each term takes a stride to either side within its range, in which by its slope the response
    changes by as much as the fit leaves; with the changes Δ_k that it makes and d_k that its slope
    tells of, Σ |Δ_k − d_k|² < 0.2 Σ |Δ_k|².

    Args:
        problem, base: the data, and the parameters that the model has.
        fitted: least squares' end.
    """
    used, longest = problem.chosen, _LONGEST * np.ptp(fitted.bounds, axis=0)
    slopes = fitted.jacobian[used]
    left = np.sqrt(max(float(np.mean(fitted.residual[used] ** 2)) - 1.0, 0.0))
    steep = np.sqrt(np.mean(slopes**2, axis=0))
    reach = np.divide(left, steep, out=longest.copy(), where=steep * longest > left)
    strides = np.vstack([np.diag(reach), -np.diag(reach)])
    points = np.clip(fitted.scaled + strides, *fitted.bounds)
    sets = [fitted.parameters(base, natural(fitted.terms, point)) for point in points]
    here, *there = problem.residuals([fitted.parameters(base), *sets])[:, used]
    changed = bent = 0.0
    for point, residual in zip(points, there, strict=True):
        told = slopes @ (point - fitted.scaled)
        changed += float(np.sum((residual - here) ** 2))
        bent += float(np.sum((residual - here - told) ** 2))
    return bent < _BENT * changed


@suppress_unsolved_warnings()
def look_around(
    problem: Problem, base: Mapping[str, float], fitted: Fit, widely: slice, report: Report
) -> FloatArray:
    """(p,) values of a fit's terms from where another fit may end lower.

    Always the same ones for the same data.

    Args:
        problem, base: the data, and the parameters that the model has.
        fitted: where the search is; the neighbourhood of the terms is searched.
        widely: terms of which the whole range is.
        report: called with a label, how many generations are done, and of how many.
    """
    free, used = fitted.free.copy(), problem.chosen
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

    def left(points: FloatArray) -> FloatArray:
        """(k,) losses at (free terms, k) points."""
        nonlocal generation
        report("look around", min(generation, _GENERATIONS), _GENERATIONS + 1)
        generation += 1
        sets = [fitted.parameters(base, values(point)) for point in points.T]
        rows = problem.residuals(sets)
        return np.array([float(np.mean(np.log1p((row[used] / _SLIP) ** 2))) for row in rows])

    random = np.random.default_rng(0)
    first = qmc.scale(qmc.LatinHypercube(low.size, rng=random).random(_EACH * low.size), low, high)
    first[0] = fitted.scaled[free]
    found = differential_evolution(
        left,
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
    report("look around", _GENERATIONS + 1, _GENERATIONS + 1)
    return values(found.x)
