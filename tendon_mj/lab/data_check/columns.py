"""Checks of columns: samples, jumps by a turn, marks of a converter; readings against the model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from tendon_mj.lab.recordings import (
    Recording,
    estimate_noise,
    held_values,
    is_noisy,
    noise_levels,
    range_ends,
    resolution,
    si_name,
    white_noise,
)
from tendon_mj.lab.replay import Adjustable, column_unit, expand, quantity
from tendon_mj.plugin import sensor_kind
from tendon_mj.typing import FloatArray

_TURN, _NEARLY = 2.0 * np.pi, 0.15  # of an encoder [rad], and by what share a jump may differ
_SMOOTH = 0.1  # of a turn, by which other samples differ at most, in the median
_OUTER = 1.0  # percent of the samples at either end that do not count for the usual range

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

_OVERSTATED = 10.0  # times the noise from sample to sample; slow noise may be several times it
_TWICE, _ABOUT_TWICE = 2.0, 1.15  # ratio of a diameter and a radius, and its tolerance
_SAME_SHAPE = 0.98  # correlation of a column and the model's, that differ by a factor
_THOUSAND = 100.0  # ratio of two ranges from which it may be 1000: friction is not proportional
_HARDLY = 3000.0  # ratio of two ranges that no mistaken unit explains
_ALL = 5.0  # ratio from which, if every column is off by it, the drive is meant
_KILOGRAM_FORCE, _ABOUT_KILOGRAM_FORCE = 9.80665, 0.1  # [N], relative
_DEGREES, _ABOUT_DEGREES = 180.0 / np.pi, 1.5  # ratio of degrees and radians, and its tolerance
_TURNED = 3.0  # range of angles that may be degrees [rad]; less of these would be no motion
_LITTLE = 1e-3  # of a range, an error that none is
_AGAINST = -0.7  # correlation below which a column runs against the model
_STILL = 1e-6  # of a value's size, a range that is not a motion
_OFF = 0.15  # of the measured range, by which the start may differ
_START = 5.0  # of the stated noise, likewise
_FIRST = 5  # samples that are the start


@dataclass(frozen=True)
class DataWarning:
    """Something in a recording that a fit would take for a property of the rig."""

    identifier: str  # its kind in one word
    place: str  # recording and column, actuator or joint
    value: str  # the finding, with its unit
    way_out: str  # what to do
    # whether a fit cannot see through it, so that no effect is to be named meanwhile
    blocks: bool = False

    @property
    def sentence(self) -> str:
        """The warning in one line."""
        return f"{self.place}: {self.value}; {self.way_out}"

    def result(self) -> dict[str, str | bool]:
        """Plain entries for `result.json`."""
        return vars(self) | {"sentence": self.sentence}


def columns_of(recording: Recording) -> Iterator[tuple[str, str]]:
    """("drive" or "measured", column) of each column that has a role."""
    yield from (("drive", column) for column in recording.drive)
    yield from (("measured", column) for column in recording.measured)


def place_of(recording: Recording, column: str) -> str:
    """Recording, table of the description and name in the file of a column, for messages."""
    table = "drive" if column in recording.drive else "measured"
    return f"{recording.name}, [{table}] {recording.written(column)!r}"


def row_of(recording: Recording, sample: int) -> str:
    """Row and time of a sample, for messages."""
    return f"row {recording.row(sample)} ({recording.time[sample]:.6g} s)"


def more(count: int) -> str:
    """Message that there are others besides the first."""
    return f", and {count - 1} times more" if count > 1 else ""


def usual_range(series: FloatArray) -> float:
    """Range of a series without its most extreme samples; all of it where the rest is constant."""
    low, high = np.percentile(series, [_OUTER, 100.0 - _OUTER])
    return float(high - low) or float(np.ptp(series))


def median_around(series: FloatArray, around: int) -> FloatArray:
    """(n,) median of each sample and its neighbours, so many on either side."""
    padded = np.pad(series, around, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * around + 1)
    median: FloatArray = np.median(windows, axis=1)
    return median


def lost_turns(recording: Recording, column: str) -> NDArray[np.int64]:
    """Samples before which an angle jumps by a turn, as of an encoder that begins again."""
    if column_unit(column) != "rad":
        return np.zeros(0, np.int64)
    steps = np.abs(np.diff(recording.columns[column]))
    if float(np.median(steps)) > _SMOOTH * _TURN:
        return np.zeros(0, np.int64)
    return np.flatnonzero(np.abs(steps - _TURN) < _NEARLY * _TURN) + 1


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
            "an encoder that starts again after a turn: unwrap it, by period in [columns], which is"
            " a turn in the file's own numbers (360 of degrees, 4096 of 12 bits)",
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
    near: NDArray[np.bool_] = scipy.ndimage.binary_dilation(samples, np.ones(2 * _SOON + 1))
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


def noise_warnings(recording: Recording) -> Iterator[DataWarning]:
    """Warn of a noise that is stated larger than a column shows at all, in which effects hide."""
    for column, measured in recording.measured.items():
        series, unit = recording.columns[column], column_unit(column)
        if measured.noise is None or recording.quasi_static or not is_noisy(series):
            continue
        shown = estimate_noise(series)
        if measured.noise > _OVERSTATED * shown:
            yield DataWarning(
                "noise",
                place_of(recording, column),
                f"the stated noise of {quantity(measured.noise, unit)} is"
                f" {measured.noise / shown:.0f} times what the readings show from sample to sample,"
                f" {quantity(shown, unit, 2)}",
                "state it as a standard deviation; a fit takes what is smaller for noise",
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
    # as measured over as simulated; inf if the model stands still
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
    taken as degrees. ``simulated``: at the numbers that the description states, None if that was
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
    finite = [factor for factor in factors if factor < _HARDLY] or factors[:1]
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
    if _stands(shown) or span > _HARDLY * simulated:
        model = f"stands still at {quantity(shown[0], unit)}" if _stands(shown) else "hardly moves"
        return DataWarning(
            "nothing_moves",
            place,
            f"moves by {moves}, where sensor {sensor!r} of the model {model}",
            "is it this sensor, does the actuator in [drive] move it, and in which unit is that?",
        )
    if simulated > _HARDLY * span:
        value = f"hardly moves, by {moves}, the model by {shown_moves}"
        return DataWarning("nothing_moves", place, value, unconnected)
    fault = _unit_fault(span / simulated, unit)
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
            f'if the sensor counts the other way, write "{sensor}.scale" = -1 in [known]; if the'
            ' motor\'s encoder does, "<actuator>.command_scale" with the other sign; if the tendon'
            " pulls the joint the wrong way in the model, change the sign of its radius there",
        )
    times = max(span / simulated, simulated / span)
    about_twice = _TWICE / _ABOUT_TWICE < times < _TWICE * _ABOUT_TWICE
    if unit in ("rad", "m") and about_twice and correlation > _SAME_SHAPE:
        return DataWarning(
            "diameter",
            place,
            f"moves by {moves}, the model by {shown_moves}, {times:.2g} times as"
            f" {'little' if span > simulated else 'much'}, in the same shape",
            "is a radius of the model, or a command_scale, a diameter, or a gear left out? A cable"
            " that stretches more or less than in the model does this too",
        )
    return frozen(recording, column, shown) or _start_warning(recording, column, shown, place)


def _unit_fault(ratio: float, unit: str) -> str:
    """Fault of the unit by a ratio of ranges, measured over simulated; empty if there is none."""
    if unit == "N" and abs(ratio * _KILOGRAM_FORCE - 1.0) < _ABOUT_KILOGRAM_FORCE:
        return f"{1.0 / ratio:.1f} times as little, as kilograms-force named newtons are"
    large, times = ratio > 1.0, max(ratio, 1.0 / ratio)
    if times > _THOUSAND:
        units = "thousandths of it (mm, mN)" if large else "thousands of it (kN)"
        return (
            f"{times:.0f} times as {'much' if large else 'little'}, as {units} under its name are"
        )
    if _DEGREES / _ABOUT_DEGREES < times < _DEGREES * _ABOUT_DEGREES:
        units = "degrees named radians" if large else "radians named degrees"
        return f"{times:.0f} times as {'much' if large else 'little'}, as {units} are"
    return ""


def _start_warning(
    recording: Recording, column: str, shown: FloatArray, place: str
) -> DataWarning | None:
    read, unit = recording.columns[column], column_unit(column)
    off = float(np.median(read[:_FIRST]) - np.median(shown[:_FIRST]))
    noise = recording.measured[column].noise or 0.0
    if abs(off) <= max(_OFF * usual_range(read), _START * noise):
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
        f'{_drive_zero(recording)}{cause}; or the sensor\'s zero: write "{sensor}.offset" in'
        " [known] or [uncertain]; or the recording begins in motion: record half a second of rest"
        " before it",
    )


def _drive_zero(recording: Recording) -> str:
    """What to write where the drive's zero may not be that of the model; empty where it is."""
    for column, _ in recording.driven:
        series, written = recording.columns[column], recording.written(column)
        first = float(series[0])
        if column_unit(column) in ("rad", "m") and abs(first) > _OFF * usual_range(series):
            offset = first / si_name(written)[1]
            return (
                f"the drive {written!r} begins at {quantity(first, column_unit(column))}, and the"
                " model's reference pose is at 0: if that was where the rig stood, lower its offset"
                f" in [columns] by {offset:.6g}; where it has no entry there, write {written} ="
                f' {{ column = "{written}", offset = {-offset:.6g} }}; or '
            )
    return ""


def _clipped(series: FloatArray) -> FloatArray:
    """A series without the peaks of its most extreme samples, which would be all that counts."""
    clipped: FloatArray = np.clip(series, *np.percentile(series, [1.0, 99.0]))
    return clipped if np.ptp(clipped) > 0.0 else series


def _stands(series: FloatArray) -> bool:
    """Return whether a series moves by nothing but rounding."""
    return float(np.ptp(series)) <= _STILL * float(np.abs(series).max(initial=0.0))
