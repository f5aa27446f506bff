"""Verdict of a diagnosis: what the errors on held-out data allow to say."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from tendon_mj.diagnosis.model_selection.thresholds import CLOSED
from tendon_mj.diagnosis.result.diagnosis import Verdict
from tendon_mj.diagnosis.result.error_reduction import ErrorReduction

_MOST = 2.0 / 3.0  # of the error that could be removed: what removes less may be an imitation
_WORSE = 1.05  # times the error before, from which a signal got worse


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
    """

    kinds: Collection[str]
    calibrated: bool
    extrapolated: ErrorReduction
    stated: ErrorReduction
    limit: float
    largest: float
    beyond: bool

    @property
    def left(self) -> float:
        """Excess χ² that remains on held-out data."""
        return self.extrapolated.after**2 - self.extrapolated.noise_floor**2


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
    return "partly" if errors.reducible_closed >= _MOST and not _worsened(errors) else "unknown"


def _worsened(errors: ErrorReduction) -> list[str]:
    """Columns whose error grew to more than the bar."""
    return [
        column
        for column, (before, after, bar) in errors.signals.items()
        if after > _WORSE * max(before, bar)
    ]
