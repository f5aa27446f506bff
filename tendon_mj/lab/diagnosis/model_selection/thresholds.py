"""Thresholds of the selection, in excess χ² (reduced χ² − 1) [-]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tendon_mj.lab.diagnosis.data.problem import Problem, by_recording
from tendon_mj.lab.recordings import noise_of_repeats
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
