"""Steps of a simulation: as long as a search allows, and what their length does to a residual.

Searching takes hundreds of simulations, judging a few. So the search takes steps twice the model's
own, to which `Problem.refine` adds what they leave out, and only that is judged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]

_LONGEST = 2.0  # times the model's own step
_ROUGHEST = 1.0  # mean square [noise power] by which halving may change what long steps leave


def searching_steps(problem: Problem) -> float | None:
    """How long steps may be, in the model's own: 2 or 1; None where it has no steps.

    Args:
        problem: in the model's own steps.
    """
    own = problem.simulate
    if own.steps == 0:
        return None
    if own.in_steps(_LONGEST).steps == own.steps:  # a sample at every step
        return 1.0
    tried = in_steps(problem, _LONGEST)
    rough = tried.residuals([{}])[0]
    with np.errstate(invalid="ignore"):
        added = tried.refine({}, rough) - rough
    return _LONGEST if step_error(added) <= _ROUGHEST else 1.0


def in_steps(problem: Problem, factor: float | None) -> Problem:
    """The same problem in steps ``factor`` times as long; unchanged for None."""
    if factor is None:
        return problem
    simulate = problem.simulate.in_steps(factor)
    return replace(problem, simulate=simulate, finer=simulate.in_steps(0.5))


def step_error(added: FloatArray) -> float:
    """Mean square by which halving the steps changes a residual [noise power].

    Twice that change, ``added``, is what `Problem.refine` adds, to first order all of the steps'
    error; the change itself is the measure of what it may not take out.
    """
    return float(np.mean((0.5 * added) ** 2)) if np.isfinite(added).all() else np.inf
