"""Reproducibility of a rig between sessions, from its recordings and a model of them.

Two estimates, of which the larger counts, column by column:

* repeats: of recordings in one state under one drive, half the mean square difference of their
  residuals. What was fitted to each, such as a sensor's zero, is no part of it, nor is what the
  model says wrongly of all of them;
* zeros and scales: the residual of recording k is a_k + b_k y_k + rest, y the measured signal. What
  all recordings of one state have in common, the means of a and b, is an error of the model; how
  they scatter about it differs from session to session. Of R recordings in one state the variance
  is R/(R−1) times the mean square of a_k − ā + (b_k − b̄) y_k. Where they were driven in different
  ways, what the model says wrongly of one drive and not of another is in it too.

What adds less than a twentieth to the noise is none.

Where each state was recorded once, what differs between sessions cannot be told from what the model
says wrongly of the state. It is then 0, as it is in a single session, and the stated noise is all
there is.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from tendon_mj.lab.diagnosis.data.problem import Problem, by_recording
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

Errors = Mapping[tuple[int, str], FloatArray]

_SAME_DRIVE = 0.01  # of its range, rms difference
_SAME_TIME = 1e-3  # of the duration
_MORE = 1.05  # times the noise


def reproducibility(problem: Problem, residual: FloatArray) -> dict[str, float]:
    """Column → standard deviation between sessions, beyond noise [the column's unit].

    Args:
        problem: data, of which the training samples count.
        residual: (m,) of a model, in units of noise.
    """
    errors = _errors(problem, residual)
    found = dict.fromkeys((column for _, column, _ in problem.layout()), 0.0)
    if by_recording(problem.recordings):
        found |= _from_zeros_and_scales(problem, errors)
    for column, deviation in _from_repeats(problem, errors).items():
        found[column] = max(found[column], deviation)
    return {c: d if _adds(problem, c, d) else 0.0 for c, d in found.items()}


def _adds(problem: Problem, column: str, deviation: float) -> bool:
    """Whether a deviation makes more of the noise of a column."""
    noise = min(levels[column] for levels in problem.noise if column in levels)
    return bool(np.hypot(1.0, deviation / noise) > _MORE)


def bar(problem: Problem, deviations: Mapping[str, float]) -> FloatArray:
    """(m,) what each residual is judged by: noise and reproducibility together [noise]."""
    return np.concatenate(
        [
            np.full(size, np.hypot(1.0, deviations.get(column, 0.0) / problem.noise[k][column]))
            for k, column, size in problem.layout()
        ]
    )


def _errors(problem: Problem, residual: FloatArray) -> Errors:
    """(recording, column) → (samples,) error [the column's unit], NaN outside the training data."""
    edges = np.cumsum([0, *(size for _, _, size in problem.layout())])
    shown = np.where(problem.in_train, residual, np.nan)
    return {
        (k, column): shown[first:last] * problem.noise[k][column]
        for (k, column, _), first, last in zip(problem.layout(), edges, edges[1:], strict=False)
    }


def _from_zeros_and_scales(problem: Problem, errors: Errors) -> dict[str, float]:
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
    return {column: float(np.sqrt(np.mean(power))) for column, power in powers.items()}


def _from_repeats(problem: Problem, errors: Errors) -> dict[str, float]:
    powers: dict[str, list[float]] = {}
    for (j, one), (k, other) in combinations(enumerate(problem.recordings), 2):
        if not _repeat(one, other):
            continue
        size = min(one.time.size, other.time.size)
        for column in one.measured.keys() & other.measured.keys():
            difference = errors[j, column][:size] - errors[k, column][:size]
            difference = difference[np.isfinite(difference)]
            if difference.size:
                noise = problem.noise[j][column] ** 2 + problem.noise[k][column] ** 2
                power = 0.5 * (float(np.mean(difference**2)) - noise)
                powers.setdefault(column, []).append(max(power, 0.0))
    return {column: float(np.sqrt(np.mean(power))) for column, power in powers.items()}


def _repeat(one: Recording, other: Recording) -> bool:
    """Whether two recordings were driven alike in the same state."""
    if one.known != other.known or one.drive != other.drive or not one.drive:
        return False
    size = min(one.time.size, other.time.size)
    clocks = [r.time[:size] - r.time[0] for r in (one, other)]
    if float(np.abs(clocks[0] - clocks[1]).max()) > _SAME_TIME * float(clocks[0][-1]):
        return False
    for column in one.drive:
        first, second = one.columns[column][:size], other.columns[column][:size]
        span = float(np.ptp(first))
        if float(np.sqrt(np.mean((first - second) ** 2))) > _SAME_DRIVE * span:
            return False
    return True
