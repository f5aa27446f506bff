"""Thresholds of the selection, in excess χ² (reduced χ² − 1) [-]."""

from __future__ import annotations

import numpy as np

from tendon_mj.diagnosis.data.problem import Problem

SMALLEST_EXCESS = 0.2  # 0.45 noise rms: less is not worth a name
STANDARD_ERRORS = 2.0  # of a gain in χ²: less may be chance
CLOSED = 0.985  # of the rms error above noise: a model that closes less does not explain it
_DISCRETISATION = 0.0025  # of a signal's range: what lumping and stepping leave


def detection_limit(problem: Problem, step_error: float) -> float:
    """Excess χ² below which nothing is named, for a simulation with that `step_error`."""
    return max(SMALLEST_EXCESS, step_error, discretisation_error(problem))


def discretisation_error(problem: Problem) -> float:
    """Mean square error, over all residuals, of a sheath lumped into guides."""
    powers = [
        (
            _DISCRETISATION
            * float(np.ptp(problem.recordings[k].columns[column]))
            / problem.noise[k][column]
        )
        ** 2
        for k, column, _ in problem.layout()
    ]
    return float(np.mean(powers))


def unexplained_excess(initial: float) -> float:
    """Excess χ² that may remain of an ``initial`` one in a model that explains it."""
    before = np.sqrt(1.0 + max(initial, 0.0)) - 1.0
    return float((1.0 + (1.0 - CLOSED) * before) ** 2 - 1.0)
