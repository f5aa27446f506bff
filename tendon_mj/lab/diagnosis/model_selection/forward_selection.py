"""Forward selection with backward elimination."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from tendon_mj.lab.diagnosis.model_selection.comparison import (
    CandidateSet,
    FittedCandidate,
    simplest,
)
from tendon_mj.lab.diagnosis.model_selection.context import SelectionContext

_MOST_EFFECTS = 3

Rivals = Mapping[str, list[FittedCandidate]]  # label of an effect → all it was chosen from


class ForwardSelection(NamedTuple):
    """Result of a forward selection.

    Attributes:
        model: last model.
        rivals: for every effect the models it was chosen from, best first.
        first: all candidates for the first effect; None where none was added.
        rounds: at every addition the models that could have been chosen, best first.
        reduced: last model without one of its effects, by label, where that was fitted.
    """

    model: FittedCandidate
    rivals: Rivals
    first: CandidateSet | None
    rounds: list[list[FittedCandidate]]
    reduced: dict[str, FittedCandidate]


def select_forward(
    context: SelectionContext, model: FittedCandidate, rivals: Rivals
) -> ForwardSelection:
    """Add the best effect to a model until none improves it.

    Of tied effects the simplest is added. After each addition the effects without which the model
    is as good are eliminated; selection ends when that leads back to an earlier model.
    """
    rivals, first, rounds = dict(rivals), None, list[list[FittedCandidate]]()
    reduced = dict[str, FittedCandidate]()
    seen = set[frozenset[str]]()
    while len(model.fit.effects) < _MOST_EFFECTS and model.excess > context.detection_limit:
        labels = frozenset(effect.label for effect in model.fit.effects)
        if labels in seen:
            break
        seen.add(labels)
        candidates = context.extend(model)
        first, ranked = first or candidates, list(candidates.fitted)
        if not ranked or not context.improves(model, ranked[0]):
            break
        rounds.append(ranked)
        chosen = context.optimise(simplest(ranked))
        assert chosen.candidate is not None
        others = [other for other in ranked if other.candidate != chosen.candidate]
        rivals[chosen.candidate.label] = sorted([chosen, *others], key=lambda m: m.excess)
        model, reduced = eliminate_backward(context, chosen)
    return ForwardSelection(model, rivals, first, rounds, reduced)


def eliminate_backward(
    context: SelectionContext, model: FittedCandidate
) -> tuple[FittedCandidate, dict[str, FittedCandidate]]:
    """Remove effects without which the model is as good; and `ForwardSelection.reduced`."""
    reduced = dict[str, FittedCandidate]()
    for candidate in model.fit.effects:
        reduced[candidate.label] = context.without(model, candidate)
        if not context.improves(reduced[candidate.label], model):
            return eliminate_backward(context, reduced[candidate.label])
    return model, reduced
