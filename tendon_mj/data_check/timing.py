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
    if usual >= _SLOW and recording.time.size >= _ENOUGH:
        way_out = "if these are milliseconds, name the column 'time_ms'"
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
