"""Warnings about the times of a recording: a unit that seems wrong, gaps, and a long settle."""

from __future__ import annotations

import numpy as np

from tendon_mj.data_check.warning import DataWarning
from tendon_mj.recordings import Recording
from tendon_mj.recordings.table_checks import TIME, TIMES
from tendon_mj.replay.engineering_units import quantity

_SLOW = 0.5  # median interval [s] above which times may be in ms
_ENOUGH = 100  # samples
_FAST, _SHORT = 5e-5, 0.5  # median interval and span [s] below which times may be in larger units
_GAP = 5.0  # times the median interval
_LONG_SETTLE = 60.0  # [s] that no rig needs to come to rest


def timing_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of times in another unit than they are named, of long gaps, and of a long settle.

    Times that repeat or decrease are refused when a recording is read.
    """
    place = f"{recording.name}, column {recording.written(TIME)!r}"
    intervals = np.diff(recording.time)
    usual, span = float(np.median(intervals)), float(np.ptp(recording.time))
    samples = f"{recording.time.size} samples {quantity(usual, 's')} apart, {quantity(span, 's')}"
    found = []
    if recording.settling_time is not None:
        return _rest_warnings(recording, place, recording.settling_time)
    if usual >= _SLOW and recording.time.size >= _ENOUGH:
        way_out = (
            "if these are milliseconds, name the column 'time_ms'; if each row was read at rest,"
            " write quasi_static = true under [timing]"
        )
        found.append(DataWarning("times_in_ms", place, f"{samples} in all", way_out))
    if usual < _FAST and span < _SHORT:
        way_out = f"if these are in a larger unit, name the column so: {TIMES[0]!r} or {TIMES[1]!r}"
        found.append(DataWarning("times_too_short", place, f"{samples} in all", way_out))
    gaps = np.flatnonzero(intervals > _GAP * usual)
    if gaps.size:
        longest = gaps[np.argmax(intervals[gaps])]
        found.append(
            DataWarning(
                "gap",
                place,
                f"{gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest"
                f" {intervals[longest]:.3g} s after {recording.time[longest]:.6g} s (row"
                f" {longest + 2}), where samples are {usual:.3g} s apart",
                "split the recording there, unless the drive did in between what its two ends say",
            )
        )
    if recording.settle > max(_LONG_SETTLE, span):
        found.append(
            DataWarning(
                "long_settle",
                recording.name,
                f"settle = {recording.settle:g} s before the first sample are simulated too, and"
                f" the recording lasts {quantity(span, 's')}",
                "give the time in seconds that the model needs to come to rest",
            )
        )
    return found


def _rest_warnings(recording: Recording, place: str, settling: float) -> list[DataWarning]:
    """Warn of rests that are closer to each other than they are long."""
    shortest = int(np.argmin(np.diff(recording.time)))
    between = float(np.diff(recording.time)[shortest])
    if between >= settling:
        return []
    return [
        DataWarning(
            "rests_too_close",
            place,
            f"rows {shortest + 2} and {shortest + 3} are {between:.3g} s apart, and each was read"
            f" {settling:g} s after its move",
            "check the unit of the times, and settling_time under [timing], which is in seconds;"
            " that decides how long a rest is simulated",
        )
    ]
