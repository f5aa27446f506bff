"""Checks of the times of a recording: their unit, gaps, missing rows, uneven stamps, and rests."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.column import Column, columns_of, row_of
from tendon_mj.lab.data_check.faults import DataWarning
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.units import TIME, TIMES, quantity
from tendon_mj.typing import FloatArray


def timing_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of times in a wrong unit, of gaps and missing rows, uneven stamps, and a long settle.

    Times that repeat or decrease are refused when a recording is read.
    """
    return list(_timing_warnings(recording))


def _timing_warnings(recording: Recording) -> Iterator[DataWarning]:
    place = f"{recording.name}, column {recording.written(TIME)!r}"
    intervals = np.diff(recording.time)
    usual, span = float(np.median(intervals)), float(np.ptp(recording.time))
    samples = f"{recording.time.size} samples {quantity(usual, 's')} apart, {quantity(span, 's')}"
    if recording.settling_time is not None:
        yield from _rests(recording, place, recording.settling_time)
        return
    if usual >= limits.SLOW and recording.time.size >= limits.ENOUGH:
        yield DataWarning(
            "times_in_ms",
            place,
            f"{samples} in all",
            "if these are milliseconds, name the column 'time_ms'; if each row was read at"
            " rest, write quasi_static = true under [timing]",
        )
    if usual < limits.FAST and span < limits.BRIEF:
        names = f"{TIMES[0]!r} or {TIMES[1]!r}"
        yield DataWarning(
            "times_too_short",
            place,
            f"{samples} in all",
            f"if these are in a larger unit, name the column so: {names}",
        )
    if (intervals > limits.GAP * usual).any():
        yield _gap(recording, place, intervals, usual)
    if usual < limits.SLOW:  # else points that were read one by one
        yield from _uneven(recording, place, intervals, usual)
    if recording.settle > max(limits.LONG_SETTLE, span):
        settle, lasts = recording.settle, quantity(span, "s")
        yield DataWarning(
            "long_settle",
            recording.name,
            f"settle = {settle:g} s before the first sample are simulated too, and the"
            f" recording lasts {lasts}",
            "give the time in seconds that the model needs to come to rest",
        )


def _gap(recording: Recording, place: str, intervals: FloatArray, usual: float) -> DataWarning:
    gaps = np.flatnonzero(intervals > limits.GAP * usual)
    longest = gaps[np.argmax(intervals[gaps])]
    return DataWarning(
        "gap",
        place,
        f"{gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest"
        f" {intervals[longest]:.3g} s after {recording.time[longest]:.6g} s (row"
        f" {recording.row(longest)}), where samples are {usual:.3g} s apart",
        "split the recording there, unless the drive was straight in between",
        blocks=any(_turns(recording, gap, usual) for gap in gaps.tolist()),
    )


def _turns(recording: Recording, gap: int, usual: float) -> bool:
    """Return whether a drive in a gap leaves the line between its ends."""
    time, around = recording.time, limits.AROUND
    before, after = slice(max(0, gap - around), gap + 1), slice(gap + 1, gap + 2 + around)
    for column in recording.drive:
        series = recording.columns[column]
        chord = (series[gap + 1] - series[gap]) / (time[gap + 1] - time[gap])
        for end in (before, after):
            if series[end].size > 1:
                slope = np.polyfit(time[end] - time[gap], series[end], 1)[0]
                off = abs(slope - chord) * (time[gap + 1] - time[gap] - usual)
                if off > limits.UNSEEN * np.ptp(series):
                    return True
    return False


def _uneven(
    recording: Recording, place: str, intervals: FloatArray, usual: float
) -> Iterator[DataWarning]:
    """Stamps that are uneven, unless the columns are smoother over them than over the row.

    Even ones are whole multiples of the usual interval, of two or more if rows are missing.
    """
    times = np.maximum(1.0, np.rint(intervals / usual))
    off = np.where(intervals < 0.5 * usual, 1.0, np.abs(intervals / usual - times))
    uneven = off > limits.LITTLE + _tick(recording.time) / usual
    lost = np.flatnonzero((times > 1.0) & ~uneven)
    if uneven.mean() < limits.LITTLE:
        if lost.size and not (intervals > limits.GAP * usual).any():
            missing = int((times[lost] - 1.0).sum())
            yield DataWarning(
                "gap",
                place,
                f"{missing} row{'s are' if missing > 1 else ' is'} missing in {lost.size}"
                f" place{'s' if lost.size > 1 else ''}, the first after"
                f" {recording.time[lost[0]]:.6g} s (row {recording.row(lost[0])}), where samples"
                f" are {usual:.3g} s apart",
                "the logger lost them: the drive is taken to be straight in between",
            )
        return
    if intervals.size < limits.ENOUGH:
        return
    columns = columns_of(recording)
    rough = [_roughness(recording.time, c.read) for c in columns]
    late = any(over_rows < limits.BETTER * over_times for over_times, over_rows in rough)
    if not late and any(over_times < limits.BETTER * over_rows for over_times, over_rows in rough):
        return
    first = row_of(recording, int(np.argmax(uneven)) + 1)
    yield DataWarning(
        "uneven_times",
        place,
        f"intervals from {intervals.min():.3g} to {intervals.max():.3g} s,"
        f" {uneven.mean():.0%} of them uneven, the first before"
        f" {first}{', while the columns move evenly from row to row' if late else ''}",
        "times at which samples arrived, and not those at which they were taken: log the"
        " sensor's own time, or write even times,"
        f" {np.mean(intervals[intervals < limits.GAP * usual]):.6g} s apart, if no row is"
        " missing",
        blocks=late and any(_matters(c, intervals, usual) for c in columns if not c.driven),
    )


def _matters(column: Column, intervals: FloatArray, usual: float) -> bool:
    """Return whether uneven lateness moves a reading by more than its noise hides."""
    late = float(np.std(intervals[intervals < 2.0 * usual])) / np.sqrt(2.0)
    change = float(np.sqrt(np.mean(np.diff(column.read) ** 2)))
    return bool(late / usual * change > limits.VISIBLE * column.noise)


def _tick(time: FloatArray) -> float:
    """Last decimal of the times [s], down to a nanosecond."""
    decimals = (d for d in range(9) if np.allclose(time, np.round(time, d), rtol=0.0, atol=1e-9))
    return float(10.0 ** -next(decimals, 9))


def _roughness(time: FloatArray, series: FloatArray) -> tuple[float, float]:
    """Mean square distance of samples from the line between neighbours, over time and over rows.

    Of the smoother three quarters of the samples that move, so that corners do not count.
    """
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    first, middle, last = series[:-2], series[1:-1], series[2:]
    moving = np.abs(last - first) > limits.PART * np.abs(last - first).max()
    if not moving.any():
        return 0.0, 0.0
    off = np.array([middle - first - s * (last - first) for s in (share, 0.5)])[:, moving] ** 2
    over_time, over_rows = np.mean(np.sort(off, axis=1)[:, : 3 * off.shape[1] // 4], axis=1)
    return float(over_time), float(over_rows)


def _rests(recording: Recording, place: str, settling: float) -> Iterator[DataWarning]:
    steps = np.diff(recording.time)
    shortest = int(np.argmin(steps))
    between = float(steps[shortest])
    if between < settling and (np.ptp(steps) > 0.0 or between != 1.0):  # numbers of rows
        row, after = recording.row(shortest), recording.row(shortest + 1)
        yield DataWarning(
            "rests_too_close",
            place,
            f"rows {row} and {after} are {between:.3g} s apart, and each was read"
            f" {settling:g} s after its move",
            "check the unit of the times, and settling_time under [timing], which is in"
            " seconds; that decides how long a rest is simulated",
        )
