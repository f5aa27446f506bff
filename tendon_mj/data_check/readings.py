"""Warnings where measured columns and a simulation at the stated numbers differ beyond any fit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tendon_mj.data_check.warning import DataWarning
from tendon_mj.recordings import Recording
from tendon_mj.replay.units import column_unit

FloatArray = NDArray[np.float64]

_THOUSAND = 100.0  # ratio of two ranges from which it may be 1000: friction is not proportional
_DEGREES, _NEARLY = (
    180.0 / np.pi,
    1.5,
)  # ratio of degrees and radians, and by how much it may be off
_AGAINST = -0.7  # correlation below which a column runs against the model
_STILL = 1e-6  # of a value's size, a range that is no motion
_OFF = 0.15  # of the measured range, by which the start may differ
_NOISES = 5.0  # of the stated noise, likewise
_FIRST = 5  # samples that are the start


def drive_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of a recording that drives nothing, or whose driven columns all stand still."""
    found = []
    if not recording.drive:
        found.append(
            DataWarning(
                "nothing_moves",
                recording.name,
                "no column is in [drive]",
                "say which column commands which actuator",
            )
        )
    elif all(_stands(recording.columns[column]) for column in recording.drive):
        columns = ", ".join(repr(recording.written(column)) for column in recording.drive)
        found.append(
            DataWarning(
                "nothing_moves",
                f"{recording.name}, [drive] {columns}",
                "stands still",
                "friction shows where the motion reverses: record one that goes back and forth",
            )
        )
    return found


def reading_warnings(recording: Recording, simulated: Recording) -> list[DataWarning]:
    """Warn of measured columns: no motion, a wrong unit, a reversed sign, another start.

    A column that moves in one of the two alone, or in a wrong unit, is told nothing more of.
    """
    found = []
    for column in recording.measured:
        warning = _one_warning(recording, column, simulated.columns[column])
        if warning:
            found.append(warning)
    return found


def _one_warning(recording: Recording, column: str, shown: FloatArray) -> DataWarning | None:
    read, unit = recording.columns[column], column_unit(column)
    place = f"{recording.name}, [measured] {recording.written(column)!r}"
    sensor = recording.measured[column].sensor
    span, simulated = float(np.ptp(read)), float(np.ptp(shown))
    if _stands(read):
        return DataWarning(
            "nothing_moves",
            place,
            f"reads {read[0]:.4g} {unit} from the first sample to the last",
            "if the sensor was not connected, leave the column out of [measured]",
        )
    if _stands(shown):
        return DataWarning(
            "nothing_moves",
            place,
            f"moves by {span:.3g} {unit}, where sensor {sensor!r} of the model stands still at"
            f" {shown[0]:.4g} {unit}",
            "is it this sensor, does the actuator in [drive] move it, and in which unit is that?",
        )
    fault = _unit_fault(span / simulated)
    if fault:
        return DataWarning(
            "unit",
            place,
            f"moves by {span:.3g} {unit}, the model by {simulated:.3g} {unit}: {fault}",
            "name the column with the unit that it is in; if all columns are off, it is the one in"
            " [drive]",
        )
    correlation = float(np.corrcoef(read, shown)[0, 1])
    if correlation < _AGAINST:
        return DataWarning(
            "sign",
            place,
            f"runs against sensor {sensor!r} of the model, correlation {correlation:.2f}",
            f'if the sensor counts the other way, write "{sensor}.scale" = -1 in [known]; if all'
            ' columns do, "<actuator>.command_scale" = -1, or turn the axis in the model',
        )
    return _start_warning(recording, column, shown, place)


def _unit_fault(ratio: float) -> str:
    """What a ratio of ranges, measured over simulated, says of the unit; empty if nothing."""
    large, times = ratio > 1.0, max(ratio, 1.0 / ratio)
    if times > _THOUSAND:
        units = "thousandths of it (mm, mN)" if large else "thousands of it (kN)"
        return (
            f"{times:.2g} times as {'much' if large else 'little'}, as {units} under its name are"
        )
    if _DEGREES / _NEARLY < times < _DEGREES * _NEARLY:
        units = "degrees named radians" if large else "radians named degrees"
        return f"{times:.2g} times as {'much' if large else 'little'}, as {units} are"
    return ""


def _start_warning(
    recording: Recording, column: str, shown: FloatArray, place: str
) -> DataWarning | None:
    read, unit = recording.columns[column], column_unit(column)
    off = float(np.median(read[:_FIRST]) - np.median(shown[:_FIRST]))
    noise = recording.measured[column].noise or 0.0
    if abs(off) <= max(_OFF * float(np.ptp(read)), _NOISES * noise):
        return None
    start = f"starts at {np.median(read[:_FIRST]):.4g} {unit}, the model at {shown[0]:.4g} {unit}"
    sensor = recording.measured[column].sensor
    cause = (
        "the pretension may be another: give its range in [uncertain]"
        if unit == "N"
        else "the model's reference pose may be another than the rig's"
    )
    return DataWarning(
        "start",
        place,
        start,
        f'{cause}; or the sensor\'s zero: write "{sensor}.offset" in [known] or [uncertain]; or the'
        " recording begins in motion: record half a second of rest before it",
    )


def _stands(series: FloatArray) -> bool:
    """Whether a series moves by nothing but rounding."""
    return float(np.ptp(series)) <= _STILL * float(np.abs(series).max(initial=0.0))
