"""Evidence of a verdict: the errors and limits that it was decided by."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from tendon_mj.lab.diagnosis.result.error_reduction import ErrorReduction


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
