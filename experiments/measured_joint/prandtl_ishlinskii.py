"""Prandtl–Ishlinskii operator: a weighted sum of plays of the command.

y = Σ_k w_k P_k[u] + a + c u², with P_k the play of threshold r_k, r_0 = 0. The constant and the
square stand for what is not symmetric. Every weight is linear in the bend φ, w = w' + w'' φ, so
that the fit is linear least squares (with a small ridge) and has one minimum.

P. Krejčí, K. Kuhnen: Inverse control of systems with hysteresis and creep, IEE Proc. Control Theory
Appl. 148(3), 2001.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from experiments.measured_joint.prediction import Predict, Series
from experiments.measured_joint.recording import COLUMNS, COMMAND, bend, noise
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_AMPLITUDE = math.radians(60.0)  # of the command
_THRESHOLDS = np.linspace(0.0, 1.8 * _AMPLITUDE, 13)  # a play as wide as the stroke never moves
_LARGEST_BEND = math.radians(240.0)  # scale of the bend
_RIDGE = 1e-3  # of a weight, in errors of the noise's size at every sample


def fit_prandtl_ishlinskii(train: Sequence[Recording], seed: int = 0) -> Predict:
    """Fit the weights of each measured column; nothing is random."""
    table = np.concatenate([_plays(r) for r in train])
    weight = math.sqrt(_RIDGE * len(table))
    rows = np.vstack([table, weight * np.eye(table.shape[1])])
    weights = {}
    for column in COLUMNS:
        scale = noise(train[0], column)
        aim = np.concatenate([r.columns[column] for r in train]) / scale
        padded = np.concatenate([aim, np.zeros(table.shape[1])])
        weights[column] = scale * np.linalg.lstsq(rows, padded, rcond=None)[0]

    def predict(recording: Recording) -> Series:
        plays = _plays(recording)
        return {column: plays @ weights[column] for column in COLUMNS}

    return predict


def play(series: FloatArray, threshold: float) -> FloatArray:
    """Play of a series, at rest in the middle before it begins."""
    played = np.empty_like(series)
    now = 0.0
    for k, value in enumerate(series):
        now = min(max(now, value - threshold), value + threshold)
        played[k] = now
    return played


def _plays(recording: Recording) -> FloatArray:
    """(n, p) plays, constant and square of the command, and each of them times the bend."""
    command = recording.columns[COMMAND] / _AMPLITUDE
    columns = [play(command, r / _AMPLITUDE) for r in _THRESHOLDS]
    table = np.column_stack([*columns, np.ones_like(command), command**2])
    return np.hstack([table, bend(recording) / _LARGEST_BEND * table])
