"""Errors before and after effects were added, and the verdict that they allow."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.limits import ABOVE_NOISE, CLOSED, LARGEST_EXCESS
from tendon_mj.lab.units import column_unit
from tendon_mj.typing import FloatArray

Verdict = Literal["named", "parameter", "partly", "nothing missing", "undetermined", "unknown"]

PART = 2.0 / 3.0  # of the error that could be removed: an effect that removes less may imitate

NOISE, NOISE_AND_REPRODUCIBILITY = "noise", "noise and reproducibility"


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
        signals = {}
        for column, (before, after, noise) in self.signals.items():
            errors = {"before": before, "after": after, "noise_floor": noise}
            signals[column] = {"unit": column_unit(column), **errors}
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
