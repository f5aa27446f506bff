"""A warning about a recording: what, where, which value, and the way out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DataWarning:
    """Something in a recording that a fit would take for a property of the rig.

    Attributes:
        identifier: what it is, one word: the same for all warnings of a kind.
        place: recording and column, actuator or joint.
        value: what was found there, with its unit.
        way_out: what to do.
        blocks: whether a fit cannot see through it, so that no effect is to be named meanwhile.
    """

    identifier: str
    place: str
    value: str
    way_out: str
    blocks: bool = False

    @property
    def sentence(self) -> str:
        """The warning in one line."""
        return f"{self.place}: {self.value}; {self.way_out}"

    def result(self) -> dict[str, str | bool]:
        """Plain entries for `result.json`."""
        return vars(self) | {"sentence": self.sentence}
