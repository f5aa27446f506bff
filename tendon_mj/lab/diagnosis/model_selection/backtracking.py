"""Backtracking: the second-best choice, where the best led near the end and not to it."""

from __future__ import annotations

from tendon_mj.lab.diagnosis.model_selection.context import SelectionContext
from tendon_mj.lab.diagnosis.model_selection.forward_selection import (
    ForwardSelection,
    select_forward,
)

_ROUNDS = 2


def backtrack(context: SelectionContext, selection: ForwardSelection) -> ForwardSelection:
    """Select forward again from the second best of each of the first rounds; keep the best."""
    best = selection
    for ranked in reversed(selection.rounds[:_ROUNDS]):
        if len(ranked) < 2 or best.model.excess <= context.detection_limit:
            continue
        second = ranked[1]
        assert second.candidate is not None
        rivals = {**selection.rivals, second.candidate.label: ranked}
        again = select_forward(context, context.polish(second), rivals)
        if context.improves(best.model, again.model):
            best = again
    return best
