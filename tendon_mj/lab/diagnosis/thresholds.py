"""Thresholds of the selection, in excess χ² (reduced χ² − 1) [-].

Reproducibility of a rig between sessions, from its recordings and a model of them.

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
from numpy.typing import NDArray
from scipy import stats

from tendon_mj.lab.diagnosis.data import Problem, by_recording
from tendon_mj.lab.recordings import Recording, noise_of_repeats
from tendon_mj.lab.replay import Simulates
from tendon_mj.typing import FloatArray

SMALLEST_EXCESS = 0.2  # 0.45 noise rms: less is not worth a name
_CERTAIN = 0.99  # probability with which rests of a right model leave less
STANDARD_ERRORS = 2.0  # of a gain in χ²: less may be chance
CLOSED = 0.985  # of the rms error above noise: a model that closes less does not explain it
PART = 2.0 / 3.0  # of the error that could be removed: what removes less may be an imitation
_DISCRETISATION = 0.0025  # of a signal's range: what lumping and stepping leave
_SHARE = 0.05, 0.1  # of the excess left now, that an effect has to gain; across recordings


def detection_limit(
    problem: Problem,
    step_error: float,
    bars: FloatArray | None = None,
    judged: NDArray[np.bool_] | None = None,
) -> float:
    """Excess χ² below which nothing is named, for a simulation with that `step_error`.

    ``bars`` (m,) of `reproducibility.bar`, where residuals are judged by more than noise;
    ``judged`` (m,) which residuals are judged, by default the training data.
    """
    count = int((problem.in_train if judged is None else judged).sum())
    return max(
        SMALLEST_EXCESS,
        chance_excess(problem, count),
        step_error,
        discretisation_error(problem, bars),
    )


def chance_excess(problem: Problem, count: int) -> float:
    """Excess χ² that ``count`` rests of a right model exceed in one of a hundred cases; else 0.

    Rests are few and independent. Where their noise is estimated from n repeats, its own error
    counts: χ²/m has an F distribution of m and n degrees of freedom.
    """
    if not all(recording.quasi_static for recording in problem.recordings):
        return 0.0
    repeats = [
        noise_of_repeats(recording, column)[1]
        for recording in problem.recordings
        for column, measured in recording.measured.items()
        if measured.noise is None
    ]
    if repeats:
        return float(stats.f.ppf(_CERTAIN, count, max(1, min(repeats)))) - 1.0
    return float(stats.chi2.ppf(_CERTAIN, count)) / count - 1.0


def discretisation_error(problem: Problem, bars: FloatArray | None = None) -> float:
    """Mean square error, over all residuals, of a sheath lumped into guides; 0 without a sheath."""
    if not has_sheath(problem.simulate):
        return 0.0
    first = np.cumsum([0, *(size for _, _, size in problem.layout())])
    powers = [
        (
            _DISCRETISATION
            * float(np.ptp(problem.recordings[k].columns[column]))
            / problem.noise[k][column]
            / (1.0 if bars is None else float(bars[first[j]]))
        )
        ** 2
        for j, (k, column, _) in enumerate(problem.layout())
    ]
    return float(np.mean(powers))


def has_sheath(simulate: Simulates) -> bool:
    """Whether a simulator has a sheath, by its coefficient of friction."""
    parameters = simulate.parameters.items()
    return any(name.endswith(".friction") and p.kind == "live" for name, p in parameters)


def reducible_excess(problem: Problem, residual: FloatArray) -> float:
    """Excess χ² of training residuals (m,), of no signal more than its own variation.

    Without friction a carriage drifts by metres where its signal spans centimetres; a share of
    metres would be no measure of what a better model may leave.
    """
    edges = np.cumsum([0, *(size for _, _, size in problem.layout())])
    total, count = 0.0, 0
    for (k, column, _), first, last in zip(problem.layout(), edges, edges[1:], strict=False):
        used = problem.in_train[first:last]
        series = problem.recordings[k].columns[column][used] / problem.noise[k][column]
        size = int(used.sum())
        if size:
            mean = float(np.mean(residual[first:last][used] ** 2))
            total += size * min(mean, 1.0 + float(np.var(series)))
            count += size
    return total / count - 1.0


def least_share(problem: Problem) -> float:
    """Share of the excess χ² left now, below which a gain is not worth an effect."""
    return _SHARE[1] if by_recording(problem.recordings) else _SHARE[0]


def unexplained_excess(initial: float) -> float:
    """Excess χ² that may remain of an ``initial`` one in a model that explains it."""
    before = np.sqrt(1.0 + max(initial, 0.0)) - 1.0
    return float((1.0 + (1.0 - CLOSED) * before) ** 2 - 1.0)


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
