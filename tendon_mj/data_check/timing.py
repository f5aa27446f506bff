"""Warnings about the times of a recording: a unit that seems wrong, and gaps."""

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


def timing_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of times in another unit than they are named, and of gaps longer than usual.

    Times that repeat or decrease are refused when a recording is read.
    """
    intervals = np.diff(recording.time)
    usual, place = (
        float(np.median(intervals)),
        f"{recording.name}, column {recording.written(TIME)!r}",
    )
    if usual >= _SLOW and recording.time.size >= _ENOUGH:
        span = float(np.ptp(recording.time))
        return [
            DataWarning(
                "times_in_ms",
                place,
                f"{recording.time.size} samples {usual:g} s apart, {span:g} s in all",
                "if these are milliseconds, name the column 'time_ms'",
            )
        ]
    span = float(np.ptp(recording.time))
    if usual < _FAST and span < _SHORT:
        return [
            DataWarning(
                "times_too_short",
                place,
                f"{recording.time.size} samples {quantity(usual, 's')} apart, {quantity(span, 's')}"
                " in all",
                f"if these are in a larger unit, name the column so: {TIMES[0]!r} or {TIMES[1]!r}",
            )
        ]
    gaps = np.flatnonzero(intervals > _GAP * usual)
    if not gaps.size:
        return []
    longest = gaps[np.argmax(intervals[gaps])]
    return [
        DataWarning(
            "gap",
            place,
            f"{gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest {intervals[longest]:.3g} s"
            f" after {recording.time[longest]:.6g} s (row {longest + 2}), where samples are"
            f" {usual:.3g} s apart",
            "split the recording there, unless the drive did in between what its two ends say",
        )
    ]
