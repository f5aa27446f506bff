"""Selection of the effects that a model lacks."""

from __future__ import annotations

from dataclasses import dataclass

from tendon_mj.lab.diagnosis.model_selection.backtracking import backtrack
from tendon_mj.lab.diagnosis.model_selection.comparison import CandidateSet, FittedCandidate
from tendon_mj.lab.diagnosis.model_selection.confidence import SelectedEffect, rate
from tendon_mj.lab.diagnosis.model_selection.context import SelectionContext
from tendon_mj.lab.diagnosis.model_selection.forward_selection import select_forward
from tendon_mj.lab.diagnosis.model_selection.swap import swap

_NEAR = (
    0.1  # of the initial excess: where more remains, other choices do not lead to the end either
)


@dataclass(frozen=True, eq=False)
class Selection:
    """Result of a selection.

    Attributes:
        calibrated: model with only the uncertain parameters fitted.
        final: model with the selected effects.
        effects: selected, those first without which the model leaves most.
        first: all candidates for the first of them; None where the calibrated model suffices.
    """

    calibrated: FittedCandidate
    final: FittedCandidate
    effects: tuple[SelectedEffect, ...]
    first: CandidateSet | None


def select_effects(context: SelectionContext, calibrated: FittedCandidate) -> Selection:
    """Select effects forward; where little remains, backtrack and swap.

    Args:
        context: data and candidates.
        calibrated: model with only the uncertain parameters fitted.
    """
    selection = select_forward(context, calibrated, {})
    first, near = selection.first, _NEAR * max(context.initial_excess, 0.0)
    if not selection.model.fit.effects:
        calibrated = selection.model  # fitted further, where its only effect was eliminated
    if context.detection_limit < selection.model.excess < near:
        selection = backtrack(context, selection)
    model, rivals = selection.model, selection.rivals
    if len(model.fit.effects) > 1 and model.excess < near:
        model, rivals = swap(context, selection)
    effects = [rate(candidate, rivals[candidate.label]) for candidate in model.fit.effects]
    if len(effects) > 1:
        reduced = dict(selection.reduced) if model is selection.model else {}
        for effect in effects:
            candidate = effect.candidate
            reduced[candidate.label] = reduced.get(candidate.label) or context.without(
                model, candidate
            )
        effects.sort(key=lambda e: -reduced[e.candidate.label].excess)
    return Selection(calibrated, model, tuple(effects), first)
