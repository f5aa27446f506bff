"""Criteria of a diagnosis: thresholds in excess χ² (reduced χ² − 1) [-], and the verdict.

The reproducibility of a rig between sessions has two estimates, of which the larger counts, column
by column:

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

`decide` reaches the verdict from errors on held-out data and their limits.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, Final, Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import SMALLEST_EXCESS as SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.data import Problem, by_recording
from tendon_mj.lab.noise import noise_of_repeats
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulates
from tendon_mj.lab.units import column_unit
from tendon_mj.typing import FloatArray

Verdict = Literal["named", "parameter", "partly", "nothing missing", "undetermined", "unknown"]

_CERTAIN = 0.99  # probability with which rests of a right model leave less
STANDARD_ERRORS = 2.0  # of a gain in χ²: less may be chance
CLOSED = 0.985  # of the rms error above noise: a model that closes less does not explain it
PART = 2.0 / 3.0  # of the error that could be removed: an effect that removes less may imitate
# of a signal's range: error of lumping and stepping, where it is not measured
_DISCRETISATION = 0.0025
_TWICE = 2.0
_SHARE = 0.05, 0.1  # of the remaining excess, that an effect has to gain; across recordings

_SAME_DRIVE = 0.01  # of its range, rms difference
_SAME_TIME = 1e-3  # of the duration
ABOVE_NOISE = 1.05  # times the noise, or the error before: less is neglected
NOISE, NOISE_AND_REPRODUCIBILITY = "noise", "noise and reproducibility"
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
    powers = np.array(
        [
            (
                problem.lumping.get(column, _DISCRETISATION)
                * float(np.ptp(problem.recordings[k].columns[column]))
                / (problem.noise[k][column] * float(bars[rows.start]))
            )
            ** 2
            for k, column, rows in problem.signals
        ]
    )
    most = float(np.mean(powers))
    if residual is None or judged is None:
        return most
    counts = np.array([float(judged[rows].sum()) for _, _, rows in problem.signals])
    squares = np.where(judged, (residual / bars) ** 2 - 1.0, 0.0)
    left = np.array([float(squares[rows].sum()) for _, _, rows in problem.signals])
    _, of_column = np.unique([column for _, column, _ in problem.signals], return_inverse=True)
    left = np.maximum(np.bincount(of_column, left), 0.0)
    twice = _TWICE**2 * np.bincount(of_column, powers * counts)
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


@dataclass(frozen=True)
class ErrorReduction:
    """Root mean square errors before and after effects were added."""

    # over all signals [unit], each in units of its own
    before: float
    after: float
    noise_floor: float  # error of a perfect model, 1 by definition of the unit
    # column → (before, after, one unit) [the column's unit]
    signals: dict[str, tuple[float, float, float]]
    unit: str = NOISE  # noise, or noise and reproducibility together

    @property
    def reducible_closed(self) -> float:
        """Share of the error above the noise floor that was removed; 0 if there was none."""
        reducible = self.before - self.noise_floor
        return (self.before - self.after) / reducible if reducible > 0.0 else 0.0

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        signals = {
            column: {
                "unit": column_unit(column),
                "before": before,
                "after": after,
                "noise_floor": noise,
            }
            for column, (before, after, noise) in self.signals.items()
        }
        return {
            "unit": self.unit,
            "before": self.before,
            "after": self.after,
            "noise_floor": self.noise_floor,
            "reducible_closed": self.reducible_closed,
            "signals": signals,
        }


def measure_errors(
    problem: Problem,
    before: FloatArray,
    after: FloatArray,
    mask: NDArray[np.bool_],
    bars: FloatArray | None = None,
) -> ErrorReduction:
    """Errors over the residuals of ``mask`` (m,); ``before`` and ``after`` are (m,) in noise.

    ``bars`` (m,) [noise] are the units of the result where they are not the noise.
    """
    bars = np.ones(mask.size) if bars is None else bars
    sums: dict[str, list[float]] = {}
    for k, column, rows in problem.signals:
        inside, level = mask[rows], problem.levels[k][column][mask[rows]]
        entry = sums.setdefault(column, [0.0, 0.0, 0.0, 0.0])
        for slot, errors in enumerate((before, after, bars)):
            entry[slot] += float(np.sum((errors[rows][inside] * level) ** 2))
        entry[3] += float(inside.sum())
    signals = {
        column: (float(np.sqrt(b / count)), float(np.sqrt(a / count)), float(np.sqrt(n / count)))
        for column, (b, a, n, count) in sums.items()
        if count > 0.0
    }
    rms = [float(np.sqrt(np.mean((r[mask] / bars[mask]) ** 2))) for r in (before, after)]
    unit = NOISE if bool((bars[mask] == 1.0).all()) else NOISE_AND_REPRODUCIBILITY
    return ErrorReduction(rms[0], rms[1], 1.0, signals, unit)


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Errors of the calibrated and the final model on held-out data, and their limits."""

    # of the findings, "missing" or "parameter"; none if nothing was selected
    kinds: Collection[str] = ()
    # whether the calibrated model leaves no more than the detection limit on the training data
    calibrated: bool = True
    held_out: ErrorReduction  # errors with the model's own step [noise]
    weighed: ErrorReduction  # the same in units of noise and reproducibility together
    extrapolated: ErrorReduction  # these for a step of zero, by which the verdict is decided
    zero_step: float = 1.0  # error of the final model for a step of zero [noise]
    # column → standard deviation between sessions [the column's unit]
    reproducibility: Mapping[str, float] = field(default_factory=dict)
    limit: float  # excess χ² below which nothing is named [-]
    largest: float = LARGEST_EXCESS  # excess χ² above which no model is proven [-]
    # uncertain parameters that the findings would take beyond their ranges
    beyond: Sequence[str] = ()
    at_end: bool = False  # whether a fitted strength lies at a limit of its range
    non_smooth: bool = False  # whether a finding is of a non-smooth effect
    excess: float = 0.0  # excess χ² that the calibrated model leaves on the training data [-]
    # excess χ² on held-out data that the simulation's steps, and its guides in place of a smooth
    # sheath, may leave [-]; without a sheath the second is 0
    step: float = 0.0
    lumping: float = 0.0
    # whether the calibrated model, with its own step, leaves no more than noise on all data: where
    # more is left in ever shorter steps, the step takes part in what agrees
    agrees: bool = False

    @property
    def remaining(self) -> float:
        """Excess χ² that remains on held-out data."""
        return self.extrapolated.after**2 - self.extrapolated.noise_floor**2


def decide(evidence: Evidence) -> Verdict:
    """The verdict that errors on held-out data and their limits allow."""
    if not evidence.kinds:
        small = evidence.calibrated and evidence.remaining <= evidence.limit
        return "nothing missing" if small or evidence.agrees else "unknown"
    errors, own = evidence.extrapolated, evidence.weighed
    if evidence.beyond or evidence.at_end or own.after >= own.before:
        return "unknown"
    closed = errors.reducible_closed >= CLOSED or evidence.remaining <= evidence.limit
    if closed and evidence.remaining <= evidence.largest:
        return "named" if "missing" in evidence.kinds else "parameter"
    worse = any(a > ABOVE_NOISE * max(before, bar) for before, a, bar in errors.signals.values())
    return "partly" if errors.reducible_closed >= PART and not worse else "unknown"
