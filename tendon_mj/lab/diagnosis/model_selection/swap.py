"""Swap step: every other candidate in the place of each effect of a model."""

from __future__ import annotations

from tendon_mj.lab.diagnosis.model_selection.comparison import FittedCandidate, simplest, tied
from tendon_mj.lab.diagnosis.model_selection.context import SelectionContext
from tendon_mj.lab.diagnosis.model_selection.forward_selection import ForwardSelection, Rivals

_PROMISING = 0.8  # of what the best candidate explains, to be fitted in the place of another


def swap(context: SelectionContext, selection: ForwardSelection) -> tuple[FittedCandidate, Rivals]:
    """Swap each effect of a model for one that leaves significantly less.

    An early choice may have imitated two effects. For the last effect all others were tried when it
    was added, unless one before it was swapped.

    Returns:
        The model, and for each of its effects the models it was chosen from, best first.
    """
    model, rivals = selection.model, dict[str, list[FittedCandidate]]()
    for candidate in selection.model.fit.effects:
        unchanged = model is selection.model
        if unchanged and candidate == model.candidate:
            others = selection.rivals[candidate.label]
        else:
            reduced = selection.reduced.get(candidate.label) if unchanged else None
            reduced = reduced or context.without(model, candidate)
            others = list(context.extend(reduced, _PROMISING, look_down=False).fitted)
        own = next((m for m in others if m.candidate == candidate), None)
        if own is None or own.excess > model.excess:
            own = FittedCandidate(candidate, model.fit, model.validation)
        ranked = [own, *(m for m in others if m.candidate != candidate)]
        ranked.sort(key=lambda m: m.excess)
        chosen = simplest(ranked)
        if chosen.candidate != candidate and not tied(chosen, own):
            model = chosen
        assert chosen.candidate is not None
        kept = chosen.candidate if model is chosen else candidate
        rivals[kept.label] = ranked
    return model, rivals
