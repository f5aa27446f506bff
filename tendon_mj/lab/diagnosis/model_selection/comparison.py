"""Comparison of fitted models by their cross-validated χ²."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.model_selection.cross_validation import CrossValidation, Gain, gain
from tendon_mj.lab.diagnosis.model_selection.fit import Fit
from tendon_mj.lab.diagnosis.model_selection.screening import ScreeningScore
from tendon_mj.lab.diagnosis.model_selection.thresholds import STANDARD_ERRORS


@dataclass(frozen=True, eq=False)
class FittedCandidate:
    """A model fitted with a candidate effect, and its cross-validation.

    Attributes:
        candidate: effect that was added or swapped in last; None for the calibrated model.
        fit: of all terms of the model.
        validation: on blocks left out of the fit.
    """

    candidate: Candidate | None
    fit: Fit
    validation: CrossValidation

    @property
    def excess(self) -> float:
        """Cross-validated excess χ² (reduced χ² − 1) [-]."""
        return self.validation.excess


@dataclass(frozen=True, eq=False)
class CandidateSet:
    """Candidates for one more effect.

    Attributes:
        scores: of all that change a residual, best first.
        fitted: those that were fitted and whose strength the data determine, best first.
        at_end: those that were fitted and ended at an end of their range, best first.
    """

    scores: tuple[ScreeningScore, ...]
    fitted: tuple[FittedCandidate, ...]
    at_end: tuple[FittedCandidate, ...] = ()


def loss(best: FittedCandidate, other: FittedCandidate) -> Gain:
    """Gain of the best model over the other."""
    return gain(other.validation, best.validation)


def tied(best: FittedCandidate, other: FittedCandidate) -> bool:
    """Whether the data cannot tell the two models apart."""
    lost = loss(best, other)
    return lost.mean < max(STANDARD_ERRORS * lost.standard_error, tie_width(best))


def tie_width(best: FittedCandidate) -> float:
    """Insignificant difference of excess χ²: a quarter of what the best model does not explain."""
    return 0.02 + 0.25 * max(best.excess, 0.0)


def simplest(ranked: Sequence[FittedCandidate]) -> FittedCandidate:
    """Simplest model tied with the first.

    Single parameters before effects, effects of the rig before those of its sensors, and few terms
    before many.
    """
    equal = [model for model in ranked if tied(ranked[0], model)]
    return min(equal, key=lambda model: (_complexity(model.candidate), model.excess))


def _complexity(candidate: Candidate | None) -> tuple[bool, bool, int]:
    if candidate is None:
        return (False, False, 0)
    count = len(candidate.terms)
    return (candidate.kind == "missing" or count > 1, candidate.on_sensor, count)
