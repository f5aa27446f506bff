"""Bounds of a rig, and the experiments within them as templates of recordings.

A driven column moves between two levels at one speed, from the first value of the recordings, and
rests at its turns: ramps, stairs, growing reversals, sines and sweeps. Every number is rounded, so
that it can be written down and set on a rig.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import cycle
from pathlib import Path

import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, TendonError, UnknownNameError
from tendon_mj.lab.diagnosis import MakeSimulator
from tendon_mj.lab.parameter_names import expand
from tendon_mj.lab.recordings import (
    Measured,
    Recording,
    check_keys,
    read_description,
    read_entries,
    read_number,
    read_text,
    read_toml,
)
from tendon_mj.lab.replay import Simulator
from tendon_mj.lab.units import (
    ANY_NUMBER,
    NOT_NEGATIVE,
    POSITIVE_NUMBER,
    column_unit,
    si_name,
    unit_fault,
)
from tendon_mj.lab.units import rate as per_second
from tendon_mj.typing import FloatArray

Interval = tuple[float, float]

_SOURCE = "suggested by tendon-mj and not recorded yet: measured columns are to be filled in"
SHAPES = ("ramps", "stairs", "growing", "sine", "sweep")
NUMBERS = 5  # that describe a motion within its bounds: shape, span, place, speed, rest
_SMALLEST_SPAN = 0.1  # of the range
_MOVING = 0.5  # of a recording, at least: rests take no more than the other half
_WAYS = 4.0  # from the start and then between the levels, in that time
_CYCLES = 0.5 * (_WAYS - 1.0)  # at least, in a recording
_SAMPLES = 4  # at least, on the way from one level to the other
_NO_DWELL = 0.3  # share of the motions that do not rest
_RESTS = {"ramps": 6.0, "stairs": 12.0, "growing": 12.0}  # all rests of a cycle fit in a recording
_STAIRS, _LOOPS = 4, 4
_RATE = 50.0  # samples per second of a planned recording, the least that a guide advises


@dataclass(frozen=True)
class DriveBounds:
    """Limits of a driven column.

    Attributes:
        low, high: ends of its range [the column's unit].
        rate: highest speed [unit/s].
        dwell: longest rest at a turn [s].

    Raises:
        InvalidValueError: an empty range, a rate that is not positive, or a negative rest.
    """

    low: float
    high: float
    rate: float
    dwell: float = 0.0

    def __post_init__(self) -> None:
        _check_interval("", self.low, self.high)
        POSITIVE_NUMBER.check("rate", self.rate)
        NOT_NEGATIVE.check("dwell", self.dwell, "s")


@dataclass(frozen=True, kw_only=True)
class ExperimentBounds:
    """Limits of a rig in its next recording.

    Attributes:
        drive: driven column → bounds; one that is not named rests where the recordings begin.
        states: parameter → (low, high) between which the user can set it, such as the pretension
            or a bend [SI].
        limits: measured column → (low, high) that no reading may leave [its unit].
        measure: column → sensor that the rig could read too, with its noise. It is suggested
            if no column that was measured before decides.
        duration: of the recording [s]; 0: as long as the longest there is.

    Raises:
        InvalidValueError: nothing is driven, an empty range, a sensor without noise, or a
            negative duration.
    """

    drive: Mapping[str, DriveBounds]
    states: Mapping[str, Interval] = field(default_factory=dict)
    limits: Mapping[str, Interval] = field(default_factory=dict)
    measure: Mapping[str, Measured] = field(default_factory=dict)
    duration: float = 0.0

    def __post_init__(self) -> None:
        if not self.drive:
            raise InvalidValueError("bounds: no column in [drive], so nothing would move")
        for name, span in {**self.states, **self.limits}.items():
            _check_interval(f"{name!r}: ", *span)
        for column, measured in self.measure.items():
            if measured.noise is None:
                raise InvalidValueError(
                    f"bounds, [measure] {column!r}: its noise must be stated, as it cannot be"
                    " estimated before there are readings"
                )
        NOT_NEGATIVE.check("duration", self.duration, "s")

    def check(self, recording: Recording, parameters: Mapping[str, object]) -> None:
        """Refuse bounds of columns and parameters that a rig does not have, or that are fitted."""
        for kind, names, there in (
            ("driven column", self.drive, recording.drive),
            ("measured column", self.limits, {*recording.measured, *self.measure}),
        ):
            for column in names:
                if column not in there:
                    raise UnknownNameError(kind, column, there, "bounds")
        for column in self.measure:
            if column in recording.columns:
                raise InvalidValueError(
                    f"bounds, [measure] {column!r}: the recordings have this column already"
                )
        fitted = expand(recording.uncertain, parameters)
        for name in expand(self.states, parameters):
            if name not in parameters:
                raise UnknownNameError("parameter", name, parameters, "bounds, [states]")
            if name in fitted:
                raise InvalidValueError(
                    f"bounds, [states] {name!r}: is uncertain in the recordings, one value for all;"
                    " a value that is set for each recording is in its [known] or [session]"
                )


def read_bounds(path: str | os.PathLike[str]) -> ExperimentBounds:
    """Read bounds from TOML; those of a column in mm, deg and the like become bounds in SI.

    Raises:
        RecordingError: the file cannot be read, or is not TOML.
        InvalidValueError: unknown keys, a value that is not a number, or as of `ExperimentBounds`.
    """
    where = str(path)
    toml = read_toml(read_text(Path(path)), where)
    try:
        check_keys(toml, [f.name for f in fields(ExperimentBounds)], (), where)
        drive, measure = {}, {}
        for written, of_drive in read_entries(DriveBounds, toml, "drive", where).items():
            column, unit = _in_si(written)
            low, high, rate = (unit * v for v in (of_drive.low, of_drive.high, of_drive.rate))
            drive[column] = DriveBounds(low, high, rate, of_drive.dwell)
        for written, measured in read_entries(Measured, toml, "measure", where).items():
            column, unit = _in_si(written)
            noise = None if measured.noise is None else unit * measured.noise
            measure[column] = replace(measured, noise=noise)
        limits = {}
        for written, interval in read_entries(_Interval, toml, "limits", where).items():
            column, unit = _in_si(written)
            limits[column] = unit * interval.low, unit * interval.high
        states = read_entries(_Interval, toml, "states", where)
        return ExperimentBounds(
            drive=drive,
            states={name: (interval.low, interval.high) for name, interval in states.items()},
            limits=limits,
            measure=measure,
            duration=read_number(toml.get("duration", 0.0), f"{where}, duration"),
        )
    except RecordingError as error:
        raise InvalidValueError(str(error)) from None


def _in_si(column: str) -> tuple[str, float]:
    """A column's name in SI and the factor that converts it; itself if it ends in no unit."""
    return (column, 1.0) if unit_fault(column, si=False) else si_name(column)


@dataclass(frozen=True)
class _Interval:
    low: float
    high: float

    def __post_init__(self) -> None:
        _check_interval("", self.low, self.high)


def _check_interval(where: str, low: float, high: float) -> None:
    for name, end in (("low", low), ("high", high)):
        ANY_NUMBER.check(f"{where}{name}", end)
    if low >= high:
        raise InvalidValueError(f"{where}low < high must hold, got {low!r}, {high!r}")


@dataclass(frozen=True)
class _ColumnMotion:
    shape: str  # one of SHAPES
    start: float  # where it begins [the column's unit]
    # levels between which it goes [unit]
    low: float
    high: float
    rate: float  # highest speed [unit/s]
    dwell: float = 0.0  # rest at each turn [s]

    @property
    def frequency(self) -> float:
        """Frequency of a sine of that amplitude and speed [Hz]."""
        return self.rate / (np.pi * (self.high - self.low))

    def series(self, time: FloatArray) -> FloatArray:
        """(n,) values at ``time`` [s], which begins at 0."""
        _check_interval("motion: ", self.low, self.high)
        begin = abs(self.low - self.start) / self.rate
        if self.shape not in ("sine", "sweep"):
            return self._ramps(time)
        since = np.maximum(0.0, time - begin)
        phase = 2.0 * np.pi * self.frequency * since
        if self.shape == "sweep":
            length = max(float(time[-1]) - begin, 1e-9)
            slow = min(_CYCLES / length, self.frequency)
            growth = np.log(self.frequency / slow) / length
            phase = (
                2.0 * np.pi * slow * (np.expm1(growth * since) / growth if growth > 0.0 else since)
            )
        wave = 0.5 * (self.high + self.low) - 0.5 * (self.high - self.low) * np.cos(phase)
        reach = np.interp(time, [0.0, max(begin, 1e-12)], [self.start, self.low])
        return np.where(time < begin, reach, wave)

    def words(self, unit: str, duration: float) -> str:
        """The motion in words."""
        span = f"between {self.low:g} and {self.high:g} {unit}"
        speed = f"at {self.rate:g} {per_second(unit)}"
        if self.shape == "sine":
            return f"following a sine {span} of {self.frequency:.3g} Hz"
        if self.shape == "sweep":
            slow = _CYCLES / duration
            return f"following a sine {span} that goes from {slow:.2g} to {self.frequency:.3g} Hz"
        rest = f", with {self.dwell:g} s of rest at each turn" if self.dwell > 0.0 else ""
        if self.shape == "stairs":
            return f"going up and down in {_STAIRS} steps {span}, {speed}{rest}"
        if self.shape == "growing":
            return f"going back and forth in {_LOOPS} growing loops {span}, {speed}{rest}"
        return f"going back and forth {span}, {speed}{rest}"

    def _ramps(self, time: FloatArray) -> FloatArray:
        corners, values = [0.0], [self.start]
        for level in cycle(self._levels()):
            way = abs(level - values[-1])
            corners.append(corners[-1] + way / self.rate)
            values.append(level)
            if self.dwell > 0.0:
                corners.append(corners[-1] + self.dwell)
                values.append(level)
            if corners[-1] > time[-1]:
                break
        return np.interp(time, corners, values)

    def _levels(self) -> list[float]:
        """Turning points of one cycle."""
        middle, span = 0.5 * (self.low + self.high), self.high - self.low
        if self.shape == "stairs":
            places = [*range(_STAIRS + 1), *range(_STAIRS - 1, 0, -1)]
            return [self.low + span * k / _STAIRS for k in places]
        if self.shape == "growing":
            shares = [k / _LOOPS for k in range(1, _LOOPS + 1)]
            return [middle + side * 0.5 * span * s for s in shares for side in (1.0, -1.0)]
        return [self.low, self.high]


def motion_at(
    point: FloatArray, bounds: DriveBounds, start: float, duration: float, interval: float
) -> _ColumnMotion:
    """The motion at a ``point`` (`NUMBERS`,) of the unit cube.

    It begins at ``start`` [the column's unit] and lasts for a ``duration`` [s], with samples in an
    ``interval`` [s].
    """
    shape = SHAPES[min(int(point[0] * len(SHAPES)), len(SHAPES) - 1)]
    whole = bounds.high - bounds.low
    span = whole * (_SMALLEST_SPAN + (1.0 - _SMALLEST_SPAN) * point[1])
    moving = _MOVING * duration
    reach = bounds.rate * moving / _WAYS  # of the start, and of one way from level to level
    span = min(span, reach)
    low = bounds.low + point[2] * (whole - span)
    low = min(max(low, start - reach, bounds.low), start + reach - span, bounds.high - span)
    approach = max(abs(low - start), abs(low + span - start))
    slowest = (approach + (_WAYS - 1.0) * span) / moving
    fastest = max(slowest, min(bounds.rate, span / (_SAMPLES * interval)))
    longest = min(bounds.dwell, duration / _RESTS.get(shape, np.inf))
    dwell = longest * max(0.0, float(point[4]) - _NO_DWELL) / (1.0 - _NO_DWELL)
    rate = float(slowest * (fastest / slowest) ** point[3])
    return _ColumnMotion(
        shape=shape,
        start=start,
        low=max(rounded(low, span), bounds.low),
        high=min(rounded(low + span, span), bounds.high),
        rate=min(rounded(rate, rate), bounds.rate),
        dwell=rounded(dwell, duration) if shape in _RESTS else 0.0,
    )


def rounded(value: float, scale: float) -> float:
    """The number to about a thousandth of ``scale`` > 0."""
    return round(float(value), 2 - math.floor(math.log10(scale)))


@dataclass(frozen=True, eq=False)
class Experiment:
    """An experiment that has not been run."""

    motions: Mapping[str, _ColumnMotion]  # driven column → how it moves
    states: Mapping[str, float]  # parameter → value that is set for it [SI]
    besides: Sequence[str]  # columns that are to be measured for the first time
    recording: Recording  # template; its measured columns are 0

    @property
    def words(self) -> str:
        """The experiment in words."""
        duration = float(self.recording.time[-1])
        moved = " and ".join(
            f"{column.removesuffix('_' + column_unit(column))}"
            f" {motion.words(column_unit(column), duration)}"
            for column, motion in self.motions.items()
        )
        held = ", ".join(f"{name} = {value:g}" for name, value in self.states.items())
        read = " and ".join(c.removesuffix("_" + column_unit(c)) for c in self.besides)
        return (
            f"{duration:.3g} s of {moved}{f', with {held}' if held else ''}"
            f"{f', and measure {read} too' if read else ''}"
        )


@dataclass(frozen=True, eq=False)
class Family:
    """All experiments within bounds, as points of a unit cube."""

    # that there are; of the first is all that an experiment does not change
    recordings: Sequence[Recording]
    bounds: ExperimentBounds  # of the rig
    besides: bool = False  # whether the further sensors of the bounds are read

    @property
    def dimensions(self) -> int:
        """Of the cube: five for each driven column, and one for each state."""
        return NUMBERS * len(self.bounds.drive) + len(self.bounds.states)

    @property
    def shapes(self) -> list[int]:
        """Dimensions that choose the shape of a motion."""
        return [NUMBERS * k for k in range(len(self.bounds.drive))]

    def at(self, point: FloatArray, name: str) -> Experiment:
        """The experiment at a point (dimensions,) of the cube."""
        first = self.recordings[0]
        interval = float(np.median(np.diff(first.time)))
        longest = max(float(r.time[-1] - r.time[0]) for r in self.recordings)
        duration = self.bounds.duration or longest
        time = np.round(np.arange(round(duration / interval) + 1) * interval, 9)
        begins = {column: float(first.columns[column][0]) for column in first.drive}
        motions, columns = {}, {}
        for k, (column, bounds) in enumerate(self.bounds.drive.items()):
            part = point[NUMBERS * k : NUMBERS * (k + 1)]
            start = float(np.clip(begins[column], bounds.low, bounds.high))
            motions[column] = motion_at(part, bounds, start, duration, interval)
        for column, start in begins.items():
            motion = motions.get(column)
            still = np.full(time.size, start)
            columns[column] = still if motion is None else motion.series(time)
        besides = self.bounds.measure if self.besides else {}
        measured = {**first.measured, **besides}
        columns |= {column: np.zeros(time.size) for column in measured}
        shares = point[NUMBERS * len(motions) :]
        states = {
            name: float(np.clip(rounded(low + share * (high - low), high - low), low, high))
            for share, (name, (low, high)) in zip(shares, self.bounds.states.items(), strict=True)
        }
        session = {
            n: replace(first.session[n], value=v) for n, v in states.items() if n in first.session
        }
        known = {n: v for n, v in states.items() if n not in session}
        recording = Recording(
            name=name,
            model=first.model,
            source=_SOURCE,
            time=time,
            columns=columns,
            drive=first.drive,
            measured=measured,
            known={**first.known, **known},
            uncertain=first.uncertain,
            session={**first.session, **session},
            hold=first.hold,
            settle=first.settle,
            settling_time=first.settling_time,
        )
        return Experiment(motions, states, tuple(besides), recording)


def planned_recording(
    description: Path, bounds: ExperimentBounds, model: str | None = None
) -> Recording:
    """A recording of a described rig that goes in growing loops up to its bounds, as a template.

    It begins at 0, or the nearest value within the bounds, and rests at its turns as long as these
    allow. ``model`` is in place of the description's own.

    Raises:
        InvalidValueError: bounds without a duration, or of a column that is not driven.
    """
    as_written = read_description(description)
    described = as_written.in_si(str(description))
    if not bounds.duration:
        raise InvalidValueError("bounds: duration is missing; state how long to record [s]")
    time = np.arange(round(bounds.duration * _RATE) + 1) / _RATE
    columns = {c: np.zeros(time.size) for c in (*described.drive, *described.measured)}
    values = vars(described) | ({"model": model} if model else {})
    still = Recording(name=description.stem, time=time, columns=columns, **values)
    bounds.check(still, Simulator([still]).parameters)
    family = Family((still,), bounds, besides=True)
    point = np.full(family.dimensions, 0.5)
    for k in family.shapes:  # shape, span, place, speed, rest
        point[k : k + NUMBERS] = (SHAPES.index("growing") + 0.5) / len(SHAPES), 1.0, 0.5, 1.0, 1.0
    in_file = {si_name(c)[0]: c for c in (*as_written.drive, *as_written.measured)}
    return replace(family.at(point, description.stem).recording, in_file=in_file)


def check_bounds(
    recordings: Sequence[Recording], bounds: ExperimentBounds, simulator: MakeSimulator = Simulator
) -> None:
    """Refuse bounds within which no experiment can be simulated."""
    bounds.check(recordings[0], simulator(recordings).parameters)
    family = Family(recordings, bounds, besides=bool(bounds.measure))
    try:
        for share in (0.0, 0.5, 1.0):
            simulator([family.at(np.full(family.dimensions, share), "checked").recording])
    except TendonError as error:
        raise InvalidValueError(f"bounds: {error}") from None
