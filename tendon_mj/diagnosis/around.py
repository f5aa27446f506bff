"""Out of local minima: where a sheath breaks loose a moment later, the response is another one.

With stick and slip the misfit has many small valleys, and least squares ends in the one where it
began. Differential evolution (SciPy's) looks at the whole neighbourhood, without slopes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from tendon_mj.diagnosis.fit import Fit
from tendon_mj.diagnosis.interval import half_widths
from tendon_mj.diagnosis.problem import Problem
from tendon_mj.diagnosis.screen import Report

FloatArray = NDArray[np.float64]

_WIDE = 4.0  # half intervals to either side
_GENERATIONS = 8
_FEWEST, _EACH = 16, 4  # points of a generation: at least, and for every term


def look_around(
    problem: Problem, base: Mapping[str, float], fitted: Fit, report: Report
) -> FloatArray:
    """(p,) values of a fit's terms from where another fit may end lower.

    Always the same ones for the same data.
    """
    free, used = fitted.free, problem.chosen
    half, random = half_widths(problem, fitted, free), np.random.default_rng(0)
    centre = fitted.scaled[free]
    low = np.maximum(centre - _WIDE * half, fitted.bounds[0][free])
    high = np.minimum(centre + _WIDE * half, fitted.bounds[1][free])
    generation = 0

    def natural(point: FloatArray) -> FloatArray:
        scaled = fitted.scaled.copy()
        scaled[free] = point
        return np.array([t.natural(z) for t, z in zip(fitted.terms, scaled, strict=True)])

    def left(points: FloatArray) -> FloatArray:
        """(k,) mean squares at (free terms, k) points."""
        nonlocal generation
        report("look around", min(generation, _GENERATIONS), _GENERATIONS + 1)
        generation += 1
        sets = [fitted.parameters(base, natural(point)) for point in points.T]
        rows = problem.residuals(sets) + fitted.refined
        return np.array([float(np.mean(row[used] ** 2)) for row in rows])

    count = max(_FEWEST, _EACH * centre.size)
    first = low + (high - low) * random.uniform(size=(count, centre.size))
    first[0] = centre
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
    return natural(found.x)
