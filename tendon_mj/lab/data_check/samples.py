"""Warnings about samples of a column: spikes, lost turns, and marks of a converter.

The marks: readings that are frozen or held, ends of a range, coarse steps, and tensions below 0.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from tendon_mj.lab.data_check.warning import (
    DataWarning,
    columns_of,
    lost_turns,
    median_around,
    more,
    place_of,
    row_of,
    usual_range,
)
from tendon_mj.lab.recordings import (
    Recording,
    held_values,
    is_noisy,
    noise_levels,
    range_ends,
    resolution,
    white_noise,
)
from tendon_mj.lab.replay import Adjustable, column_unit, expand, quantity
from tendon_mj.plugin import sensor_kind
from tendon_mj.typing import FloatArray

_AROUND = 2  # samples on either side: an excursion of so many at most is a spike
_SPIKE = 0.5  # of the usual range, that a spike is off by at least
_NOISES = 12.0  # times the median deviation from the neighbours, likewise
_LONGEST_DROPOUT, _ONLY = 5, 0.8  # samples; share of those at a value that are dropouts
_USUAL, _LARGE = 80.0, 4.0  # percentile of a column's changes, times which it drops out at least
_ABOUT = 3.0  # times as much or as little, an excursion of the model is the same
_SOON = 10  # samples from an excursion of the model, within which the rig makes its own
_BEYOND, _LEVEL = 3.0, 20  # noises beyond all readings; samples and noises that are level there
_PART = 0.1  # of the model's range, that a column with an end has; of a column's, a dropout
_BARELY = 1.3  # noises, by which a level reading varies at most
_LONGEST_DRIVE = 5  # samples for which a drive is held: longer ones are rests
_VISIBLE = 2.5e-3  # of a column's range: visible to a diagnosis, where no noise is stated
_SLACK = 0.02  # of a tension's range, below which a cable is slack
_BELOW, _FEW = 5.0, 3  # noises below 0, and samples there, at least
_ALIKE = 4  # rests at an end of a range, at least
_HELD, _HELD_AT_REST = 10, 4  # equal samples, or rests, at least
_MEANWHILE, _MEANWHILE_OF_NOISY = 0.25, 0.02  # of its range, by which the model moves on then


def turn_warnings(recording: Recording) -> Iterator[DataWarning]:
    """Warn of driven and measured angles that jump by a turn."""
    for _, column in columns_of(recording):
        jumps = lost_turns(recording, column)
        if not jumps.size:
            continue
        before, after = recording.columns[column][jumps[0] - 1 : jumps[0] + 1]
        yield DataWarning(
            "turn",
            place_of(recording, column),
            f"jumps from {quantity(before, 'rad')} to {quantity(after, 'rad')} in row"
            f" {recording.row(jumps[0])}{more(jumps.size)}: a turn",
            "an encoder that starts again after a turn: unwrap it, by period = 360 in"
            " [columns] or as numpy.unwrap(angle, period=360) does with degrees",
            blocks=True,
        )


def spike_warnings(recording: Recording, simulated: Recording | None) -> Iterator[DataWarning]:
    """Warn of samples of driven and measured columns from which their neighbours differ.

    Not of a sample at which the model makes the same excursion, as where a cable is let off for one
    settled point, and not of a reading soon before or after an excursion of the model.
    """
    if recording.quasi_static:  # rests differ by moves
        return
    noise = noise_levels(recording)
    off = {c: _off(recording.columns[c]) for _, c in columns_of(recording)}
    shown = {} if simulated is None else {c: _off(simulated.columns[c]) for c in recording.measured}
    follows = np.zeros(recording.time.size, bool)
    for column, excursion in shown.items():
        follows |= _alike(recording.columns[column], off[column], excursion)
    for table, column in columns_of(recording):
        if lost_turns(recording, column).size:
            continue  # reported already
        series = recording.columns[column]
        excursion = np.abs(off[column])
        if table == "drive":  # a command that begins with a step, or ends with one
            excursion[[0, -1]] = 0.0
        limit = max(_SPIKE * usual_range(series), _NOISES * float(np.median(excursion)))
        known = follows
        if table == "measured" and column in shown:
            known = follows | _near(np.abs(shown[column]) > limit / _ABOUT)
        lost = table == "measured" and _dropouts(series, noise[column], simulated, column)
        spikes = np.flatnonzero(((excursion > limit) | lost) & ~known)
        if not spikes.size:
            continue
        worst = int(spikes[np.argmax(excursion[spikes])])
        first = f"the largest of {spikes.size}, the first in row {recording.row(spikes[0])},"
        at, before, after = (
            quantity(series[k], column_unit(column))
            for k in (worst, max(0, worst - 1), min(worst + 1, series.size - 1))
        )
        yield DataWarning(
            "spike",
            place_of(recording, column),
            f"reads {at} in row {recording.row(worst)}{f', {first}' if spikes.size > 1 else ','}"
            f" between {before} and {after}",
            "a glitch of the logger: leave the row out",
            blocks=True,
        )


def _off(series: FloatArray) -> FloatArray:
    """(n,) of each sample, its distance from the median of it and its neighbours."""
    return series - median_around(series, _AROUND)


def _dropouts(
    series: FloatArray, noise: float, simulated: Recording | None, column: str
) -> NDArray[np.bool_]:
    """(n,) samples at 0 or another fixed value to which a reading goes and from which it returns.

    A value is fixed where a noisy reading has it for several samples, or often, and nowhere else.
    """
    starts = np.flatnonzero(np.diff(series, prepend=np.nan) != 0.0)
    lengths = np.diff(np.append(starts, series.size))
    before = np.append(np.nan, series[starts[1:] - 1])
    after = np.append(series[starts[1:]], np.nan)
    there = series[starts] - before, after - series[starts]
    usual = float(np.percentile(np.abs(np.diff(series)), _USUAL))
    limit = max(_NOISES * noise, _LARGE * usual, _PART * usual_range(series))
    returns = (np.minimum(*np.abs(there)) > limit) & (there[0] * there[1] < 0.0)
    returns &= lengths <= _LONGEST_DROPOUT
    lost = np.zeros(series.size, bool)
    for value in np.unique(series[starts[returns]]):
        own = returns & (series[starts] == value)
        count = int(lengths[own].sum())
        if (value == 0.0 or count > 2) and count > _ONLY * np.count_nonzero(series == value):
            lost[np.repeat(own, lengths)] = True
    if simulated is not None and lost.any():
        shown = simulated.columns[column]
        lost &= ~_near(np.abs(shown - median_around(shown, _LONGEST_DROPOUT)) > limit / _ABOUT)
    return lost


def _near(samples: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(n,) samples that are among the given ones, or up to `_SOON` from one."""
    near: NDArray[np.bool_] = binary_dilation(samples, np.ones(2 * _SOON + 1))
    return near


def _alike(read: FloatArray, off: FloatArray, shown: FloatArray) -> NDArray[np.bool_]:
    """Samples at which a reading leaves its neighbours, and the model does by about as much."""
    large = np.abs(off) > 0.5 * _SPIKE * usual_range(read)
    return large & (off * shown > off**2 / _ABOUT) & (off * shown < off**2 * _ABOUT)


def converter_warnings(
    recording: Recording, simulated: Recording | None
) -> Iterator[DataWarning | None]:
    """Warn of the marks of converters: a range's ends, held values, and steps."""
    at_rest = recording.quasi_static  # values repeat, and change by moves
    for column in recording.drive:
        if column not in recording.hold and not at_rest:
            yield _held(recording, "drive", column, simulated)
    for column in recording.measured:
        shown = None if simulated is None else simulated.columns[column]
        yield _range_end(recording, column, shown)
        if not at_rest:
            yield _held(recording, "measured", column, simulated)
            yield _coarse(recording, column)


def _range_end(recording: Recording, column: str, shown: FloatArray | None) -> DataWarning | None:
    series, unit = recording.columns[column], column_unit(column)
    ends = _ends(recording, column, shown)
    if not ends:
        if shown is None or recording.quasi_static:
            return None
        return _flat_end(recording, column, shown)
    at_end = np.isin(series, ends)
    values = " and ".join(quantity(end, unit) for end in ends)
    beyond = ""
    if shown is not None:
        past = max(float(np.max(np.abs(shown[series == end] - end))) for end in ends)
        beyond = f", where the model goes on by up to {quantity(past, unit)}"
    return DataWarning(
        "range_end",
        place_of(recording, column),
        f"ends at {values}: {int(at_end.sum())} samples are there exactly, the first in"
        f" {row_of(recording, int(np.argmax(at_end)))}{beyond}",
        "the end of an amplifier's or a converter's range: record again with a wider one"
        + ("" if recording.quasi_static else "; a diagnosis cuts the model off there too"),
        blocks=recording.quasi_static,
    )


def _ends(recording: Recording, column: str, shown: FloatArray | None) -> list[float]:
    """Ends of the range at which readings are cut off."""
    series, ends = recording.columns[column], list[float]()
    if not recording.quasi_static:
        ends = [e for e in range_ends(series, recording.measured[column].noise) if np.isfinite(e)]
    elif shown is not None:  # moves are as noise
        ends = _ends_at_rest(series, shown, noise_levels(recording)[column])
    if shown is None or column_unit(column) != "N":
        return ends
    slack = _SLACK * usual_range(shown)  # a cable that is let off ends at 0 too
    return [e for e in ends if e != 0.0 or float(np.median(shown[series == e])) > slack]


def _ends_at_rest(series: FloatArray, shown: FloatArray, noise: float) -> list[float]:
    """Ends at which several rests read the same to the last digit, and the model does not."""
    least = max(_PART * float(np.ptp(shown)), _BEYOND * noise)
    ends = float(series.min()), float(series.max())
    there = {end: shown[series == end] for end in ends if np.ptp(series) > 0.0}
    return [e for e, model in there.items() if model.size >= _ALIKE and np.ptp(model) > least]


def _flat_end(recording: Recording, column: str, shown: FloatArray) -> DataWarning | None:
    """A range's end before the noise: readings are level wherever the model is beyond them all."""
    series, unit, noise = recording.columns[column], column_unit(column), noise_levels(recording)
    if usual_range(series) < _PART * usual_range(shown):
        return None  # another unit, or a sensor that is not connected
    for sign in (-1.0, 1.0):
        read, model, level = sign * series, sign * shown, noise[column]
        beyond = model > read.max() + _BEYOND * level
        if np.count_nonzero(beyond) < _LEVEL or np.ptp(model[beyond]) < _LEVEL * level:
            continue
        end, first = float(np.median(series[beyond])), int(np.argmax(beyond))
        if np.std(read[beyond]) > _BARELY * level:
            continue
        return DataWarning(
            "range_end",
            place_of(recording, column),
            f"is level at {quantity(end, unit)} in {int(beyond.sum())} samples, the first in"
            f" {row_of(recording, first)}, where the model goes on by up to"
            f" {quantity(float(np.max(np.abs(shown[beyond] - end))), unit)}",
            "the end of an amplifier's range, or a stop that the model lacks: record again with a"
            " wider one, or end the recording before it",
            blocks=True,
        )
    return None


def _held(
    recording: Recording, table: str, column: str, simulated: Recording | None
) -> DataWarning | None:
    series = recording.columns[column]
    if table == "drive":
        repeats = held_values(series, None, _LONGEST_DRIVE)
    else:
        repeats = held_values(series, recording.measured[column].noise)
    if not repeats.any():
        return None
    fresh = np.interp(recording.time, recording.time[~repeats], series[~repeats])
    error = float(np.sqrt(np.mean((series - fresh) ** 2)))
    noise = noise_levels(recording)
    if table == "drive" and simulated is not None:  # its effect in the model, on the average
        shown = {c: usual_range(simulated.columns[c]) / usual_range(series) for c in noise}
        seen = any(error * shown[c] > noise[c] for c in noise)
    else:
        seen = table == "drive" or error > noise[column]
    first = int(np.argmax(repeats))
    changes = int(np.count_nonzero(~repeats))
    held = (
        "a command that is held: write { actuator = …, hold = true }; a position that is"
        if table == "drive"
        else "a sensor that is"
    )
    return DataWarning(
        "repeated",
        place_of(recording, column),
        f"repeats its last value in {int(repeats.sum())} of {series.size} samples, first in"
        f" {row_of(recording, first)}, one new value in {series.size / changes:.2g} samples",
        f"{held} read faster than it converts: log at its own rate, or leave out the rows that"
        " repeat",
        blocks=seen,
    )


def _coarse(recording: Recording, column: str) -> DataWarning | None:
    series, unit = recording.columns[column], column_unit(column)
    step, stated = resolution(series), recording.measured[column].noise
    rounding = step / np.sqrt(12.0)
    if stated is not None:
        coarse = noise_levels(recording)[column] > stated
        noise = f"the stated noise of {quantity(stated, unit)}"
    else:
        half = white_noise(series) < np.sqrt(2.0) * rounding  # of its noise, by the variance
        coarse = half and step > _VISIBLE * usual_range(series)
        noise = "what other noise it has"
    if not coarse:
        return None
    first = int(np.argmax(np.diff(series) != 0.0)) + 1
    return DataWarning(
        "coarse",
        place_of(recording, column),
        f"moves in steps of {quantity(step, unit)}, the first in {row_of(recording, first)}:"
        f" coarser than {noise}",
        f"state noise = {quantity(rounding, unit)} (the step over √12) or more, which a diagnosis"
        " takes at least; a finer range of the converter shows more",
    )


def slack_warnings(
    recording: Recording, simulated: Recording, adjustable: Adjustable
) -> Iterator[DataWarning]:
    """Warn of tensions of a cable that are measured below 0, where a cable cannot push."""
    stated = {**recording.uncertain, **recording.session}
    fitted = expand(stated, adjustable.names())
    for column, measured in recording.measured.items():
        sensor = adjustable.model.sensor(measured.sensor).id
        kind = sensor_kind(adjustable.model, sensor)
        if not kind.endswith("tension") or f"{measured.sensor}.offset" in fitted:
            continue
        scale, offset = adjustable.readings[sensor, :2].tolist()
        noise = noise_levels(recording)[column]
        tension = np.sign(scale) * (recording.columns[column] - offset)
        shown = np.sign(scale) * (simulated.columns[column] - offset)
        below = np.flatnonzero((tension < -_BELOW * noise) & (shown > -noise))
        if below.size < _FEW:
            continue
        worst, unit = int(below[np.argmin(tension[below])]), column_unit(column)
        yield DataWarning(
            "below_zero",
            place_of(recording, column),
            f"reads {quantity(recording.columns[column][worst], unit)} in"
            f" {row_of(recording, worst)}, and {below.size} samples below 0"
            f" from row {recording.row(below[0])} on, where a cable cannot push",
            "the load cell's zero was set under load, or has shifted: set it with the cable"
            f' off, or write "{measured.sensor}.offset" in [known] or [uncertain]',
            blocks=True,
        )


def frozen(recording: Recording, column: str, shown: FloatArray) -> DataWarning | None:
    """Warn of readings that are equal to the last digit for long, while the model moves on.

    Noise never is: of a noisy column, the model has to move on by little.
    """
    read = recording.columns[column]
    ends = np.flatnonzero(np.diff(read, prepend=np.nan, append=np.nan) != 0.0)
    noisy = not recording.quasi_static and is_noisy(read)
    held = _HELD_AT_REST if recording.quasi_static else _HELD
    level, unit = noise_levels(recording)[column], column_unit(column)
    share = _MEANWHILE_OF_NOISY if noisy else _MEANWHILE
    limit = max(share * float(np.ptp(shown)), _BEYOND * level)
    worst, place = 0.0, (0, 0)
    for start, end in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        near = np.abs(shown[start:end]).min() < _BEYOND * level
        slack = read[start] == 0.0 and unit == "N" and near
        if end - start >= held and not slack and np.ptp(shown[start:end]) > max(limit, worst):
            worst, place = float(np.ptp(shown[start:end])), (start, end)
    if worst == 0.0:
        return None
    start, end = place
    return DataWarning(
        "frozen",
        place_of(recording, column),
        f"reads {quantity(read[start], unit)} from row {recording.row(start)} to"
        f" {recording.row(end - 1)}, {recording.time[end - 1] - recording.time[start]:.3g} s, in"
        f" which the model moves by {quantity(worst, unit)}",
        "if the sensor or its bus hung there, leave these rows out",
        blocks=noisy,  # else a cable that sticks may be as still
    )
