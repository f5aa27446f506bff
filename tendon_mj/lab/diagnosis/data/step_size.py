"""Step size of a simulation: as long as a search allows, and its error in a residual.

Searching takes hundreds of simulations, judging a few. The search therefore takes twice the model's
step; `Problem.extrapolate` removes the error of that step, and only extrapolated residuals are
judged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.typing import FloatArray

_LONGEST = 2.0  # times the model's own step
_LARGEST_ERROR = 1.0  # of the long step, see `step_error`


def search_step(problem: Problem) -> float | None:
    """Step of the search in steps of the model, 2 or 1; None for a simulator without steps.

    A longer step may end a move in another of the states in which friction holds. Rests are
    searched with the model's own step.

    Args:
        problem: with the model's own step.
    """
    own = problem.simulate
    if own.steps == 0:
        return None
    at_rest = any(recording.quasi_static for recording in problem.recordings)
    if at_rest or own.in_steps(_LONGEST).steps == own.steps:  # or a sample at every step
        return 1.0
    tried = with_step(problem, _LONGEST)
    coarse = tried.residuals([{}])[0]
    with np.errstate(invalid="ignore"):
        correction = tried.extrapolate({}, coarse) - coarse
    return _LONGEST if step_error(correction) <= _LARGEST_ERROR else 1.0


def with_step(problem: Problem, factor: float | None) -> Problem:
    """The problem with a step ``factor`` times the model's; unchanged for None."""
    if factor is None:
        return problem
    simulate = problem.simulate.in_steps(factor)
    return replace(problem, simulate=simulate, half_step=simulate.in_steps(0.5))


def step_error(correction: FloatArray) -> float:
    """Mean square by which halving the step changes a residual [noise variance].

    The ``correction`` (m,) of `Problem.extrapolate` is twice that change, and to first order all
    of the step's error; the change itself measures what the correction may have missed. Of rests
    it is that change, of which half may be left.
    """
    return float(np.mean((0.5 * correction) ** 2)) if np.isfinite(correction).all() else np.inf
