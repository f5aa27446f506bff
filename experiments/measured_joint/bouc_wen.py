"""Bouc–Wen model of each measured column over the command.

    y = a + k u + κ z,    dz/du = 1 − |z|ⁿ (γ + β sgn(u̇ z)),    σ = β + γ > 0

Six numbers a column, each linear in the bend. a, k and κ follow by linear least squares from the
others (variable projection); σ, γ/σ and n are searched globally, by differential evolution.

Y.-K. Wen: Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102, 1976.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from scipy.optimize import differential_evolution

from experiments.measured_joint.prediction import Predict, Series
from experiments.measured_joint.recording import COLUMNS, COMMAND, bend
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_AMPLITUDE = math.radians(60.0)  # of the command
_LARGEST_BEND = math.radians(240.0)
# log σ, γ/σ, n, without a bend and at the largest
_BOUNDS = [(math.log(0.2), math.log(50.0)), (-0.95, 0.95), (0.5, 4.0)] * 2
_GENERATIONS, _POPULATION = 60, 12  # per searched number


def fit_bouc_wen(train: Sequence[Recording], seed: int = 0) -> Predict:
    """Fit the numbers of each measured column."""
    by_name = {column: _fit(train, column, seed) for column in COLUMNS}

    def predict(recording: Recording) -> Series:
        return {c: _features(recording, shape) @ linear for c, (shape, linear) in by_name.items()}

    return predict


def _fit(train: Sequence[Recording], column: str, seed: int) -> tuple[FloatArray, FloatArray]:
    aim = np.concatenate([r.columns[column] for r in train])

    def project(shape: FloatArray) -> tuple[FloatArray, FloatArray]:
        table = np.concatenate([_features(r, shape) for r in train])
        linear = np.linalg.lstsq(table, aim, rcond=None)[0]
        return linear, table @ linear - aim

    def cost(shape: FloatArray) -> float:
        left = project(shape)[1]
        return float(left @ left)

    best = differential_evolution(
        cost, _BOUNDS, rng=np.random.default_rng(seed), maxiter=_GENERATIONS, popsize=_POPULATION
    ).x
    return best, project(best)[0]


def _features(recording: Recording, shape: FloatArray) -> FloatArray:
    """(n, 6) columns that a, k and κ multiply, and each of them times the bend."""
    share = bend(recording) / _LARGEST_BEND
    log_sum, ratio, power = (1.0 - share) * shape[:3] + share * shape[3:]
    command = recording.columns[COMMAND] / _AMPLITUDE
    total = math.exp(log_sum)
    hysteretic = _hysteresis(command, (1.0 - ratio) * total, ratio * total, max(power, 0.1))
    table = np.column_stack([np.ones_like(command), command, hysteretic])
    return np.hstack([table, share * table])


@njit(cache=True)
def _hysteresis(command: FloatArray, beta: float, gamma: float, power: float) -> FloatArray:
    """z over the command, by Heun's steps of at most a hundredth of the amplitude."""
    values = np.zeros_like(command)
    z = 0.0
    for i in range(1, command.size):
        travel = command[i] - command[i - 1]
        steps = int(abs(travel) / 0.01) + 1
        h = travel / steps
        for _ in range(steps):
            sense = 1.0 if h * z > 0.0 else -1.0
            first = 1.0 - abs(z) ** power * (gamma + beta * sense)
            ahead = z + h * first
            sense = 1.0 if h * ahead > 0.0 else -1.0
            second = 1.0 - abs(ahead) ** power * (gamma + beta * sense)
            z += 0.5 * h * (first + second)
            z = min(max(z, -10.0), 10.0)
        values[i] = z
    return values
