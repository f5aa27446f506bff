"""What a recording of a rig says of itself, and nothing of what is hidden."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tendon_mj.recordings import Uncertain


@dataclass(frozen=True, kw_only=True)
class Side:
    """The side of a rig that its recordings show.

    Attributes:
        drive: column driven. actuator: that it drives.
        travel: drive's unit per metre of the bench's excitation.
        sensors: measured column to sensor.
        known: parameters that the rig's maker measured.
        uncertain: number of the rig to the parameters that are it.
        ranges: of those numbers, with a guess.
        drawn: of those numbers, where the truth lies.
    """

    drive: str
    actuator: str
    travel: float
    sensors: Mapping[str, str]
    known: Mapping[str, float]
    uncertain: Mapping[str, tuple[str, ...]]
    ranges: Mapping[str, Uncertain]
    drawn: Mapping[str, tuple[float, float]]
