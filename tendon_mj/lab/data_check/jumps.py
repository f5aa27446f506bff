"""Jumps of a column between two samples: a lost zero, a counter that wraps, another scale.

A rig moves on between two samples by about as much as before and after. A jump that neither the
drive nor the model nor another column knows of was made by the logger. A slip of the cable is one
of the rig: the model makes the same of a step of its drive, with all that follows from it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.column import Column, a_step, median_around, more
from tendon_mj.lab.data_check.faults import DataWarning
from tendon_mj.lab.noise import noise_levels, range_ends
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.units import plain
from tendon_mj.typing import FloatArray

Replay = Callable[[Recording], Recording | None]


class Jump(NamedTuple):
    """A jump of a column before sample ``row``."""

    row: int
    size: float


def jumps(series: FloatArray) -> list[Jump]:
    """Jumps of a series between two samples; none if it jumps often."""
    changes = np.diff(series)
    if changes.size < 4 * limits.SIDE:
        return []
    size, error = _steps_between_lines(series)
    off = _bends(changes)
    clear = (np.abs(size) > limits.CLEAR * error) & (off * size > 0.5 * size**2)
    clear &= np.abs(off) > a_step(off)
    around = np.ones(2 * limits.AROUND + 1)
    clear &= np.abs(size) == scipy.ndimage.maximum_filter1d(np.abs(size), around.size)
    largest = np.abs(size[clear]).max(initial=0.0)
    rows = np.flatnonzero(clear & (np.abs(size) > limits.PART * largest))
    return [Jump(int(k) + 1, float(size[k])) for k in rows] if rows.size <= limits.JUMPS else []


def _bends(changes: FloatArray) -> FloatArray:
    """(n,) by how much each change differs from those around it."""
    return changes - median_around(changes, limits.SIDE)


def _steps_between_lines(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n-1,) step from the line through the samples before to that through those after, and error.

    Near the ends of a series fewer samples count.
    """
    count = series.size - 1
    size, error = np.zeros(count), np.full(count, np.inf)
    for side in (limits.SIDE, limits.SIDE // 2 + 1):
        x = np.arange(side) + 0.5
        design = np.column_stack([np.ones(side), x])
        inverse = np.linalg.pinv(design)
        windows = np.lib.stride_tricks.sliding_window_view(series, side)
        after, before = windows[side:], windows[: windows.shape[0] - side]
        inside = slice(side - 1, side - 1 + after.shape[0])
        lines = after @ inverse.T, before[:, ::-1] @ inverse.T
        squares = sum(
            np.sum((values - line @ design.T) ** 2, axis=1)
            for values, line in ((after, lines[0]), (before[:, ::-1], lines[1]))
        )
        spread = np.sqrt(squares / (2 * side - 4) * 2.0 * float(inverse[0] @ inverse[0]))
        least = 0.5 * float(np.median(spread))
        new = np.isinf(error[inside])
        size[inside][new] = (lines[0][:, 0] - lines[1][:, 0])[new]
        error[inside][new] = np.maximum(spread, least)[new]
    return size, error


def jump_warnings(columns: Sequence[Column], replay: Replay) -> list[DataWarning]:
    """Warn of columns whose zero is lost, whose counter wraps, or whose scale changes midway.

    ``replay`` simulates a recording with another drive; it returns None if that fails.
    """
    for driven, of_kind in ((True, _drive_jump), (False, _reading_jump)):
        some = [c for c in columns if c.driven == driven and not c.lost_turns.size]
        warnings = list(filter(None, (_wrap(c, replay) or of_kind(c, replay) for c in some)))
        if warnings:
            return warnings  # with another drive, the model cannot judge the readings
    return []


# --- counters


def _wrap(column: Column, replay: Replay) -> DataWarning | None:
    """A counter of 2^n steps that begins again, so that its column jumps from end to end."""
    series, recording = column.read, column.recording
    period, bits = _period(column)
    if not period:
        return None
    changes = np.diff(series)
    beyond = changes if column.driven else changes - np.diff(column.model)
    turns = np.append(0.0, np.cumsum(np.rint(beyond / period)))
    away = turns != np.median(turns)
    if away.any() and np.ptp(series[away]) == 0.0:
        return None  # one value for all of it: a sensor that dropped out
    if not np.any(away[2:] & away[1:-1] & away[:-2]):
        return None  # spikes
    unwrapped = column.changed(series - period * turns)
    better = replay(unwrapped) if column.driven else column.simulated
    if better is None or column.simulated is None:
        return None
    before, after = _errors(recording, column.simulated), _errors(unwrapped, better)
    if not bits or not _goes_on(changes, period, column.step):
        before, after = before.sum(), after.sum()
    if not np.any(after < limits.BETTER * before):
        return None
    rows = np.flatnonzero(np.diff(turns))
    counts, number = "from end to end", f"{column.say(period, 6)}, before any factor"
    if bits:
        counts = f"2^{bits} = {2**bits} of its steps of {column.say(column.step)}"
        number = f"{2**bits} of such steps, or {column.say(period, 6)}"
    return column.warn(
        "wraps",
        f"jumps from {column.say(series[rows[0]])} to {column.say(series[rows[0] + 1])}"
        f" in {column.row(rows[0] + 1)}{more(rows.size)}: {counts}",
        "a counter that begins again: unwrap it, by period in [columns], a number as the"
        f" file has it: {number}",
        blocks=True,
    )


def _goes_on(changes: FloatArray, period: float, step: float) -> bool:
    """Return whether a counter moves at every jump, and as much over it as beside it."""
    turns = np.rint(changes / period)
    unwrapped, around = changes - period * turns, limits.AROUND
    for row in np.flatnonzero(turns):
        beside = np.append(unwrapped[max(0, row - around) : row], unwrapped[row + 1 :][:around])
        low, high = beside.min() - 2.0 * step, beside.max() + 2.0 * step
        if not low <= unwrapped[row] <= high or abs(float(np.median(beside))) < step:
            return False
    return True


def _period(column: Column) -> tuple[float, int]:
    """Period of a counter that jumps from end to end, and its bits; 0 if there are none."""
    changes, step, about = np.diff(column.read), column.step, 1.0 + limits.LITTLE
    span = float(np.ptp(column.read))
    jumped = changes[np.abs(changes) > 0.5 * span]
    if not 0 < jumped.size < limits.PART * changes.size:
        return 0.0, 0
    largest = float(np.abs(jumped).max())
    bits = int(np.rint(np.log2(largest / step))) if step else 0
    period = step * 2.0**bits
    if bits < limits.BITS or not max(largest, span) < about * period < about**2 * largest:
        # rounded once more in the file: about as long as its largest jump
        period, bits = float(np.median(np.abs(jumped))), 0
        if not jumped.max() > 0.0 > jumped.min():
            return 0.0, 0
    usual = float(np.percentile(np.abs(changes), limits.OFTEN))
    smooth = usual < limits.LITTLE * period and span <= about * period
    return (period, bits) if smooth else (0.0, 0)


# --- driven columns


def _drive_jump(column: Column, replay: Replay) -> DataWarning | None:
    """A drive that jumps where nothing that it moves does."""
    recording, series, simulated = column.recording, column.read, column.simulated
    changes, intervals = np.diff(series), np.diff(recording.time)
    bends, noise = _bends(changes), noise_levels(recording)
    large = (np.abs(changes) > a_step(changes)) | (np.abs(bends) > a_step(bends))
    rows = np.flatnonzero(large & (intervals < limits.GAP * np.median(intervals))) + 1
    if not rows.size or not noise or simulated is None:
        return None
    errors = np.array(
        [(recording.columns[c] - simulated.columns[c]) / level for c, level in noise.items()]
    )
    row = max(rows.tolist(), key=lambda row: _worsens(errors, row))
    if _worsens(errors, row) <= 0.0:
        return None
    size = float(bends[row - 1])
    straight = float(series[row]) - size
    scale = float(series[row]) / straight if straight else 1.0
    before, after = _errors(recording, simulated, row), list[FloatArray]()
    for mended in (series - size, series / scale if scale > 0.0 else series):
        shown = replay(column.changed(np.append(series[:row], mended[row:])))
        failed = np.full(len(noise), np.inf)
        after.append(failed if shown is None else _errors(recording, shown, row))
    best = min(after, key=np.sum)
    agrees = limits.SIGMAS**2 * (series.size - row)
    if best.sum() >= limits.BETTER * before.sum() or (best >= np.maximum(before, agrees)).any():
        return None
    if best is after[1]:
        return _scale_change(column, row, scale)
    return column.warn(
        "zero_step",
        f"jumps by {column.say(size)} before {column.row(row)}, where no measured column"
        " moves as the model would",
        f"an encoder that lost its zero: subtract {column.say(size)} from that row on, or"
        " end the recording before it",
        blocks=True,
    )


def _scale_change(column: Column, row: int, scale: float) -> DataWarning:
    return column.warn(
        "scale_change",
        f"reads {plain(scale)} times as much from {column.row(row)} on, where nothing else changes",
        f"an amplifier that was switched, or another unit: divide it by {plain(scale)} from that"
        " row on, or end the recording before it",
        blocks=True,
    )


def _worsens(errors: FloatArray, row: int) -> float:
    """By how much likelier (columns, n) errors are larger from a sample on than all alike, in logs.

    -inf where they are not clearly larger.
    """
    off = errors - np.median(errors[:, :row], axis=1, keepdims=True)
    before, after, whole = (np.mean(part**2) for part in (off[:, :row], off[:, row:], off))
    if before == 0.0 or before > limits.BETTER * after:
        return -np.inf
    share = row / off.shape[1]
    return float(np.log(whole) - share * np.log(before) - (1.0 - share) * np.log(after))


# --- readings


def _reading_jump(column: Column, replay: Replay) -> DataWarning | None:
    """A reading whose zero or scale changes between two samples, and nothing else does."""
    read = column.read
    shown = np.clip(column.model, *range_ends(read, column.stated_noise))
    off = read - shown
    alone = [
        jump
        for jump in jumps(off) or jumps(read)
        if _stays(off, jump) and not _explained(column, shown, jump)
    ]
    if alone:
        jump = max(alone, key=lambda jump: abs(jump.size))
        later = [j.row for j in alone if j.row > jump.row]
        stretch = slice(jump.row, min(later, default=read.size))
    else:
        row = _split(column, shown)
        if row is None:
            return None
        jump = Jump(row, float(np.median(off[row:]) - np.median(off[:row])))
        stretch = slice(row, read.size)
    scale = _scale(read, shown, jump, stretch, bool(alone))
    mended, before, after = read.copy(), *_sides(jump, limits.SIDE)
    shift = float(np.mean(off[after]) - np.median(off[before]))
    mended[stretch] = read[stretch] - shift if scale is None else read[stretch] / scale
    if _slips(column, replay, jump, column.changed(mended)):
        return None
    if scale is not None:
        return _scale_change(column, jump.row, scale)
    if not is_sudden(read, jump, column.noise):
        return None
    return column.warn(
        "zero_step",
        f"its zero steps by {column.say(jump.size)} before"
        f" {column.row(jump.row)}{more(len(alone))}, from {column.say(read[jump.row - 1])}"
        f" to {column.say(read[jump.row])}, where nothing else moves",
        f"a tare, or an encoder that lost its zero: subtract {column.say(jump.size)} from"
        " that row on, or end the recording before it",
        blocks=True,
    )


def is_sudden(read: FloatArray, jump: Jump, noise: float) -> bool:
    """Return whether a reading jumps between two samples, as at a tare; a rig takes several.

    At a corner of the motion the change over it is like that on one side of it.
    """
    changes = np.diff(read)[jump.row - 2 : jump.row + 1]
    sudden = np.abs(changes[1] - changes[::2]).min()
    return bool(sudden >= 0.5 * (abs(jump.size) - limits.SIGMAS * noise))


def _sides(jump: Jump, close: int) -> tuple[slice, slice]:
    """Samples before and after a jump, except those that are close to it."""
    first = max(0, jump.row - limits.LONG)
    before = slice(first, max(first + 1, jump.row - close))
    return before, slice(jump.row + close, jump.row + limits.LONG)


def _stays(off: FloatArray, jump: Jump) -> bool:
    """Return whether a reading is off by a jump for long: on a flank of a play it comes back."""
    before, after = _sides(jump, limits.AROUND)
    size = float(np.median(np.append(off[after], off[-1])) - np.median(off[before]))
    return size / jump.size > limits.PART


def _explained(column: Column, shown: FloatArray, jump: Jump) -> bool:
    """Return whether rows are missing, a drive steps or starts, the model jumps or another reading.

    A reading of a rig with play stands still while the model moves on, and follows it late.
    """
    recording, around = column.recording, limits.AROUND
    intervals = np.diff(recording.time)
    if intervals[jump.row - 1] > limits.GAP * np.median(intervals):
        return True  # a gap, which is reported
    near = slice(max(0, jump.row - 1 - around), jump.row + 1)  # causes go before
    for driven in recording.drive:
        changes = np.diff(recording.columns[driven])
        corners = np.diff(changes)  # where it starts, stops, turns
        corner = max(a_step(corners), limits.LITTLE * a_step(changes))
        if np.abs(changes[near]).max() > a_step(changes):
            return True
        if np.abs(corners[near]).max(initial=0.0) > corner:
            return True
    least = limits.PART * abs(jump.size)
    if np.abs(_bends(np.diff(shown))[near]).max() > least:
        return True
    before = slice(0, jump.row)
    read, model = (np.abs(y[before] - y[jump.row - 1]) for y in (column.read, shown))
    still = int(np.flatnonzero(read > least).max(initial=-1)) + 1
    if (model - read)[still:].max() > least:
        return True
    return any(
        abs(other.row - jump.row) <= around
        for name in recording.measured
        if name != column.name
        for other in jumps(recording.columns[name])
    )


def _scale(
    read: FloatArray, shown: FloatArray, jump: Jump, after: slice, alone: bool
) -> float | None:
    """By which a reading is multiplied from a jump on; None if an offset explains it better."""
    before = slice(0, jump.row)
    if np.ptp(shown[before]) == 0.0 or np.ptp(shown[after]) == 0.0:
        return None
    slope, offset = np.polyfit(shown[before], read[before], 1)
    model = slope * shown[after] + offset
    measured = read[after]
    scale = float(model @ measured / (model @ model))
    scaled = float(np.sum((measured - scale * model) ** 2))
    moved = float(np.sum((measured - model - np.mean(measured - model)) ** 2))
    jumped = (scale - 1.0) * read[jump.row - 1]
    fits = not alone or abs(jumped - jump.size) < limits.PART * abs(jump.size)
    return scale if scaled < moved and fits and abs(scale - 1.0) > limits.LITTLE else None


def _split(column: Column, shown: FloatArray) -> int | None:
    """Sample before which the relation of a reading to the model changes at once, if it does.

    The model has to agree with the data on either side, up to a zero and a scale, and neither a
    zero nor a scale that change evenly may explain it.
    """
    read, time = column.read, column.recording.time
    if read.size < limits.ENOUGH:
        return None
    line = np.column_stack([np.ones_like(shown), shown])
    whole, noise = _left(read, line), read.size * column.noise**2
    if whole <= limits.ALIKE**2 * noise:
        return None
    edge = int(limits.LITTLE * read.size)
    halves = _left_before(read, shown) + _left_before(read[::-1], shown[::-1])[::-1]
    best = edge + int(np.argmin(halves[edge : read.size - edge + 1]))
    gradual = _left(read, np.column_stack([line, line * (time - time.mean())[:, np.newaxis]]))
    least = min(limits.BETTER * whole, limits.BETTER * gradual, limits.SIGMAS**2 * noise)
    return best if halves[best] < least else None


def _left_before(read: FloatArray, shown: FloatArray) -> FloatArray:
    """(n+1,) sum of squares that a line of a reading over the model leaves before each sample."""
    x, y = shown - shown.mean(), read - read.mean()
    sums = np.cumsum([x, y, x * x, x * y, y * y], axis=1)
    sums = np.concatenate([np.zeros((5, 1)), sums], axis=1)
    count = np.maximum(1, np.arange(read.size + 1))
    xx = sums[2] - sums[0] ** 2 / count
    xy = sums[3] - sums[0] * sums[1] / count
    yy = sums[4] - sums[1] ** 2 / count
    moved = xx > 0.0
    slope = np.divide(xy, xx, out=np.zeros_like(xx), where=moved)
    left: FloatArray = np.maximum(0.0, yy - slope * xy)
    return left


def _left(read: FloatArray, design: FloatArray) -> float:
    """Sum of squares that a linear fit leaves."""
    fitted = design @ np.linalg.lstsq(design, read, rcond=None)[0]
    return float(np.sum((read - fitted) ** 2))


def _slips(column: Column, replay: Replay, jump: Jump, mended: Recording) -> bool:
    """Return whether a step of a drive's zero, as by a slip, explains more than ``mended``."""
    recording, simulated = column.recording, column.simulated
    noise = noise_levels(recording)
    before, after = _sides(jump, limits.SIDE)

    def off(measured: Recording, shown: Recording) -> FloatArray:
        """(columns, n) by how much readings are off after the jump beyond before it [noise]."""
        errors = ((measured.columns[c] - shown.columns[c]) / noise[c] for c in noise)
        return np.array([e[after] - np.median(e[before]) for e in errors])

    if simulated is None:
        return False
    left, wanted = float(np.sum(off(mended, simulated) ** 2)), off(recording, simulated)
    for driven in recording.drive:
        drive = Column(recording, driven)
        span, last = float(np.ptp(drive.read)), np.inf
        slip = limits.LITTLE * span
        while 0.0 < abs(slip) < span:
            shifted = drive.read + slip * (np.arange(drive.read.size) >= jump.row)
            tried = replay(drive.changed(shifted))
            if tried is None:
                break
            remains = off(recording, tried)
            error = float(np.sum(remains**2))
            if error < limits.ALIKE**2 * left:
                return True
            if error > limits.BETTER * last:
                break
            last, change = error, wanted - remains
            power = float(np.sum(change**2))
            slip *= float(np.sum(change * wanted)) / power if power > 0.0 else 0.0
    return False


def _errors(recording: Recording, simulated: Recording, row: int = 0) -> FloatArray:
    """Of each measured column, squared errors from a sample on, beyond their offset before it."""
    errors = []
    for column, level in noise_levels(recording).items():
        off = (recording.columns[column] - simulated.columns[column]) / level
        errors.append(float(np.sum((off[row:] - np.median(off[: row or None])) ** 2)))
    return np.array(errors)
