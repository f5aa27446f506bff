"""Checks of columns: samples, jumps by a turn, marks of a converter; readings against the model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.column import (
    Column,
    a_step,
    columns_of,
    median_around,
    more,
    stands,
    usual_range,
)
from tendon_mj.lab.data_check.faults import DataWarning
from tendon_mj.lab.noise import (
    estimate_noise,
    held_values,
    is_noisy,
    noise_levels,
    range_ends,
    white_noise,
)
from tendon_mj.lab.parameter_names import expand
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Adjustable
from tendon_mj.lab.units import si_name
from tendon_mj.plugin import sensor_kind
from tendon_mj.typing import FloatArray

_DEGREES = math.degrees(1.0)


def turn(column: Column) -> DataWarning | None:
    """Warn of an angle that jumps by a turn."""
    jumps = column.lost_turns
    if not jumps.size:
        return None
    before, after = (column.say(column.read[jumps[0] + k]) for k in (-1, 0))
    row = column.recording.row(jumps[0])
    return column.warn(
        "turn",
        f"jumps from {before} to {after} in row {row}{more(jumps.size)}: a turn",
        "an encoder that starts again after a turn: unwrap it, by period in [columns],"
        " which is a turn in the file's own numbers (360 of degrees, 4096 of 12 bits)",
        blocks=True,
    )


# --- spikes


def spike_warnings(columns: Sequence[Column]) -> Iterator[DataWarning]:
    """Warn of samples of driven and measured columns from which their neighbours differ.

    Not of a sample at which a reading and the model make the same excursion, as where a cable is
    let off for one settled point, not of a reading soon before or after one of the model, and not
    where the samples beside it change by as much, as where a cable rings after a slip.
    """
    off, shown, limit = {}, {}, {}
    follows = np.zeros(1, bool)
    for column in columns:
        name, series = column.name, column.read
        off[name], shown[name] = (
            y - median_around(y, limits.AROUND) for y in (series, column.model)
        )
        noise = scipy.stats.median_abs_deviation(off[name], scale="normal")
        limit[name] = max(0.5 * usual_range(series), limits.CLEAR * float(noise))
        both = np.minimum(off[name] * np.sign(shown[name]), np.abs(shown[name]))
        follows = follows | (both > 0.5 * limit[name])
    for column in columns:
        if column.lost_turns.size:
            continue  # reported already
        series, excursion = column.read, np.abs(off[column.name])
        lost = np.zeros(series.size, bool)
        if column.driven:  # a command that begins with a step, or ends with one
            excursion[[0, -1]] = 0.0
        else:
            lost = _dropouts(column)
        known = follows | _near(np.abs(shown[column.name]) > 0.5 * limit[column.name])
        out = excursion > limit[column.name]
        out &= excursion > _changes_beside(series, out)
        spikes = np.flatnonzero((out | lost) & ~known)
        if not spikes.size:
            continue
        worst = int(spikes[np.argmax(excursion[spikes])])
        row = column.recording.row
        others = f" the largest of {spikes.size}, the first in row {row(spikes[0])},"
        yield column.warn(
            "spike",
            f"reads {column.say(series[worst])} in row"
            f" {row(worst)},{others if spikes.size > 1 else ''} between"
            f" {column.say(series[max(0, worst - 1)])} and"
            f" {column.say(series[min(worst + 1, series.size - 1)])}",
            "a glitch of the logger: leave the row out",
            blocks=True,
        )


def _changes_beside(series: FloatArray, out: NDArray[np.bool_]) -> FloatArray:
    """(n,) largest change near each sample between two that are not ``out``."""
    changes = np.abs(np.diff(series, append=series[-1]))
    changes[out | np.append(out[1:], False)] = 0.0
    largest: FloatArray = scipy.ndimage.maximum_filter1d(changes, 2 * limits.SIDE + 1)
    return largest


def _dropouts(column: Column) -> NDArray[np.bool_]:
    """(n,) samples at 0 or another fixed value to which a reading goes and from which it returns.

    A value is fixed where a noisy reading has it for several samples, or often, and nowhere else.
    """
    series = column.read
    starts = np.flatnonzero(np.diff(series, prepend=np.nan) != 0.0)
    lengths = np.diff(np.append(starts, series.size))
    before = np.append(np.nan, series[starts[1:] - 1])
    after = np.append(series[starts[1:]], np.nan)
    there = series[starts] - before, after - series[starts]
    noise = limits.CLEAR * column.noise
    limit = max(noise, a_step(np.diff(series)), limits.LITTLE * usual_range(series))
    returns = (np.minimum(*np.abs(there)) > limit) & (there[0] * there[1] < 0.0)
    returns &= lengths <= limits.SHORT
    lost = np.zeros(series.size, bool)
    for value in np.unique(series[starts[returns]]):
        here = returns & (series[starts] == value)
        count = int(lengths[here].sum())
        if (value == 0.0 or count > 2) and count > 0.5 * np.count_nonzero(series == value):
            lost[np.repeat(here, lengths)] = True
    shown = np.abs(column.model - median_around(column.model, limits.SHORT))
    return lost & ~_near(shown > 0.5 * limit)


def _near(samples: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(n,) samples within which a rig reacts to what is at the given ones."""
    around = np.ones(2 * limits.SIDE + 1)
    near: NDArray[np.bool_] = scipy.ndimage.binary_dilation(samples, around)
    return near


# --- marks of converters


def range_end(column: Column) -> DataWarning | None:
    """Warn of readings that are cut off at the end of a range."""
    recording, series = column.recording, column.read
    ends = _ends(column)
    if not ends:
        return None if recording.quasi_static else _level_end(column)
    at_end = np.isin(series, ends)
    first, others = column.row(int(np.argmax(at_end))), series[~at_end]
    said = " and ".join(column.say(end) for end in ends)
    if others.size and all(_is_far(end, y) for end in ends for y in (others, column.model)):
        return column.warn(
            "no_reading",
            f"reads {said} in {int(at_end.sum())} samples, the first in {first}, and else from"
            f" {column.say(others.min())} to {column.say(others.max())}",
            "what a logger writes where it has no reading: empty these cells in the file, or leave"
            " their rows out",
            blocks=True,
        )
    beyond = ""
    if column.simulated is not None:
        past = max(float(np.max(np.abs(column.model[series == end] - end))) for end in ends)
        beyond = f", where the model goes on by up to {column.say(past)}"
    return column.warn(
        "range_end",
        f"ends at {said}: {int(at_end.sum())} samples are there exactly, the first in"
        f" {first}{beyond}",
        "the end of an amplifier's or a converter's range: record again with a wider"
        f" one{'' if recording.quasi_static else '; a diagnosis cuts the model off there too'}",
        blocks=recording.quasi_static,
    )


def _is_far(value: float, series: FloatArray) -> bool:
    """Return whether a value is further from all of a series than these are from each other."""
    return bool(np.abs(series - value).min() > np.ptp(series))


def _ends(column: Column) -> list[float]:
    """Ends of the range at which readings are cut off."""
    series, model, little = column.read, column.model, limits.SIGMAS * column.noise
    if column.recording.quasi_static:  # moves are as noise: rests that read the same
        at_end = {e: model[series == e] for e in (series.min(), series.max()) if np.ptp(series)}
        least = max(limits.LITTLE * float(np.ptp(model)), little)
        ends = [float(e) for e, m in at_end.items() if m.size >= limits.RESTS and np.ptp(m) > least]
    else:
        ends = [end for end in range_ends(series, column.stated_noise) if np.isfinite(end)]
    if column.unit != "N":
        return ends
    # a cable that is let off ends at 0 too
    return [e for e in ends if e != 0.0 or not np.median(model[series == e]) <= little]


def _level_end(column: Column) -> DataWarning | None:
    """A range's end before the noise: readings are level wherever the model is beyond them all."""
    series, shown, noise = column.read, column.model, column.noise
    if usual_range(series) < limits.LITTLE * usual_range(shown):
        return None  # another unit, or a sensor that is not connected
    least = max(limits.LITTLE * usual_range(shown), limits.CLEAR * noise)
    for sign in (-1.0, 1.0):
        beyond = sign * shown > np.max(sign * series) + limits.SIGMAS * noise
        if np.count_nonzero(beyond) < limits.LEVEL or np.ptp(shown[beyond]) < least:
            continue
        if np.std(series[beyond]) < limits.ALIKE * noise:
            end = float(np.median(series[beyond]))
            return column.warn(
                "range_end",
                f"is level at {column.say(end)} in {int(beyond.sum())} samples, the first in"
                f" {column.row(int(np.argmax(beyond)))}, where the model goes on by up to"
                f" {column.say(np.max(np.abs(shown[beyond] - end)))}",
                "the end of an amplifier's range, or a stop that the model lacks: record again"
                " with a wider one, or end the recording before it",
                blocks=True,
            )
    return None


def held(column: Column) -> DataWarning | None:
    """Warn of values that are repeated, of a column that is read faster than it changes."""
    series, recording = column.read, column.recording
    if column.driven:
        repeats = held_values(series, None, limits.SHORT)
    else:
        repeats = held_values(series, column.stated_noise)
    if column.name in recording.hold or not repeats.any():
        return None
    fresh = np.interp(recording.time, recording.time[~repeats], series[~repeats])
    error = float(np.sqrt(np.mean((series - fresh) ** 2)))
    seen = not column.driven and error > limits.VISIBLE * column.noise
    if column.driven:  # its effect in the model, on the average
        simulated = column.simulated
        seen = simulated is None or any(
            error * usual_range(simulated.columns[c]) > limits.VISIBLE * noise * usual_range(series)
            for c, noise in noise_levels(recording).items()
        )
    what = "a sensor that is"
    if column.driven:
        what = "a command that is held: write { actuator = …, hold = true }; a position that is"
    return column.warn(
        "repeated",
        f"repeats its last value in {int(repeats.sum())} of {series.size} samples, first"
        f" in {column.row(int(np.argmax(repeats)))}, one new value in"
        f" {series.size / np.count_nonzero(~repeats):.2g} samples",
        f"{what} read faster than it converts: log at its own rate, or leave out the rows"
        " that repeat",
        blocks=seen,
    )


def coarse(column: Column) -> DataWarning | None:
    """Warn of steps that are coarser than the noise."""
    stated, rounding = column.stated_noise, column.step / math.sqrt(12.0)
    if stated is not None:
        is_coarse = column.noise > stated
        noise = f"the stated noise of {column.say(stated)}"
    else:  # of its noise, by the variance, the half
        is_coarse = white_noise(column.read) < math.sqrt(2.0) * rounding
        is_coarse &= column.step > limits.VISIBLE_STEP * usual_range(column.read)
        noise = "what other noise it has"
    if not is_coarse:
        return None
    row = column.row(int(np.argmax(np.diff(column.read) != 0.0)) + 1)
    step = column.say(column.step)
    return column.warn(
        "coarse",
        f"moves in steps of {step}, the first in {row}: coarser than {noise}",
        f"state noise = {column.say(rounding)} (the step over √12) or more, which a"
        " diagnosis takes at least; a finer range of the converter shows more",
    )


def overstated_noise(column: Column) -> DataWarning | None:
    """Warn of a noise that is stated larger than a column shows at all, in which effects hide."""
    if column.stated_noise is None or not is_noisy(column.read):
        return None
    noise = estimate_noise(column.read)
    times = column.stated_noise / noise
    if times <= limits.OVERSTATED:
        return None
    stated = column.say(column.stated_noise)
    return column.warn(
        "noise",
        f"the stated noise of {stated} is {times:.0f} times what the readings show from"
        f" sample to sample, {column.say(noise, 2)}",
        "state it as a standard deviation; a fit takes what is smaller for noise",
    )


def scatter_at_rest(column: Column) -> DataWarning | None:
    """Warn of a column that scatters by more than its noise before the drive moves, as by hum."""
    moves = [
        np.abs(drive.read - drive.read[0])
        > max(limits.STILL * float(np.ptp(drive.read)), 1.5 * drive.step)
        for drive in columns_of(column.recording)
        if drive.driven
    ]
    end = int(np.argmax(np.any(moves, axis=0)))
    settles = np.abs(column.model[:end] - column.model[end - 1]) > column.noise
    rest = slice(2 * int(np.flatnonzero(settles).max(initial=-1)) + 2, end)  # as slow a rig, twice
    time, read = column.recording.time[rest], column.read[rest]
    if read.size < limits.REST:
        return None
    slow = np.polynomial.Polynomial.fit(time, read, 3)
    scatter, noise = float(np.std(read - slow(time))), max(column.noise, 0.5 * column.step)
    if scatter <= limits.SCATTER * noise:
        return None
    known = "stated" if column.stated_noise else "estimated from sample to sample"
    return column.warn(
        "noise",
        f"scatters by {column.say(scatter, 2)} rms at rest, until {column.row(end)}, and its"
        f" noise is {known} as {column.say(column.noise, 2)}: hum, or other slow noise",
        f"state noise = {column.say(scatter, 2)}, with which a model that is right leaves no more"
        " than the noise; shielding, or a filter before the converter, takes hum away",
    )


# --- readings against the model


def drive_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of a recording that drives nothing, or whose driven columns all stand still."""
    place, value = recording.name, "no column is in [drive]"
    way_out = "say which column commands which actuator"
    if recording.drive:
        if not all(stands(recording.columns[column]) for column in recording.drive):
            return []
        place, value = _drive(recording), "stands still"
        way_out = "friction shows where the motion reverses: record one that goes back and forth"
    return [DataWarning("nothing_moves", place, value, way_out)]


def _drive(recording: Recording) -> str:
    columns = ", ".join(repr(recording.written(column)) for column in recording.drive)
    return f"{recording.name}, [drive] {columns}"


def reading_warnings(recording: Recording, simulated: Recording) -> list[DataWarning]:
    """Warn of measured columns: no motion, a wrong unit, a reversed sign, another start.

    Not of a column that jumps by a turn. A cable that is slack in the model, and a drive in a wrong
    unit, by which all columns are off, are reported alone: the rest follows from them. A column
    has one warning.
    """
    columns = [
        c for c in columns_of(recording, simulated) if not c.driven and not c.lost_turns.size
    ]
    if loose := list(filter(None, map(_slack, columns))):
        return loose
    # as measured over as simulated; inf if the model stands still
    ratios = [
        np.inf if stands(c.model) else usual_range(c.read) / usual_range(c.model) for c in columns
    ]
    if len(ratios) > 1 and any(0.0 < ratio < np.inf for ratio in ratios):
        if min(ratios) > limits.ALL:
            return [_drive_unit(recording, "less", ratios)]
        if max(ratios) < 1.0 / limits.ALL:
            return [_drive_unit(recording, "more", ratios)]
    in_turn = _still, _unit, _sign, _diameter, _frozen, _start, _unlike
    first = (next(filter(None, (fault(column) for fault in in_turn)), None) for column in columns)
    return list(filter(None, first))


def _slack(column: Column) -> DataWarning | None:
    """A tension that is measured, and 0 in the model for most of the time."""
    middle = float(np.median(column.read))
    if column.unit != "N" or not middle > 0.0 >= float(np.median(column.model)):
        return None
    return column.warn(
        "slack",
        f"reads {column.say(middle)} in the middle, and the model 0 N",
        "if this is a cable's tension, it is slack in the model: does its pull turn the"
        " joint the right way (the sign of the radius), and does it have a pretension?",
    )


def _drive_unit(recording: Recording, how: str, ratios: list[float]) -> DataWarning:
    times = [max(r, 1.0 / r) for r in ratios if 0.0 < r < np.inf]
    finite = [factor for factor in times if factor < limits.HARDLY] or times[:1]
    span = f"{min(finite):.0f}" + (f" to {max(finite):.0f}" if len(finite) > 1 else "")
    span += "" if len(finite) == len(ratios) else " or more"
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
        _drive(recording),
        f"in the model every measured column moves {how}, by a factor of {span}",
        f"name the column with the unit that it is in; {by_scale}",
    )


def _ranges(column: Column) -> tuple[float, float]:
    """Range as measured, and as simulated."""
    return usual_range(column.read), usual_range(column.model)


def _still(column: Column) -> DataWarning | None:
    """No motion, in the recording or in the model."""
    span, simulated = _ranges(column)
    moves, still = column.say(span), stands(column.model)
    if not stands(column.read) and (still or span > limits.HARDLY * simulated):
        how = f"stands still at {column.say(column.model[0])}" if still else "hardly moves"
        return column.warn(
            "nothing_moves",
            f"moves by {moves}, where sensor {column.sensor!r} of the model {how}",
            "is it this sensor, does the actuator in [drive] move it, and in which unit is that?",
        )
    if stands(column.read):
        value = f"reads {column.say(column.read[0])} from the first sample to the last"
    elif simulated > limits.HARDLY * span:
        value = f"hardly moves, by {moves}, the model by {column.say(simulated)}"
    else:
        return None
    way_out = "if the sensor was not connected, leave the column out of [measured]"
    return column.warn("nothing_moves", value, way_out)


def _unit(column: Column) -> DataWarning | None:
    """Another unit than named, by the ratio of ranges."""
    span, simulated = _ranges(column)
    large, times, units = span > simulated, max(span / simulated, simulated / span), ""
    digits, name = 0, column.recording.written(column.name)
    way_out = "name the column with the unit that it is in, or else the one in [drive]"
    degrees = _DEGREES / limits.DEGREES < times < _DEGREES * limits.DEGREES
    if column.unit == "N" and not large and abs(times / scipy.constants.g - 1.0) < limits.LITTLE:
        units, digits = "kilograms-force named newtons", 1
    elif _counts(column, times) and large and not (degrees and name == column.name):
        units, digits = "whole counts of an encoder under the name of an angle", 1
        count = math.tau / 4096.0 / si_name(name)[1]
        way_out = (
            f'if it counts, say in [columns] what one is: {name} = {{ column = "{name}",'
            f" factor = … }}, which is {count:.9g} where 4096 are a turn; if not, {way_out}"
        )
    elif times > limits.THOUSAND:
        units = "thousandths of it (mm, mN)" if large else "thousands of it (kN)"
        units += " under its name"
    elif degrees:
        units = "degrees named radians" if large else "radians named degrees"
    if not units:
        return None
    return column.warn(
        "unit",
        f"moves by {column.say(span)}, the model by {column.say(simulated)}:"
        f" {times:.{digits}f} times as {'much' if large else 'little'}, as {units} are",
        way_out,
    )


def _counts(column: Column, times: float) -> bool:
    """Whether an angle moves so many times as the model, in its shape and in whole numbers."""
    numbers = column.read / si_name(column.recording.written(column.name))[1]
    whole = np.allclose(numbers, np.rint(numbers), rtol=0.0, atol=limits.ROUNDING)
    shaped = times > limits.ALL and column.correlation > limits.SAME_SHAPE
    return column.unit == "rad" and whole and shaped


def _sign(column: Column) -> DataWarning | None:
    correlation = column.correlation
    if correlation > -limits.ALIKE_IN_SHAPE:
        return None
    return column.warn(
        "sign",
        f"runs against sensor {column.sensor!r} of the model, correlation {correlation:.2f}",
        f'if the sensor counts the other way, write "{column.sensor}.scale" = -1 in'
        """ [known]; if the motor's encoder does, "<actuator>.command_scale" with the other"""
        " sign; if the tendon pulls the joint the wrong way in the model, change the sign"
        " of its radius there",
    )


def _diameter(column: Column) -> DataWarning | None:
    """Another factor of two of a motion of the same shape."""
    span, simulated = _ranges(column)
    times, about = max(span / simulated, simulated / span), 1.0 + limits.SIMILAR
    if column.unit not in ("rad", "m") or not 2.0 / about < times < 2.0 * about:
        return None
    if column.correlation <= limits.SAME_SHAPE:
        return None
    moves, model = column.say(span), column.say(simulated)
    much = "little" if span > simulated else "much"
    return column.warn(
        "diameter",
        f"moves by {moves}, the model by {model}, {times:.2g} times as {much}, in the same shape",
        "is a radius of the model, or a command_scale, a diameter, or a gear left out? A"
        " cable that stretches more or less than in the model does this too",
    )


def _unlike(column: Column) -> DataWarning | None:
    """A motion, well above noise, that has little in common with the model's."""
    correlation, (span, simulated) = column.correlation, _ranges(column)
    if correlation >= limits.ALIKE_IN_SHAPE or min(span, simulated) < limits.CLEAR * column.noise:
        return None
    return column.warn(
        "unlike",
        f"moves by {column.say(span)} and the model by {column.say(simulated)}, but otherwise:"
        f" correlation {correlation:.2f} with sensor {column.sensor!r}",
        "is it the column of this sensor, and [drive] that of this actuator; are the model's"
        " masses, joints and springs those of the rig? Much play and a late sensor do this too",
    )


def _frozen(column: Column) -> DataWarning | None:
    """Readings that are equal to the last digit for long, while the model moves on.

    Noise never is: of a noisy column, the model has to move on by more than the noise alone.
    """
    recording, read, shown, noise = column.recording, column.read, column.model, column.noise
    starts = np.flatnonzero(np.diff(read, prepend=np.nan, append=np.nan) != 0.0)
    noisy = not recording.quasi_static and is_noisy(read)
    least = limits.RESTS if recording.quasi_static else limits.HELD
    limit = max(0.0 if noisy else limits.PART * float(np.ptp(shown)), limits.SIGMAS * noise)
    worst, place = limit, (0, 0)
    for start, end in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        near = np.abs(shown[start:end]).min() < limits.SIGMAS * noise
        loose = read[start] == 0.0 and column.unit == "N" and near
        if end - start >= least and not loose and np.ptp(shown[start:end]) > worst:
            worst, place = float(np.ptp(shown[start:end])), (start, end)
    start, end = place
    if start == end:
        return None
    return column.warn(
        "frozen",
        f"reads {column.say(read[start])} from row {recording.row(start)} to"
        f" {recording.row(end - 1)}, {recording.time[end - 1] - recording.time[start]:.3g}"
        f" s, in which the model moves by {column.say(worst)}",
        "if the sensor or its bus hung there, leave these rows out",
        blocks=noisy,
    )


def _start(column: Column) -> DataWarning | None:
    first, model = (float(np.median(s[: limits.SHORT])) for s in (column.read, column.model))
    noise = column.stated_noise or 0.0
    if abs(first - model) <= max(limits.SIMILAR * usual_range(column.read), limits.SIGMAS * noise):
        return None
    cause = "the model's reference pose may be another than the rig's"
    if column.unit == "N":
        fitted = any(name.endswith(".pretension") for name in column.recording.uncertain)
        tells = ", which a fit tells" if fitted else ": give its range in [uncertain]"
        cause = f"the pretension may be another{tells}"
        span, simulated = _ranges(column)
        pairs = (first * scipy.constants.g, model), (span * scipy.constants.g, simulated)
        if all(y / limits.DEGREES < x < y * limits.DEGREES for x, y in pairs):
            cause = (
                "it may be in kilograms-force, since it also moves"
                f" {simulated / span:.1f} times less than the model: name it with _kgf; or {cause}"
            )
    drives = [c for c in columns_of(column.recording) if c.driven]
    moving = any(map(_moves_first, drives))
    moved = (
        f"the {'drive moves from the first row on' if moving else 'rig had moved before'}, and"
        " friction remembers earlier motion: record half a second of rest before it, or let the"
        " table begin at an outer turn of a whole stroke"
    )
    zero = f"""the sensor's zero: write "{column.sensor}.offset" in [known] or [uncertain]"""
    causes = [*filter(None, map(_drive_zero, drives)), cause, zero]
    causes.insert(0 if moving else len(causes), moved)
    return column.warn(
        "start",
        f"starts at {column.say(first)}, the model at {column.say(model)}",
        "; or ".join(causes),
    )


def _moves_first(drive: Column) -> bool:
    """Whether a drive goes on in the first samples by a part of what it does in as many others."""
    usual = float(np.percentile(np.abs(np.diff(drive.read)), limits.OFTEN))
    return float(np.ptp(drive.read[: limits.SHORT])) > limits.PART * (limits.SHORT - 1) * usual


def _drive_zero(drive: Column) -> str:
    """What to write where the drive's zero may not be that of the model; empty where it is."""
    first, written = float(drive.read[0]), drive.recording.written(drive.name)
    away = abs(first) > limits.SIMILAR * usual_range(drive.read)
    if drive.unit not in ("rad", "m") or not away:
        return ""
    offset = first / si_name(written)[1]
    return (
        f"the drive {written!r} begins at {drive.say(first)}, and the model's reference pose is at"
        f" 0: if that was where the rig stood, lower its offset in [columns] by {offset:.6g}; where"
        f' it has no entry there, write {written} = {{ column = "{written}", offset ='
        f" {-offset:.6g} }}"
    )


def below_zero_warnings(
    recording: Recording, simulated: Recording, adjustable: Adjustable
) -> Iterator[DataWarning]:
    """Warn of tensions of a cable that are measured below 0, where a cable cannot push."""
    fitted = expand({**recording.uncertain, **recording.session}, adjustable.names())
    for column in columns_of(recording, simulated):
        if column.driven or f"{column.sensor}.offset" in fitted:
            continue
        sensor = adjustable.model.sensor(column.sensor).id
        scale, offset = adjustable.readings[sensor, :2].tolist()
        tension, shown = (np.sign(scale) * (s - offset) for s in (column.read, column.model))
        below = (tension < -limits.SIGMAS * column.noise) & (shown > -column.noise)
        cable = sensor_kind(adjustable.model, sensor).endswith("tension")
        if not cable or below.mean() <= limits.OUTER:  # noise is there in 0.1 % of samples
            continue
        worst = int(np.argmin(np.where(below, tension, np.inf)))
        yield column.warn(
            "below_zero",
            f"reads {column.say(column.read[worst])} in {column.row(worst)}, and"
            f" {int(below.sum())} samples below 0 from row"
            f" {recording.row(int(np.argmax(below)))} on, where a cable cannot push",
            "the load cell's zero was set under load, or has shifted: set it with the cable"
            f' off, or write "{column.sensor}.offset" in [known] or [uncertain]',
            blocks=True,
        )
