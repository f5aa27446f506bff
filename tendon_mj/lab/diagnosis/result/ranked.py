"""A row of the ranking of candidates."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Ranked:
    """A candidate for the first finding.

    Attributes:
        identifier, where: effect and elements.
        explains: share of the calibrated model's excess χ² that it removes by screening [-].
        left: cross-validated rms error [noise]; None where it was not fitted, as others promised
            more.
        at_end: end of its range at which its strength stands, so that it names nothing [unit].
        unit: of its strength.
    """

    identifier: str
    where: str
    explains: float
    left: float | None
    at_end: float | None = None
    unit: str = ""
