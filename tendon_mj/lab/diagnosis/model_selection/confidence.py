"""Confidence in a selected effect, against rivals that explain as much in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.model_selection.comparison import (
    FittedCandidate,
    loss,
    tie_width,
    tied,
)
from tendon_mj.lab.diagnosis.model_selection.thresholds import STANDARD_ERRORS


@dataclass(frozen=True, eq=False)
class SelectedEffect:
    """An effect in the final model, and its rivals.

    Attributes:
        candidate: the effect.
        rivals: others that the data cannot tell from it.
        confidence: that it is this one and not another effect, 0 … 1.
        models: those that were fitted with the rivals, in their order.
    """

    candidate: Candidate
    rivals: tuple[Candidate, ...]
    confidence: float
    models: tuple[FittedCandidate, ...] = ()


def rate(candidate: Candidate, ranked: Sequence[FittedCandidate]) -> SelectedEffect:
    """Compare an effect with the models it was chosen from, best first.

    With d_k the χ² that another effect k leaves more and w_k the width of a tie, the confidence is
    1/(1 + Σ_k exp(−d_k/w_k)).
    """
    own = next((m for m in ranked if m.candidate == candidate), ranked[0])
    rivals, models, odds = list[Candidate](), list[FittedCandidate](), 1.0
    for model in ranked:
        other = model.candidate
        if other is None or other == candidate:
            continue
        lost = loss(own, model)
        useless = lost.mean > -STANDARD_ERRORS * lost.standard_error
        if len(other.terms) > len(candidate.terms) and useless:
            continue  # more terms, and nothing gained by them
        width = max(lost.standard_error, tie_width(own))
        if other.identifier != candidate.identifier:
            odds += float(np.exp(-max(lost.mean, 0.0) / width))
        if tied(own, model):
            rivals.append(other)
            models.append(model)
    return SelectedEffect(candidate, tuple(rivals), 1.0 / odds, tuple(models))
