"""Small network on the history of the command: one hidden layer, the mean of several.

Inputs are the command now and at 12 earlier times over one period, and the bend; outputs the three
measured columns, each over its spread. Weights decay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from experiments.measured_joint.prediction import Predict, Series
from experiments.measured_joint.recording import COLUMNS, COMMAND, bend
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_AMPLITUDE = math.radians(60.0)  # of the command
_LARGEST_BEND = math.radians(240.0)
_DELAYS = np.linspace(0.0, 2.0 * math.pi, 13)  # [s]; the command's period is 2π
_HIDDEN, _MEMBERS = 12, 5
_DECAY = 3e-3
_ITERATIONS = 300


def fit_history_network(train: Sequence[Recording], seed: int = 0) -> Predict:
    """Fit the networks, each from weights of its own."""
    inputs = np.concatenate([_inputs(r) for r in train])
    measured = np.concatenate(
        [np.column_stack([r.columns[column] for column in COLUMNS]) for r in train]
    )
    centre, spread = measured.mean(axis=0), measured.std(axis=0)
    aim = (measured - centre) / spread
    random = np.random.default_rng(seed)
    networks = [_train(inputs, aim, random) for _ in range(_MEMBERS)]

    def predict(recording: Recording) -> Series:
        shown = _inputs(recording)
        mean = np.mean([_run(weights, shown)[1] for weights in networks], axis=0)
        outputs = centre + spread * mean
        return {column: outputs[:, k] for k, column in enumerate(COLUMNS)}

    return predict


def _inputs(recording: Recording) -> FloatArray:
    """(n, 15): delayed commands, at rest before the first sample; the bend; and 1."""
    time, command = recording.time, recording.columns[COMMAND] / _AMPLITUDE
    history = [np.interp(time - delay, time, command) for delay in _DELAYS]
    ones = np.ones_like(command)
    return np.column_stack([*history, bend(recording) / _LARGEST_BEND * ones, ones])


def _split(weights: FloatArray, inputs: int) -> tuple[FloatArray, FloatArray]:
    first = weights[: inputs * _HIDDEN].reshape(inputs, _HIDDEN)
    return first, weights[inputs * _HIDDEN :].reshape(_HIDDEN + 1, len(COLUMNS))


def _run(weights: FloatArray, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Hidden layer with a column of ones, and outputs."""
    first, second = _split(weights, inputs.shape[1])
    hidden = np.column_stack([np.tanh(inputs @ first), np.ones(len(inputs))])
    return hidden, hidden @ second


def _train(inputs: FloatArray, aim: FloatArray, random: np.random.Generator) -> FloatArray:
    size = inputs.shape[1] * _HIDDEN + (_HIDDEN + 1) * len(COLUMNS)

    def cost(weights: FloatArray) -> tuple[float, FloatArray]:
        hidden, outputs = _run(weights, inputs)
        left = (outputs - aim) / len(inputs)
        _, second = _split(weights, inputs.shape[1])
        back = (left @ second[:-1].T) * (1.0 - hidden[:, :-1] ** 2)
        slope = np.concatenate([(inputs.T @ back).ravel(), (hidden.T @ left).ravel()])
        value = 0.5 * float(np.sum((outputs - aim) ** 2)) / len(inputs)
        return value + 0.5 * _DECAY * float(weights @ weights), slope + _DECAY * weights

    start = random.normal(0.0, 0.3, size)
    result: FloatArray = minimize(
        cost, start, jac=True, method="L-BFGS-B", options={"maxiter": _ITERATIONS}
    ).x
    return result
