"""Jumps of a column between two samples: a lost zero, a counter that wraps, another scale.

A rig moves on between two samples by about as much as before and after. A jump that neither the
drive nor the model nor another column knows of was made by the logger. A slip of the cable is one
of the rig: the model makes the same of a step of its drive, with all that follows from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tendon_mj.lab.data_check.columns import (
    DataWarning,
    lost_turns,
    median_around,
    more,
    place_of,
    row_of,
)
from tendon_mj.lab.recordings import Recording, noise_levels, range_ends, resolution
from tendon_mj.lab.replay import column_unit, plain, quantity
from tendon_mj.typing import FloatArray

Replay = Callable[[Recording], Recording | None]

_SIDE = 8  # samples to either side of a jump, through which lines are laid
_CLEAR = 8.0  # standard errors of a jump at least
_WITHIN = 0.6  # of it between two samples
_USUAL, _BEYOND = 99.0, 2.0  # percentile of other changes of the slope, times which it is at least
_MOST = 2  # jumps of a column: more are how the rig moves
_LONG = 100  # samples before and after a jump, over which it stays
_AROUND = 3  # samples, within which something else explains it
_MOVES, _STEP = 90.0, 3.0  # percentile of the drive's changes, times which it steps
_CORNER = 0.1  # of these changes, by which one more at least is a start, a stop or a turn
_SHARED = 0.3  # of a jump, which the model makes too
_WRAPS = 0.6  # of its range, by which a counter jumps at least
_NEARLY = 1.1  # times the period of a counter, that its range and its jumps are at most
_LEAST_BITS, _SMOOTH = 6, 0.1  # of a counter; of its period, by which it changes at most otherwise
_CERTAIN_BITS = 8  # from which one that goes on evenly is a counter if any reading agrees better
_BETTER = 0.5  # of the error, that remains without a jump
_PROBE = 0.02  # of the drive's range, a slip to try
_TRIES = 4  # slips, each from the part that the last explains; places of a jump of a drive
_AFTER = 200  # samples after a jump, by which a slip is told from a lost zero
_EDGE, _PART = 20, 0.1  # samples and share of them: the shortest part of a split
_SPLIT = 0.4  # of the error, that a split leaves at most
_AGREES = 2.5  # noises, that the model is off by at most on either side of a split
_OTHER_SCALE = 0.03
_SUDDEN, _HIDDEN = 0.5, 3.0  # of a step, and noises: by how much a reading itself steps at least
_TIE = 1.3  # times the error that a step of a zero leaves, up to which a slip is as likely
_GRADUAL = 0.5  # of the error of a gradual change, that a sudden one leaves at most


class _Jump(NamedTuple):
    """A jump of a column before sample ``row``."""

    row: int
    size: float


def jumps(series: FloatArray) -> list[_Jump]:
    """Jumps of a series between two samples; none if it jumps often."""
    changes = np.diff(series)
    if changes.size < 4 * _SIDE:
        return []
    size, error = _steps_between_lines(series)
    off = changes - median_around(changes, _SIDE)
    usual = float(np.percentile(np.abs(off), _USUAL))
    clear = (np.abs(size) > _CLEAR * error) & (off * size > _WITHIN * size**2)
    clear &= np.abs(off) > _BEYOND * usual
    rows = [
        k
        for k in np.flatnonzero(clear)
        if abs(size[k]) == np.abs(size[max(0, k - 2) : k + 3]).max()
    ]
    if not rows:
        return []
    largest = max(abs(size[k]) for k in rows)
    rows = [k for k in rows if abs(size[k]) > _SHARED * largest]
    return [_Jump(int(k) + 1, float(size[k])) for k in rows] if len(rows) <= _MOST else []


def _steps_between_lines(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n-1,) step from the line through the samples before to that through those after, and error.

    Near the ends of a series fewer samples count.
    """
    count = series.size - 1
    size, error = np.zeros(count), np.full(count, np.inf)
    for side in (_SIDE, _SIDE // 2 + 1):
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


def jump_warnings(
    recording: Recording, simulated: Recording | None, replay: Replay
) -> list[DataWarning]:
    """Warn of columns whose zero is lost, whose counter wraps, or whose scale changes midway.

    ``simulated``: the model under the same drive; ``replay`` simulates it under another one. They
    are None if that fails.
    """
    if simulated is None:
        return []
    warnings = list[DataWarning | None]()
    for columns, of_kind in (
        (recording.drive, _drive_warning),
        (recording.measured, _reading_warning),
    ):
        if any(warnings):
            break  # with another drive, the model cannot judge the readings
        for column in columns:
            if not lost_turns(recording, column).size:  # which are reported already
                given = recording, simulated, replay, column
                warnings.append(_wrap_warning(*given) or of_kind(*given))
    return [warning for warning in warnings if warning]


def _wrap_warning(
    recording: Recording, simulated: Recording, replay: Replay, column: str
) -> DataWarning | None:
    """A counter of 2^n steps that begins again, so that its column jumps from end to end."""
    series, unit = recording.columns[column], column_unit(column)
    period, bits = _period(series)
    if not period:
        return None
    driven = column in recording.drive
    changes = np.diff(series)
    beyond = changes if driven else changes - np.diff(simulated.columns[column])
    turns = np.append(0.0, np.cumsum(np.rint(beyond / period)))
    away = turns != np.median(turns)
    if away.any() and np.ptp(series[away]) == 0.0:
        return None  # one value for all of it: a sensor that dropped out
    if not np.any(away[2:] & away[1:-1] & away[:-2]):
        return None  # spikes
    unwrapped = _changed(recording, column, series - period * turns)
    better = replay(unwrapped) if driven else simulated
    if better is None:
        return None
    before, after = _errors(recording, simulated), _errors(unwrapped, better)
    if bits < _CERTAIN_BITS or not _goes_on(changes, period, resolution(series)):
        before, after = before.sum(), after.sum()
    if not np.any(after < _BETTER**2 * before):
        return None
    rows = np.flatnonzero(np.diff(turns))
    ends = " to ".join(quantity(series[rows[0] + k], unit) for k in (0, 1))
    counts, number = "from end to end", f"{quantity(period, unit, 6)}, before any factor"
    if bits:
        step = quantity(resolution(series), unit)
        counts = f"2^{bits} = {2**bits} of its steps of {step}"
        number = f"{2**bits} of such steps, or {quantity(period, unit, 6)}"
    return DataWarning(
        "wraps",
        place_of(recording, column),
        f"jumps from {ends} in {row_of(recording, rows[0] + 1)}{more(rows.size)}: {counts}",
        "a counter that begins again: unwrap it, by period in [columns], a number as the file has"
        f" it: {number}",
        blocks=True,
    )


def _goes_on(changes: FloatArray, period: float, step: float) -> bool:
    """Return whether a counter moves at every jump, and as much over it as beside it."""
    turns = np.rint(changes / period)
    unwrapped = changes - period * turns
    for row in np.flatnonzero(turns):
        beside = np.append(unwrapped[max(0, row - _AROUND) : row], unwrapped[row + 1 :][:_AROUND])
        low, high = beside.min() - 2.0 * step, beside.max() + 2.0 * step
        if not low <= unwrapped[row] <= high or abs(float(np.median(beside))) < step:
            return False
    return True


def _period(series: FloatArray) -> tuple[float, int]:
    """Period of a counter that jumps from end to end, and its bits; 0 if there are none."""
    changes, step = np.diff(series), resolution(series)
    rows = np.flatnonzero(np.abs(changes) > _WRAPS * np.ptp(series))
    if not 0 < rows.size < _SHARED * changes.size:
        return 0.0, 0
    largest = float(np.abs(changes[rows]).max())
    bits = int(np.rint(np.log2(largest / step))) if step else 0
    period = step * 2.0**bits
    most = max(largest, float(np.ptp(series)))
    if bits < _LEAST_BITS or not most < _NEARLY * period < _NEARLY**2 * largest:
        # rounded once more in the file: about as long as its largest jump
        period, bits = float(np.median(np.abs(changes[rows]))), 0
        if not changes[rows].max() > 0.0 > changes[rows].min():
            return 0.0, 0
    smooth = float(np.percentile(np.abs(changes), _MOVES)) < _SMOOTH * period
    return (period, bits) if smooth and np.ptp(series) <= _NEARLY * period else (0.0, 0)


def _drive_warning(
    recording: Recording, simulated: Recording, replay: Replay, column: str
) -> DataWarning | None:
    """A drive that jumps where nothing that it moves does."""
    series = recording.columns[column]
    changes = np.diff(series)
    bends = np.abs(changes - median_around(changes, _SIDE))
    large = np.abs(changes) > _STEP * np.percentile(np.abs(changes), _MOVES)
    large |= bends > _STEP * np.percentile(bends, _USUAL)
    intervals = np.diff(recording.time)
    rows = np.flatnonzero(large & (intervals < _STEP * np.median(intervals))) + 1
    noise = noise_levels(recording)
    if not rows.size or not noise:
        return None
    errors = np.array(
        [(recording.columns[c] - simulated.columns[c]) / level for c, level in noise.items()]
    )
    worsens = {row: _worsens(errors, row) for row in rows.tolist()}
    likely = sorted((row for row in worsens if worsens[row] > 0.0), key=lambda r: -worsens[r])
    for row in likely[:_TRIES]:
        size = float(changes[row - 1] - median_around(changes, _SIDE)[row - 1])
        straight = float(series[row]) - size
        scale = float(series[row]) / straight if straight else 1.0
        left = [_errors(recording, simulated, row)]
        for mended in (series - size, series / scale if scale > 0.0 else series):
            shown = replay(_changed(recording, column, np.append(series[:row], mended[row:])))
            failed = np.full(len(noise), np.inf)
            left.append(failed if shown is None else _errors(recording, shown, row))
        best = min(left[1:], key=np.sum)
        agrees = _AGREES**2 * (series.size - row)
        if best.sum() < _BETTER**2 * left[0].sum() and (best < np.maximum(left[0], agrees)).all():
            if best is left[2]:
                return _other_scale(recording, column, row, scale)
            by = quantity(size, column_unit(column))
            return DataWarning(
                "zero_step",
                place_of(recording, column),
                f"jumps by {by} before {row_of(recording, row)}, where no measured column moves as"
                " the model would",
                f"an encoder that lost its zero: subtract {by} from that row on, or end the"
                " recording before it",
                blocks=True,
            )
    return None


def _other_scale(recording: Recording, column: str, row: int, scale: float) -> DataWarning:
    return DataWarning(
        "scale_change",
        place_of(recording, column),
        f"reads {plain(scale)} times as much from {row_of(recording, row)} on, where nothing else"
        " changes",
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
    if before == 0.0 or after < before / _BETTER:
        return -np.inf
    share = row / off.shape[1]
    return float(np.log(whole) - share * np.log(before) - (1.0 - share) * np.log(after))


def _reading_warning(
    recording: Recording, simulated: Recording, replay: Replay, column: str
) -> DataWarning | None:
    """A reading whose zero or scale changes between two samples, and nothing else does."""
    read = recording.columns[column]
    shown = np.clip(simulated.columns[column], *range_ends(read, recording.measured[column].noise))
    seen = jumps(read - shown) or jumps(read)
    alone = [
        j for j in seen if _stays(read - shown, j) and not _explained(recording, shown, column, j)
    ]
    if alone:
        jump = max(alone, key=lambda j: abs(j.size))
        later = [j.row for j in alone if j.row > jump.row]
        stretch = slice(jump.row, min(later, default=read.size))
    else:
        row = _split(recording, shown, column)
        if row is None:
            return None
        size = float(np.median((read - shown)[row:]) - np.median((read - shown)[:row]))
        jump, stretch = _Jump(row, size), slice(row, read.size)
    scale = _scale(read, shown, jump, stretch, bool(alone))
    mended, before, after = read.copy(), *_sides(jump)
    shift = float(np.mean((read - shown)[after]) - np.median((read - shown)[before]))
    mended[stretch] = read[stretch] - shift if scale is None else read[stretch] / scale
    if _slips(recording, simulated, replay, jump, _changed(recording, column, mended)):
        return None
    if scale is not None:
        return _other_scale(recording, column, jump.row, scale)
    changes = np.diff(read)
    sudden = abs(float((changes - median_around(changes, _SIDE))[jump.row - 1]))
    if sudden < _SUDDEN * abs(jump.size) - _HIDDEN * noise_levels(recording)[column]:
        return None  # a tare steps between two samples
    unit = column_unit(column)
    by = quantity(jump.size, unit)
    values = (quantity(float(read[jump.row + k]), unit) for k in (-1, 0))
    return DataWarning(
        "zero_step",
        place_of(recording, column),
        f"its zero steps by {by} before {row_of(recording, jump.row)}{more(len(alone))}, from"
        f" {' to '.join(values)}, where nothing else moves",
        f"a tare, or an encoder that lost its zero: subtract {by} from that row on, or end the"
        " recording before it",
        blocks=True,
    )


def _stays(off: FloatArray, jump: _Jump) -> bool:
    """Return whether a reading is off by a jump for long: on a flank of a play it comes back."""
    before = off[max(0, jump.row - _LONG) : max(1, jump.row - _AROUND)]
    after = off[min(jump.row + _AROUND, off.size - 1) : jump.row + _LONG]
    return float(np.median(after) - np.median(before)) / jump.size > _SHARED


def _explained(recording: Recording, shown: FloatArray, column: str, jump: _Jump) -> bool:
    """Return whether rows are missing, a drive steps or starts, the model jumps or another reading.

    A reading of a rig with play stands still while the model moves on, and follows it late.
    """
    intervals = np.diff(recording.time)
    if intervals[jump.row - 1] > _STEP * np.median(intervals):
        return True  # a gap, which is reported
    near = slice(max(0, jump.row - 1 - _AROUND), jump.row + 1)  # causes go before
    for driven in recording.drive:
        changes = np.abs(np.diff(recording.columns[driven]))
        if changes[near].max() > _STEP * np.percentile(changes, _MOVES):
            return True
        corners = np.abs(np.diff(recording.columns[driven], 2))  # where it starts, stops, turns
        least = max(
            _STEP * np.percentile(corners, _MOVES), _CORNER * np.percentile(changes, _MOVES)
        )
        if corners[near].max(initial=0.0) > least:
            return True
    changes, least = np.diff(shown), _SHARED * abs(jump.size)
    if np.abs((changes - median_around(changes, _SIDE))[near]).max() > least:
        return True
    before = slice(0, jump.row)
    read, model = (np.abs(y[before] - y[jump.row - 1]) for y in (recording.columns[column], shown))
    still = int(np.flatnonzero(read > least).max(initial=-1)) + 1
    if (model - read)[still:].max() > least:
        return True
    return any(
        abs(j.row - jump.row) <= _AROUND
        for other in recording.measured
        if other != column
        for j in jumps(recording.columns[other])
    )


def _scale(
    read: FloatArray, shown: FloatArray, jump: _Jump, after: slice, alone: bool
) -> float | None:
    """By which a reading is multiplied from a jump on; None if an offset explains it better."""
    before = slice(max(0, jump.row - 4 * _AFTER), jump.row)
    if np.ptp(shown[before]) == 0.0 or np.ptp(shown[after]) == 0.0:
        return None
    slope, offset = np.polyfit(shown[before], read[before], 1)
    model = slope * shown[after] + offset
    measured = read[after]
    scale = float(model @ measured / (model @ model))
    scaled = float(np.sum((measured - scale * model) ** 2))
    moved = float(np.sum((measured - model - np.mean(measured - model)) ** 2))
    jumped = (scale - 1.0) * read[jump.row - 1]
    fits = not alone or abs(jumped - jump.size) < _SHARED * abs(jump.size)
    return scale if scaled < moved and fits and abs(scale - 1.0) > _OTHER_SCALE else None


def _split(recording: Recording, shown: FloatArray, column: str) -> int | None:
    """Sample before which the relation of a reading to the model changes at once, if it does.

    The model has to agree with the data on either side, up to a zero and a scale, and neither a
    zero nor a scale that change evenly may explain it.
    """
    read, noise = recording.columns[column], noise_levels(recording)[column]
    whole = _left(read, np.column_stack([np.ones_like(shown), shown]))
    agrees = read.size * (_AGREES * noise) ** 2
    least = min(_SPLIT**2 * whole, agrees)
    if whole <= agrees / _AGREES**2 * 1.5:
        return None
    edge = max(_EDGE, int(_PART * read.size))
    if 2 * edge >= read.size:
        return None
    halves = _left_before(read, shown) + _left_before(read[::-1], shown[::-1])[::-1]
    best = edge + int(np.argmin(halves[edge : read.size - edge + 1]))
    time = recording.time - recording.time.mean()
    gradual = _left(read, np.column_stack([np.ones_like(shown), shown, time, time * shown]))
    left = float(halves[best])
    return best if left < least and left < _GRADUAL * gradual else None


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


def _sides(jump: _Jump) -> tuple[slice, slice]:
    """Samples before and after a jump, except those in which a rig would follow a slip."""
    before = slice(max(0, jump.row - _AFTER), max(1, jump.row - _SIDE))
    return before, slice(jump.row + _SIDE, jump.row + _AFTER)


def _slips(
    recording: Recording, simulated: Recording, replay: Replay, jump: _Jump, mended: Recording
) -> bool:
    """Return whether a step of a drive's zero, as by a slip, explains more than ``mended``."""
    noise = noise_levels(recording)
    before, after = _sides(jump)

    def off(measured: Recording, shown: Recording) -> FloatArray:
        """(columns, n) by how much readings are off after the jump beyond before it [noise]."""
        errors = ((measured.columns[c] - shown.columns[c]) / noise[c] for c in noise)
        return np.array([e[after] - np.median(e[before]) for e in errors])

    left, wanted = float(np.sum(off(mended, simulated) ** 2)), off(recording, simulated)
    for driven in recording.drive:
        series = recording.columns[driven]
        span = float(np.ptp(series))
        slip = _PROBE * span
        for _ in range(_TRIES):
            shifted = np.append(series[: jump.row], series[jump.row :] + slip)
            tried = replay(_changed(recording, driven, shifted))
            if tried is None:
                break
            if float(np.sum(off(recording, tried) ** 2)) < _TIE * left:
                return True
            change = wanted - off(recording, tried)
            power = float(np.sum(change**2))
            slip *= float(np.sum(change * wanted)) / power if power > 0.0 else 0.0
            if not 0.0 < abs(slip) < span:
                break
    return False


def _changed(recording: Recording, column: str, series: FloatArray) -> Recording:
    return replace(recording, columns={**recording.columns, column: series})


def _errors(recording: Recording, simulated: Recording, row: int = 0) -> FloatArray:
    """Of each measured column, squared errors from a sample on, beyond their offset before it."""
    errors = []
    for column, level in noise_levels(recording).items():
        off = (recording.columns[column] - simulated.columns[column]) / level
        errors.append(float(np.sum((off[row:] - np.median(off[: row or None])) ** 2)))
    return np.array(errors)
