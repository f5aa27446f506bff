"""A number that may change in a rig, by the names that all rigs have for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

Label = tuple[str, str, tuple[float, ...]]  # identifier, name, shape


@dataclass(frozen=True)
class Number:
    """A number of a model that may change from one day to the next.

    Attributes:
        name: of the parameters that it is.
        identifier: of the effect; empty for a parameter that the recordings call uncertain.
        unit: of the number.
        probe: a small change of it [unit].
        shape: of the effect's further numbers, which stay as they are [their units].
    """

    name: str
    identifier: str
    unit: str
    probe: float
    shape: tuple[float, ...] = ()

    @property
    def label(self) -> Label:
        """What it is on every rig; a probe may differ, as it goes by what was measured."""
        return self.identifier, self.name, self.shape

    @property
    def key(self) -> tuple[str, str]:
        """What it is, whatever its shape."""
        return self.identifier, self.name

    def plain(self) -> dict[str, Any]:
        """Its fields, for JSON."""
        return asdict(self)

    @classmethod
    def from_plain(cls, fields: Mapping[str, Any]) -> Number:
        """That of `plain`."""
        return cls(**{**fields, "shape": tuple(fields["shape"])})
