"""How much of a misfit may be the simulation's own error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tendon_mj.diagnosis.problem import Problem
from tendon_mj.simulate.simulator import Simulator


def numerical_floor(problem: Problem, parameters: Mapping[str, float]) -> float:
    """Mean square difference to the same simulation at half the step [noise power].

    Twice it is what the step itself may leave (the method is of order 1); what a model's guides or
    its rigid bodies leave out is not in it. A user's own simulator is taken at its word.
    """
    coarse = problem.simulate
    if not isinstance(coarse, Simulator):
        return 0.0
    step = 0.5 * coarse.model.opt.timestep
    finer = replace(problem, simulate=Simulator(coarse.recordings, coarse.model, timestep=step))
    difference = (problem.residuals([parameters]) - finer.residuals([parameters]))[0]
    used = difference[problem.chosen]
    return float(np.mean(used**2)) if np.isfinite(used).all() else 0.0
