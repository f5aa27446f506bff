"""Verdict of a diagnosis: what the errors on held-out data allow to say."""

from __future__ import annotations

from tendon_mj.diagnosis.model_selection.context import SelectionContext
from tendon_mj.diagnosis.model_selection.select import Selection
from tendon_mj.diagnosis.model_selection.thresholds import CLOSED
from tendon_mj.diagnosis.result.diagnosis import Verdict
from tendon_mj.diagnosis.result.error_reduction import ErrorReduction


def decide(
    context: SelectionContext,
    selection: Selection,
    extrapolated: ErrorReduction,
    stated: ErrorReduction,
    bounds: tuple[float, float],
    beyond: bool,
) -> Verdict:
    """Decide on the verdict from the errors on held-out data.

    Args:
        context, selection: see `prove`.
        extrapolated: errors for a step of zero.
        stated: errors with the model's own step.
        bounds: excess χ² below which nothing is named, and above which nothing is proven [-].
        beyond: whether the effects would take a calibrated parameter beyond its range.
    """
    limit, largest = bounds
    left = extrapolated.after**2 - extrapolated.noise_floor**2
    if left > largest:
        return "unknown"
    if not selection.effects:
        small = selection.calibrated.excess <= context.detection_limit and left <= limit
        return "nothing missing" if small else "unknown"
    closed = extrapolated.reducible_closed >= CLOSED or left <= limit
    if not closed or beyond or stated.after >= stated.before:
        return "unknown"
    missing = any(selected.candidate.kind == "missing" for selected in selection.effects)
    return "named" if missing else "parameter"
