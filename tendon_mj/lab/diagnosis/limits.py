"""Limits in excess χ² (reduced χ² − 1) [-]: below them nothing is named, or no effect added."""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import SMALLEST_EXCESS as SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.data import Problem, by_recording
from tendon_mj.lab.noise import noise_of_repeats
from tendon_mj.lab.replay import Simulates
from tendon_mj.typing import FloatArray

_CERTAIN = 0.99  # probability with which rests of a right model leave less
STANDARD_ERRORS = 2.0  # of a gain in χ²: less may be chance
CLOSED = 0.985  # of the rms error above noise: a model that closes less does not explain it
# of a signal's range: error of lumping and stepping, where it is not measured
_DISCRETISATION = 0.0025
_TWICE = 2.0
_SHARE = 0.05, 0.1  # of the remaining excess, that an effect has to gain; across recordings
ABOVE_NOISE = 1.05  # times the noise, or the error before: less is neglected
LARGEST_EXCESS: Final = 8.0  # excess χ² (3 rms), above which no model is proven


def detection_limit(
    problem: Problem,
    step_error: float,
    bars: FloatArray | None = None,
    judged: NDArray[np.bool_] | None = None,
    residual: FloatArray | None = None,
) -> float:
    """Excess χ² below which nothing is named, for a simulation with that `step_error`.

    ``bars`` (m,) of `bar`, where residuals are judged by more than noise; ``judged`` (m,) which
    residuals are judged, by default the training data; ``residual`` (m,) of the calibrated model,
    see `discretisation_error`.
    """
    judged = problem.in_train if judged is None else judged
    return max(
        SMALLEST_EXCESS,
        chance_excess(problem, int(judged.sum())),
        step_error,
        discretisation_error(problem, bars, judged, residual),
    )


def chance_excess(problem: Problem, count: int) -> float:
    """Excess χ² that ``count`` rests of a right model exceed in one of a hundred cases; else 0.

    Rests are few and independent. If their noise is estimated from n repeats, its own error
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
        return float(scipy.stats.f.ppf(_CERTAIN, count, max(1, min(repeats)))) - 1.0
    return float(scipy.stats.chi2.ppf(_CERTAIN, count)) / count - 1.0


def discretisation_error(
    problem: Problem,
    bars: FloatArray | None = None,
    judged: NDArray[np.bool_] | None = None,
    residual: FloatArray | None = None,
) -> float:
    """Mean square error, over all residuals, of a sheath lumped into guides; 0 without a sheath.

    If the ``residual`` (m,) of the calibrated model is more than twice that in one column, the
    others count no more than they are off: a precise one would hide the error of that.
    """
    if not has_sheath(problem.simulate):
        return 0.0
    bars = np.ones(problem.in_train.size) if bars is None else bars
    powers = []
    for k, column, rows in problem.signals:
        share = problem.lumping.get(column, _DISCRETISATION)
        error = share * float(np.ptp(problem.recordings[k].columns[column]))
        powers.append((error / (problem.noise[k][column] * float(bars[rows.start]))) ** 2)
    most = float(np.mean(powers))
    if residual is None or judged is None:
        return most
    counts = np.array([float(judged[rows].sum()) for _, _, rows in problem.signals])
    squares = np.where(judged, (residual / bars) ** 2 - 1.0, 0.0)
    left = np.array([float(squares[rows].sum()) for _, _, rows in problem.signals])
    _, of_column = np.unique([column for _, column, _ in problem.signals], return_inverse=True)
    left = np.maximum(np.bincount(of_column, left), 0.0)
    twice = _TWICE**2 * np.bincount(of_column, np.array(powers) * counts)
    if np.all(left <= twice):
        return most
    return min(most, float(np.minimum(left, twice).sum() / counts.sum()))


def has_sheath(simulate: Simulates) -> bool:
    """Return whether a simulator has a sheath, by its coefficient of friction."""
    parameters = simulate.parameters.items()
    return any(name.endswith(".friction") and p.kind == "live" for name, p in parameters)


def reducible_excess(problem: Problem, residual: FloatArray) -> float:
    """Excess χ² of training residuals (m,), of no signal more than its own variation.

    Without friction a carriage drifts by metres where its signal spans centimetres; a share of
    metres would be no measure of the error that a better model may leave.
    """
    total, count = 0.0, 0
    for k, column, rows in problem.signals:
        used = problem.in_train[rows]
        series = problem.recordings[k].columns[column][used] / problem.levels[k][column][used]
        if series.size:
            mean = float(np.mean(residual[rows][used] ** 2))
            total += series.size * min(mean, 1.0 + float(np.var(series)))
            count += series.size
    return total / count - 1.0


def least_share(problem: Problem) -> float:
    """Share of the remaining excess χ², below which a gain is not worth an effect."""
    return _SHARE[1] if by_recording(problem.recordings) else _SHARE[0]


def unexplained_excess(initial: float) -> float:
    """Excess χ² that may remain of an ``initial`` one in a model that explains it."""
    before = np.sqrt(1.0 + max(initial, 0.0)) - 1.0
    return float((1.0 + (1.0 - CLOSED) * before) ** 2 - 1.0)
