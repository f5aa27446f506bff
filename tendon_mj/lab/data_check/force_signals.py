"""What the signals of recordings may not tell, however well they are fitted."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.units import column_unit

FORCES: Final = "a load cell, a spring scale in one pose, or a known weight on the output"
_UNITS: Final = {"N", "N m"}


def tells_force(columns: Iterable[str]) -> bool:
    """Return whether one of some columns is a force or a torque."""
    return not _UNITS.isdisjoint(map(column_unit, columns))


def doubt_of_signals(recordings: Iterable[Recording]) -> str:
    """State what recordings without any force may not tell; empty if one is measured or drives."""
    if any(tells_force((*r.measured, *r.drive)) for r in recordings):
        return ""
    return (
        "No force is measured: friction, play and an elastic mount may change these signals alike."
        " tendon-mj identify says which effects they tell, and tendon-mj diagnose how far their"
        f" numbers may be off. What would decide: {FORCES}."
    )
