"""How far a rig repeats itself between sessions.

There are two estimates, of which the larger counts, column by column:

* repeats: of recordings in one state under one drive, half the mean square difference of their
  residuals. It contains neither the values that were fitted to each, such as a sensor's zero, nor
  an error of the model that all of them share;
* zeros and scales: the residual of recording k is a_k + b_k y_k + rest, y the measured signal. The
  means of a and b over all recordings of one state are an error of the model; their scatter about
  it differs from session to session. Of R recordings in one state the variance is R/(R−1) times the
  mean square of a_k − ā + (b_k − b̄) y_k. If they were driven in different ways, errors of the
  model in one drive and not in another are in it too.

Less than a twentieth of the noise is neglected. If each state was recorded once, scatter between
sessions cannot be told from an error of the model in that state. It is then 0, as it is in a single
session, and the stated noise counts alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from tendon_mj.lab.diagnosis.data import Problem, by_recording
from tendon_mj.lab.diagnosis.limits import ABOVE_NOISE
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_SAME_DRIVE = 0.01  # of its range, rms difference
_SAME_TIME = 1e-3  # of the duration


def bar(problem: Problem, deviations: Mapping[str, float]) -> FloatArray:
    """(m,) measure of each residual: noise and reproducibility together [noise]."""
    bars = np.empty(problem.in_train.size)
    for k, column, rows in problem.signals:
        bars[rows] = np.hypot(1.0, deviations.get(column, 0.0) / problem.noise[k][column])
    return bars


Errors = Mapping[tuple[int, str], FloatArray]


def reproducibility(problem: Problem, residual: FloatArray) -> dict[str, float]:
    """Column → standard deviation between sessions, beyond noise [the column's unit].

    From the training samples of a model's ``residual`` (m,) [noise].
    """
    shown = np.where(problem.in_train, residual, np.nan)
    errors = {(k, c): shown[rows] * problem.levels[k][c] for k, c, rows in problem.signals}
    powers = _powers_of_repeats(problem, errors)
    estimates = {column: float(np.sqrt(np.mean(power))) for column, power in powers.items()}
    if by_recording(problem.recordings):
        for column, power in _powers_of_zeros_and_scales(problem, errors).items():
            scatter = float(np.sqrt(np.mean(power)))
            estimates[column] = max(scatter, estimates.get(column, 0.0))
    deviations = {}
    for column in dict.fromkeys(column for _, column, _ in problem.signals):
        deviation = estimates.get(column, 0.0)
        noise = min(levels[column] for levels in problem.noise if column in levels)
        deviations[column] = deviation if np.hypot(1.0, deviation / noise) > ABOVE_NOISE else 0.0
    return deviations


def _powers_of_zeros_and_scales(problem: Problem, errors: Errors) -> dict[str, list[float]]:
    """Column → variance between sessions of each recording, from lines through its error."""
    lines: dict[tuple[str, int], list[tuple[FloatArray, FloatArray]]] = {}
    states = [recording.known for recording in problem.recordings]
    for (k, column), error in errors.items():
        used = np.isfinite(error)
        if not used.any():
            continue
        signal = problem.recordings[k].columns[column][used]
        basis = np.column_stack([np.ones(signal.size), signal])
        line = np.asarray(np.linalg.lstsq(basis, error[used], rcond=None)[0], np.float64)
        lines.setdefault((column, states.index(states[k])), []).append((basis, line))
    powers: dict[str, list[float]] = {}
    for (column, _), rows in lines.items():
        count = len(rows)
        if count > 1:
            mean = np.mean([line for _, line in rows], axis=0)
            powers.setdefault(column, []).extend(
                count / (count - 1) * float(np.mean((basis @ (line - mean)) ** 2))
                for basis, line in rows
            )
    return powers


def _powers_of_repeats(problem: Problem, errors: Errors) -> dict[str, list[float]]:
    """Column → variance between sessions of each pair of repeats."""
    powers: dict[str, list[float]] = {}
    for (j, one), (k, other) in combinations(enumerate(problem.recordings), 2):
        if not _repeat(one, other):
            continue
        size = min(one.time.size, other.time.size)
        for column in (c for c in one.measured if c in other.measured):
            difference = errors[j, column][:size] - errors[k, column][:size]
            difference = difference[np.isfinite(difference)]
            if difference.size:
                levels = problem.levels[j][column], problem.levels[k][column]
                noise = sum(float(np.mean(level**2)) for level in levels)
                power = 0.5 * (float(np.mean(difference**2)) - noise)
                powers.setdefault(column, []).append(max(power, 0.0))
    return powers


def _repeat(one: Recording, other: Recording) -> bool:
    """Return whether two recordings were driven alike in the same state."""
    if one.known != other.known or one.drive != other.drive or not one.drive:
        return False
    size = min(one.time.size, other.time.size)
    clocks = [r.time[:size] - r.time[0] for r in (one, other)]
    if float(np.abs(clocks[0] - clocks[1]).max()) > _SAME_TIME * float(clocks[0][-1]):
        return False
    for column in one.drive:
        first, second = one.columns[column][:size], other.columns[column][:size]
        rms = float(np.sqrt(np.mean((first - second) ** 2)))
        if rms > _SAME_DRIVE * float(np.ptp(first)):
            return False
    return True
