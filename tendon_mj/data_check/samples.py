"""Warnings about samples of a column: spikes, lost turns, and readings that are frozen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tendon_mj.data_check.warning import DataWarning
from tendon_mj.recordings import Recording
from tendon_mj.replay.engineering_units import quantity
from tendon_mj.replay.units import column_unit

FloatArray = NDArray[np.float64]

_AROUND = 2  # samples on either side: an excursion of so many at most is a spike
_SPIKE = 0.5  # of the usual range, that a spike is off by at least
_NOISES = 12.0  # times the median deviation from the neighbours, likewise
_TURN, _NEARLY = 2.0 * np.pi, 0.15  # of an encoder [rad], and by what share a jump may differ
_SMOOTH = 0.1  # of a turn, by which other samples differ at most, in the median
_HELD = 10  # equal samples at least
_MEANWHILE = 0.25  # of its range, by which the model moves on in that time
_OUTER = 1.0  # percent of the samples at either end that do not count for the usual range
_HEADER = 2  # row of the first sample in the file


def usual_range(series: FloatArray) -> float:
    """Range of a series without its most extreme samples; all of it where the rest is constant."""
    low, high = np.percentile(series, [_OUTER, 100.0 - _OUTER])
    return float(high - low) or float(np.ptp(series))


def lost_turns(recording: Recording, column: str) -> NDArray[np.int64]:
    """Samples before which an angle jumps by a turn, as of an encoder that begins anew."""
    if column_unit(column) != "rad":
        return np.zeros(0, np.int64)
    steps = np.abs(np.diff(recording.columns[column]))
    if float(np.median(steps)) > _SMOOTH * _TURN:
        return np.zeros(0, np.int64)
    return np.flatnonzero(np.abs(steps - _TURN) < _NEARLY * _TURN) + 1


def turn_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of driven and measured angles that jump by a turn."""
    found = []
    for table, columns in (("drive", recording.drive), ("measured", recording.measured)):
        for column in columns:
            jumps = lost_turns(recording, column)
            if jumps.size:
                before, after = recording.columns[column][jumps[0] - 1 : jumps[0] + 1]
                times = f", and {jumps.size - 1} times more" if jumps.size > 1 else ""
                found.append(
                    DataWarning(
                        "turn",
                        f"{recording.name}, [{table}] {recording.written(column)!r}",
                        f"jumps from {quantity(before, 'rad')} to {quantity(after, 'rad')} in row"
                        f" {jumps[0] + _HEADER}{times}: a turn",
                        "an encoder that begins anew after a turn: unwrap it, as"
                        " numpy.unwrap(angle, period=360) does with degrees",
                    )
                )
    return found


def spike_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of samples of driven and measured columns that their neighbours know nothing of.

    Of rests none is: what differs between them is a move.
    """
    if recording.quasi_static:
        return []
    found = []
    for table, columns in (("drive", recording.drive), ("measured", recording.measured)):
        for column in columns:
            if lost_turns(recording, column).size:
                continue  # told of already
            series = recording.columns[column]
            off = np.abs(series - _median_around(series))
            limit = max(_SPIKE * usual_range(series), _NOISES * float(np.median(off)))
            spikes = np.flatnonzero(off > limit) if limit > 0.0 else np.zeros(0, int)
            if not spikes.size:
                continue
            worst = int(spikes[np.argmax(off[spikes])])
            unit = column_unit(column)
            others = f", the largest of {spikes.size}" if spikes.size > 1 else ""
            found.append(
                DataWarning(
                    "spike",
                    f"{recording.name}, [{table}] {recording.written(column)!r}",
                    f"reads {quantity(series[worst], unit)} in row {worst + _HEADER}{others},"
                    f" between {quantity(series[max(0, worst - 1)], unit)} and"
                    f" {quantity(series[min(worst + 1, series.size - 1)], unit)}",
                    "a glitch of the logger: leave the row out",
                )
            )
    return found


def frozen(recording: Recording, column: str, shown: FloatArray) -> DataWarning | None:
    """Warn of readings that are equal to the last digit for long, while the model moves on.

    Args:
        recording: that has the column.
        column: measured.
        shown: (n,) as simulated.
    """
    read = recording.columns[column]
    ends = np.flatnonzero(np.diff(read, prepend=np.nan, append=np.nan) != 0.0)
    limit, worst, place = _MEANWHILE * float(np.ptp(shown)), 0.0, (0, 0)
    for start, end in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        if end - start >= _HELD and np.ptp(shown[start:end]) > max(limit, worst):
            worst, place = float(np.ptp(shown[start:end])), (start, end)
    if worst == 0.0:
        return None
    start, end = place
    unit = column_unit(column)
    return DataWarning(
        "frozen",
        f"{recording.name}, [measured] {recording.written(column)!r}",
        f"reads {quantity(read[start], unit)} from row {start + _HEADER} to {end - 1 + _HEADER},"
        f" {recording.time[end - 1] - recording.time[start]:.3g} s, in which the model moves by"
        f" {quantity(worst, unit)}",
        "if the sensor or its bus hung there, leave these rows out",
    )


def _median_around(series: FloatArray) -> FloatArray:
    """(n,) median of each sample and its neighbours."""
    padded = np.pad(series, _AROUND, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _AROUND + 1)
    median: FloatArray = np.median(windows, axis=1)
    return median
