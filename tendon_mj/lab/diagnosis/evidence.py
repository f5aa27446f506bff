"""Rms error between simulation and measurement, of the calibrated and of the final model.

Evidence of a verdict: the errors and limits that it was decided by.

Verdict of a diagnosis: what the errors on held-out data allow to say.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.thresholds import CLOSED, PART
from tendon_mj.lab.replay import column_unit
from tendon_mj.typing import FloatArray

Verdict = Literal["named", "parameter", "partly", "nothing missing", "unknown"]

NOISE, NOISE_AND_REPRODUCIBILITY = "noise", "noise and reproducibility"


@dataclass(frozen=True)
class ErrorReduction:
    """Root mean square errors before and after effects were added.

    Attributes:
        before, after: over all signals [``unit``], each in units of its own.
        noise_floor: error of a perfect model, 1 by definition of the unit.
        signals: column → (before, after, one unit) [the column's unit].
        unit: noise, or noise and reproducibility together.
    """

    before: float
    after: float
    noise_floor: float
    signals: dict[str, tuple[float, float, float]]
    unit: str = NOISE

    @property
    def reducible_closed(self) -> float:
        """Share of the error above the noise floor that was removed; 0 where there was none."""
        reducible = self.before - self.noise_floor
        return (self.before - self.after) / reducible if reducible > 0.0 else 0.0

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        return {
            "unit": self.unit,
            "before": self.before,
            "after": self.after,
            "noise_floor": self.noise_floor,
            "reducible_closed": self.reducible_closed,
            "signals": {
                column: {
                    "unit": column_unit(column),
                    "before": before,
                    "after": after,
                    "noise_floor": noise,
                }
                for column, (before, after, noise) in self.signals.items()
            },
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
    edges = np.cumsum([0, *(size for _, _, size in problem.layout())])
    sums: dict[str, list[float]] = {}
    for (k, column, _), first, last in zip(problem.layout(), edges, edges[1:], strict=False):
        inside = mask[first:last]
        level = problem.noise[k][column]
        entry = sums.setdefault(column, [0.0, 0.0, 0.0, 0.0])
        for slot, residual in enumerate((before, after)):
            entry[slot] += float(np.sum((residual[first:last][inside] * level) ** 2))
        entry[2] += float(np.sum((bars[first:last][inside] * level) ** 2))
        entry[3] += float(inside.sum())
    signals = {
        column: tuple(float(np.sqrt(part / count)) for part in parts)
        for column, (*parts, count) in sums.items()
        if count > 0.0
    }
    rms = [float(np.sqrt(np.mean((r[mask] / bars[mask]) ** 2))) for r in (before, after)]
    unit = NOISE if bool((bars[mask] == 1.0).all()) else NOISE_AND_REPRODUCIBILITY
    return ErrorReduction(
        rms[0], rms[1], 1.0, {c: (b, a, n) for c, (b, a, n) in signals.items()}, unit
    )


@dataclass(frozen=True)
class Evidence:
    """What a verdict rests on. Errors are in units of noise and reproducibility together.

    Attributes:
        kinds: of the findings, "missing" or "parameter"; none where nothing was selected.
        calibrated: whether the calibrated model leaves no more than the detection limit on the
            training data.
        extrapolated: errors on held-out data for a step of zero.
        stated: those with the model's own step.
        limit: excess χ² below which nothing is named [-].
        largest: excess χ² above which no model is proven [-].
        beyond: whether the findings would take a calibrated parameter beyond its range, or one of
            them stands at an end of its own.
        excess: excess χ² that the calibrated model leaves on the training data [-].
        step, lumping: excess χ² on held-out data that the simulation's steps, and its guides in
            place of a smooth sheath, may leave [-].
    """

    kinds: Collection[str]
    calibrated: bool
    extrapolated: ErrorReduction
    stated: ErrorReduction
    limit: float
    largest: float
    beyond: bool
    excess: float = 0.0
    step: float = 0.0
    lumping: float = 0.0

    @property
    def left(self) -> float:
        """Excess χ² that remains on held-out data."""
        return self.extrapolated.after**2 - self.extrapolated.noise_floor**2


LARGEST = 8.0  # excess χ² (3 rms), above which a model is not proven whatever it explains
_WORSE = 1.05  # times the error before, from which a signal got worse


def decide(evidence: Evidence) -> Verdict:
    """Decide on the verdict from the errors on held-out data."""
    if not evidence.kinds:
        small = evidence.calibrated and evidence.left <= evidence.limit
        return "nothing missing" if small else "unknown"
    errors = evidence.extrapolated
    if evidence.beyond or evidence.stated.after >= evidence.stated.before:
        return "unknown"
    closed = errors.reducible_closed >= CLOSED or evidence.left <= evidence.limit
    if closed and evidence.left <= evidence.largest:
        return "named" if "missing" in evidence.kinds else "parameter"
    return "partly" if errors.reducible_closed >= PART and not _worsened(errors) else "unknown"


def _worsened(errors: ErrorReduction) -> list[str]:
    """Columns whose error grew to more than the bar."""
    return [
        column
        for column, (before, after, bar) in errors.signals.items()
        if after > _WORSE * max(before, bar)
    ]
