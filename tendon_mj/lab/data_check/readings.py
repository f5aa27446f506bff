"""Warnings where measured columns and a simulation at the stated numbers differ beyond any fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tendon_mj.lab.data_check.samples import frozen
from tendon_mj.lab.data_check.warning import (
    DataWarning,
    columns_of,
    lost_turns,
    place_of,
    usual_range,
)
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import column_unit, quantity
from tendon_mj.typing import FloatArray

_THOUSAND = 100.0  # ratio of two ranges from which it may be 1000: friction is not proportional
_BEYOND = 3000.0  # ratio of two ranges that no mistaken unit explains
_ALL = 5.0  # ratio from which, if every column is off by it, the drive is meant
_DEGREES, _NEARLY = 180.0 / np.pi, 1.5  # ratio of degrees and radians, and its tolerance
_TURNED = 3.0  # range of angles that may be degrees [rad]; less of these would be no motion
_LITTLE = 1e-3  # of a range, an error that none is
_AGAINST = -0.7  # correlation below which a column runs against the model
_STILL = 1e-6  # of a value's size, a range that is not a motion
_OFF = 0.15  # of the measured range, by which the start may differ
_NOISES = 5.0  # of the stated noise, likewise
_FIRST = 5  # samples that are the start


def drive_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of a recording that drives nothing, or whose driven columns all stand still."""
    place, value = recording.name, "no column is in [drive]"
    way_out = "say which column commands which actuator"
    if recording.drive:
        if not all(_stands(recording.columns[column]) for column in recording.drive):
            return []
        columns = ", ".join(repr(recording.written(column)) for column in recording.drive)
        place, value = f"{recording.name}, [drive] {columns}", "stands still"
        way_out = "friction shows where the motion reverses: record one that goes back and forth"
    return [DataWarning("nothing_moves", place, value, way_out)]


def reading_warnings(recording: Recording, simulated: Recording) -> list[DataWarning]:
    """Warn of measured columns: no motion, a wrong unit, a reversed sign, another start.

    Not of a column that jumps by a turn. A cable that is slack in the model, and a drive in a wrong
    unit, by which all columns are off, are reported alone: the rest follows from them. A column
    has one warning.
    """
    whole = [c for c in recording.measured if not lost_turns(recording, c).size]
    pairs = {c: (recording.columns[c], simulated.columns[c]) for c in whole}
    if slack := list(filter(None, (_slack(recording, c, s) for c, (_, s) in pairs.items()))):
        return slack
    # as measured over as simulated; inf where the model stands still
    ratios = [
        np.inf if _stands(shown) else usual_range(read) / usual_range(shown)
        for read, shown in pairs.values()
    ]
    if len(ratios) > 1 and any(0.0 < ratio < np.inf for ratio in ratios):
        if min(ratios) > _ALL:
            return [_drive_unit(recording, "less", ratios)]
        if max(ratios) < 1.0 / _ALL:
            return [_drive_unit(recording, "more", ratios)]
    return list(filter(None, (_one_warning(recording, c, s) for c, (_, s) in pairs.items())))


def degree_warnings(
    recording: Recording,
    simulated: Recording | None,
    simulate: Callable[[Recording], Recording | None],
) -> list[DataWarning]:
    """Warn of driven columns in rad that hold degrees, and of measured ones that do so too.

    They do if the model is off by more than a column's range, and comes much nearer when they are
    taken as degrees. ``simulated``: at the numbers that the description states, None where that was
    unstable; ``simulate``: the same for another recording.
    """
    angles = {c for _, c in columns_of(recording) if column_unit(c) == "rad"}
    angles -= recording.in_file.keys()
    driven = {c for c in angles & {*recording.drive} if np.ptp(recording.columns[c]) > _TURNED}
    before, _ = _misfit(recording, simulated, set())
    if not driven or before <= 1.0:
        return []
    columns = {c: s / _DEGREES if c in driven else s for c, s in recording.columns.items()}
    after, turned = _misfit(recording, simulate(replace(recording, columns=columns)), angles)
    if after > min(1.0, before / _ALL):
        return []
    nearer = f"{before / max(after, _LITTLE):.0f} times " if before < np.inf else ""
    return [
        DataWarning(
            "unit",
            place_of(recording, column),
            f"moves by {np.ptp(recording.columns[column]):.3g} rad; taken as degrees, the model"
            f" comes {nearer}nearer to the readings",
            f"if these are degrees, name the column {column.removesuffix('rad') + 'deg'!r}",
        )
        for _, column in columns_of(recording)
        if column in driven | turned
    ]


def _misfit(
    recording: Recording, simulated: Recording | None, angles: set[str]
) -> tuple[float, set[str]]:
    """Mean rms error of the measured columns over their range; those of ``angles`` in degrees."""
    if simulated is None:
        return np.inf, set()
    errors, turned = [0.0], set()
    for column in recording.measured:
        read, shown = recording.columns[column], simulated.columns[column]
        options = [read, read / _DEGREES] if column in angles else [read]
        error = [float(np.sqrt(np.mean((s - shown) ** 2)) / (np.ptp(s) or 1.0)) for s in options]
        errors.append(min(error))
        if error[0] > min(error):
            turned.add(column)
    return sum(errors) / max(1, len(errors) - 1), turned


def _slack(recording: Recording, column: str, shown: FloatArray) -> DataWarning | None:
    """A tension that is measured, and 0 in the model for most of the time."""
    middle = float(np.median(recording.columns[column]))
    if column_unit(column) != "N" or not middle > 0.0 >= float(np.median(shown)):
        return None
    return DataWarning(
        "slack",
        place_of(recording, column),
        f"reads {quantity(middle, 'N')} in the middle, and the model 0 N",
        "if this is a cable's tension, it is slack in the model: does its pull turn the joint the"
        " right way (the sign of the radius), and does it have a pretension?",
    )


def _drive_unit(recording: Recording, how: str, ratios: list[float]) -> DataWarning:
    factors = [max(r, 1.0 / r) for r in ratios if 0.0 < r < np.inf]
    finite = [factor for factor in factors if factor < _BEYOND] or factors[:1]
    span = f"{min(finite):.0f}" + (f" to {max(finite):.0f}" if len(finite) > 1 else "")
    span += "" if len(finite) == len(ratios) else " or more"
    driven = ", ".join(repr(recording.written(column)) for column in recording.drive)
    scale = f"{recording.driven[0][1]}.command_scale"
    stated = recording.known.get(scale)
    by_scale = (
        f'if it is the angle of a spool and the control a length, write the radius as "{scale}" in'
        " [known]"
        if stated is None
        else f"it is multiplied by {scale} = {stated:g} of [known], which is for a column in"
        " another unit, such as a spool's angle in rad"
    )
    return DataWarning(
        "unit",
        f"{recording.name}, [drive] {driven}",
        f"in the model every measured column moves {how}, by a factor of {span}",
        f"name the column with the unit that it is in; {by_scale}",
    )


def _one_warning(recording: Recording, column: str, shown: FloatArray) -> DataWarning | None:
    read, unit = recording.columns[column], column_unit(column)
    place = place_of(recording, column)
    sensor = recording.measured[column].sensor
    span, simulated = usual_range(read), usual_range(shown)
    moves, shown_moves = quantity(span, unit), quantity(simulated, unit)
    unconnected = "if the sensor was not connected, leave the column out of [measured]"
    if _stands(read):
        value = f"reads {quantity(read[0], unit)} from the first sample to the last"
        return DataWarning("nothing_moves", place, value, unconnected)
    if _stands(shown) or span > _BEYOND * simulated:
        model = f"stands still at {quantity(shown[0], unit)}" if _stands(shown) else "hardly moves"
        return DataWarning(
            "nothing_moves",
            place,
            f"moves by {moves}, where sensor {sensor!r} of the model {model}",
            "is it this sensor, does the actuator in [drive] move it, and in which unit is that?",
        )
    if simulated > _BEYOND * span:
        value = f"hardly moves, by {moves}, the model by {shown_moves}"
        return DataWarning("nothing_moves", place, value, unconnected)
    fault = _unit_fault(span / simulated)
    if fault:
        return DataWarning(
            "unit",
            place,
            f"moves by {moves}, the model by {shown_moves}: {fault}",
            "name the column with the unit that it is in, or else the one in [drive]",
        )
    correlation = float(np.corrcoef(_clipped(read), _clipped(shown))[0, 1])
    if correlation < _AGAINST:
        return DataWarning(
            "sign",
            place,
            f"runs against sensor {sensor!r} of the model, correlation {correlation:.2f}",
            f'if the sensor counts the other way, write "{sensor}.scale" = -1 in [known]; if all'
            ' columns do, "<actuator>.command_scale" = -1, or turn the axis in the model',
        )
    return frozen(recording, column, shown) or _start_warning(recording, column, shown, place)


def _unit_fault(ratio: float) -> str:
    """Fault of the unit by a ratio of ranges, measured over simulated; empty if there is none."""
    large, times = ratio > 1.0, max(ratio, 1.0 / ratio)
    if times > _THOUSAND:
        units = "thousandths of it (mm, mN)" if large else "thousands of it (kN)"
        return (
            f"{times:.0f} times as {'much' if large else 'little'}, as {units} under its name are"
        )
    if _DEGREES / _NEARLY < times < _DEGREES * _NEARLY:
        units = "degrees named radians" if large else "radians named degrees"
        return f"{times:.0f} times as {'much' if large else 'little'}, as {units} are"
    return ""


def _start_warning(
    recording: Recording, column: str, shown: FloatArray, place: str
) -> DataWarning | None:
    read, unit = recording.columns[column], column_unit(column)
    off = float(np.median(read[:_FIRST]) - np.median(shown[:_FIRST]))
    noise = recording.measured[column].noise or 0.0
    if abs(off) <= max(_OFF * usual_range(read), _NOISES * noise):
        return None
    first, simulated = (quantity(float(np.median(s[:_FIRST])), unit) for s in (read, shown))
    start = f"starts at {first}, the model at {simulated}"
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


def _clipped(series: FloatArray) -> FloatArray:
    """A series without the peaks of its most extreme samples, which would be all that counts."""
    clipped: FloatArray = np.clip(series, *np.percentile(series, [1.0, 99.0]))
    return clipped if np.ptp(clipped) > 0.0 else series


def _stands(series: FloatArray) -> bool:
    """Whether a series moves by nothing but rounding."""
    return float(np.ptp(series)) <= _STILL * float(np.abs(series).max(initial=0.0))
