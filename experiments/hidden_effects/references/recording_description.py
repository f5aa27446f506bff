"""Description of a reference in its recordings: columns, known and uncertain parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tendon_mj.lab.recordings import Uncertain


@dataclass(frozen=True, kw_only=True)
class RecordingDescription:
    """Columns and parameters that recordings of a reference state; none shows what is hidden.

    Attributes:
        drive: column of the drive. actuator: that this column drives.
        travel: unit of the drive per metre of the bench's excitation.
        sensors: measured column to sensor.
        sheaths: of the model.
        known: parameters that count as measured, with their values.
        uncertain: attribute of the reference to the model's parameters with this value.
        ranges: guess and range stated for each of these attributes.
        true_ranges: range from which the true value of each of these attributes is drawn.
    """

    drive: str
    actuator: str
    travel: float
    sensors: Mapping[str, str]
    sheaths: tuple[str, ...]
    known: Mapping[str, float]
    uncertain: Mapping[str, tuple[str, ...]]
    ranges: Mapping[str, Uncertain]
    true_ranges: Mapping[str, tuple[float, float]]
