"""Verdict of a diagnosis: what the errors on held-out data allow to say."""

from __future__ import annotations

from tendon_mj.lab.diagnosis.model_selection.thresholds import CLOSED, PART
from tendon_mj.lab.diagnosis.result.diagnosis import Verdict
from tendon_mj.lab.diagnosis.result.error_reduction import ErrorReduction
from tendon_mj.lab.diagnosis.result.evidence import Evidence as Evidence

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
