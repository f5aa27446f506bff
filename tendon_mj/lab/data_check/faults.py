"""Warnings of faults, and which faults follow from others."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DataWarning:
    """Something in a recording that a fit would take for a property of the rig."""

    identifier: str  # its kind in one word
    place: str  # recording and column, actuator or joint
    value: str  # the finding, with its unit
    way_out: str  # what to do
    # whether a fit cannot see through it, so that no effect is to be named meanwhile
    blocks: bool = False

    @property
    def sentence(self) -> str:
        """The warning in one line."""
        return f"{self.place}: {self.value}; {self.way_out}"

    def result(self) -> dict[str, str | bool]:
        """Plain entries for `result.json`."""
        return vars(self) | {"sentence": self.sentence}


WRONG_TIMES = {"times_in_ms", "times_too_short"}  # with which no simulation is of use
DRIVE_LOST = {"turn", "wraps", "zero_step"}  # a drive with which no reading is as the model's
_JUMPED = {
    *("spike", "frozen", "start", "below_zero", "unit"),
    *("sign", "slack", "saturated", "weak_motor"),
}
# fault → others of the same column that follow from it
FOLLOW = {
    "range_end": {"frozen", "coarse"},
    "repeated": {"frozen"},
    "coarse": {"frozen"},
    "below_zero": {"start"},
    "spike": {"below_zero", "range_end", "repeated"},
    "no_reading": {*_JUMPED, "coarse", "diameter", "nothing_moves", "repeated", "unlike"},
    "sign": {"below_zero"},
    "nothing_moves": {"below_zero", "noise"},
    "unit": {"below_zero", "coarse", "noise"},
    **dict.fromkeys([*DRIVE_LOST, "scale_change"], _JUMPED),
}
