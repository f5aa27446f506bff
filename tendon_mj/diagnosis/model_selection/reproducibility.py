"""Reproducibility of a rig between sessions, from its recordings and a model of them.

Two estimates, of which the larger counts, column by column:

* repeats: of recordings in one state under one drive, half the mean square difference;
* refits: fitted to recording k alone, the shared terms shift by
  δ_k = −(J_kᵀJ_k + ridge)⁻¹ J_kᵀ r_k. What that changes in the recording, J_k δ_k, differs between
  sessions as far as the model can say; with R recordings that share the terms, R/(R−1) of its mean
  square is the variance.

Recordings of one state and one session say nothing of it; it is 0 then, and noise is all there is.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.data.problem import Problem, by_recording
from tendon_mj.diagnosis.model_selection.fit import Fit
from tendon_mj.recordings.recording import Recording

FloatArray = NDArray[np.float64]

_SAME_DRIVE = 0.01  # of its range, rms difference
_SAME_TIME = 1e-3  # of the duration
_RIDGE = 1e-3  # of the shared normal matrix over the recordings: directions one cannot determine


def reproducibility(problem: Problem, fit: Fit) -> dict[str, float]:
    """Column → standard deviation between sessions, beyond noise [the column's unit]."""
    found = dict.fromkeys((column for _, column, _ in problem.layout()), 0.0)
    if by_recording(problem.recordings):
        found |= _from_refits(problem, fit)
    for column, deviation in _from_repeats(problem).items():
        found[column] = max(found[column], deviation)
    return found


def bar(problem: Problem, deviations: Mapping[str, float]) -> FloatArray:
    """(m,) what each residual is judged by: noise and reproducibility together [noise]."""
    return np.concatenate(
        [
            np.full(size, np.hypot(1.0, deviations.get(column, 0.0) / problem.noise[k][column]))
            for k, column, size in problem.layout()
        ]
    )


def _from_refits(problem: Problem, fit: Fit) -> dict[str, float]:
    used = problem.in_train
    free = fit.free & fit.shared
    jacobian, residual = fit.jacobian[:, free], fit.residual
    ridge = _RIDGE * np.diag(np.diag(jacobian[used].T @ jacobian[used]))
    count = len(problem.recordings)
    change = np.zeros(residual.size)
    for k in range(count):
        rows = used & (problem.recording_of == k)
        j = jacobian[rows]
        if j.size:
            change[rows] = j @ np.linalg.solve(j.T @ j + ridge / count, j.T @ residual[rows])
    powers: dict[str, list[float]] = {}
    edges = np.cumsum([0, *(size for _, _, size in problem.layout())])
    for (k, column, _), first, last in zip(problem.layout(), edges, edges[1:], strict=False):
        inside = change[first:last][used[first:last]] * problem.noise[k][column]
        if inside.size:
            powers.setdefault(column, []).append(float(np.mean(inside**2)))
    scale = count / (count - 1)
    return {column: float(np.sqrt(scale * np.mean(power))) for column, power in powers.items()}


def _from_repeats(problem: Problem) -> dict[str, float]:
    powers: dict[str, list[float]] = {}
    for (j, one), (k, other) in combinations(enumerate(problem.recordings), 2):
        if not _repeat(one, other):
            continue
        size = min(one.time.size, other.time.size)
        for column in one.measured.keys() & other.measured.keys():
            difference = one.columns[column][:size] - other.columns[column][:size]
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
