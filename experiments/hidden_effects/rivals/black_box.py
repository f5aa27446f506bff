"""A small model without physics: ridge regression on histories of the drive, for prediction only.

`python -m experiments.hidden_effects.rivals.black_box --help`. Its inputs are the drive's history
and what recordings know differently, such as the bend; beside these it may have a hidden layer of
random weights. Size of the layer and ridge are those that predict each training recording best from
the others.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from experiments.hidden_effects.case_folder import Case
from experiments.hidden_effects.rivals.rig import noise, run_rival
from experiments.hidden_effects.rivals.term_fit import errors
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

LAYERS = (0, 100, 300)  # hidden units
RIDGES = 10.0 ** np.arange(-4, 4)
SEED = 0  # of the hidden layer
LAGS = (0.004, 0.01, 0.02, 0.04, 0.08, 0.16, 0.3, 0.6, 1.0, 2.0)  # s
WIDTHS = np.linspace(0.02, 0.6, 12)  # of plays, over the range of the drive [-]
FAST = 0.3  # speed at which the sign of the motion is told, in ranges of the drive per second


class _Inputs:
    """Standardised inputs of recordings, from the training recordings' mean and deviation."""

    def __init__(self, train: list[Recording]) -> None:
        (self.drive,) = train[0].drive
        self.span = max(float(np.ptp(recording.columns[self.drive])) for recording in train)
        self.known = [n for n in train[0].known if len({r.known[n] for r in train}) > 1]
        raw = np.concatenate([self._raw(recording) for recording in train])
        self.mean, self.deviation = raw.mean(axis=0), raw.std(axis=0) + 1e-12

    def _raw(self, recording: Recording) -> FloatArray:
        history = drive_history(recording.time, recording.columns[self.drive], self.span)
        known = np.tile([recording.known[name] for name in self.known], (len(history), 1))
        return np.hstack([history, known])

    def of(self, recording: Recording, units: int) -> FloatArray:
        """(samples, features), with a hidden layer of so many units and a constant."""
        plain = (self._raw(recording) - self.mean) / self.deviation
        rng, count = np.random.default_rng(SEED), plain.shape[1]
        weights = rng.normal(size=(count, units)) / np.sqrt(count)
        hidden = np.tanh(plain @ weights + rng.uniform(-1.0, 1.0, units))
        return np.hstack([plain, hidden, np.ones((len(plain), 1))])


def solve(case: Case) -> dict[str, Any]:
    """Predict the held-out recordings of a case; content of result.json."""
    inputs = _Inputs(case.train)
    targets = [_measured(recording) for recording in case.train]
    best, weights, units = np.inf, np.empty((0, 0)), 0
    for size in LAYERS:
        sets = [inputs.of(recording, size) for recording in case.train]
        squares = [x.T @ x for x in sets]
        products = [x.T @ y for x, y in zip(sets, targets, strict=True)]
        for ridge in RIDGES:
            regular = ridge * np.eye(len(squares[0]))
            missed = 0.0
            for own, square, part, target in zip(sets, squares, products, targets, strict=True):
                others = np.linalg.solve(sum(squares) - square + regular, sum(products) - part)
                missed += float(np.sum((own @ others - target) ** 2))
            if missed < best:
                best, units = missed, size
                weights = np.linalg.solve(sum(squares) + regular, sum(products))
    residual = [
        _unbiased(recording, inputs.of(recording, units) @ weights - _measured(recording))
        for recording in case.held_out
    ]
    return {
        "verdict": "prediction only",
        "effects": [],
        "gap": errors(case.held_out, np.concatenate([part.T.ravel() for part in residual])),
    }


def _measured(recording: Recording) -> FloatArray:
    """(samples, columns) [noise]."""
    columns = recording.measured
    return np.stack([recording.columns[c] / noise(recording, c) for c in columns], axis=1)


def _unbiased(recording: Recording, residual: FloatArray) -> FloatArray:
    """Residual less its mean, where the sensors' zeros were set anew; every rival fits these."""
    zeros = any(name.endswith(".offset") for name in recording.session)
    return residual - residual.mean(axis=0) if zeros else residual


if __name__ == "__main__":
    sys.exit(run_rival(solve, "black_box"))


def drive_history(time: FloatArray, drive: FloatArray, span: float) -> FloatArray:
    """(samples, features): the drive, its rate, its past, and its plays.

    Args:
        time: samples [s].
        drive: at these.
        span: range of the drive in all recordings.
    """
    rate = np.gradient(drive, time)
    past = [np.interp(time - lag, time, drive) - drive for lag in LAGS]
    plays = [_play(drive, width * span) for width in WIDTHS]
    return np.column_stack([drive, rate, np.tanh(rate / (FAST * span)), *past, *plays])


def _play(drive: FloatArray, width: float) -> FloatArray:
    """Play operator from 0: w follows the drive u if it would else be off by more than a width.

    w_k = min(max(w_{k-1}, u_k − r), u_k + r).
    """
    out = np.empty_like(drive)
    state = 0.0
    for k, value in enumerate(drive):
        out[k] = state = min(max(state, value - width), value + width)
    return out
