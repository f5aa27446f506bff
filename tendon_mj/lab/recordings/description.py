"""The meaning of a recording: its model, and what each column and parameter is there."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, unknown
from tendon_mj.lab.recordings.magnitude import size_fault
from tendon_mj.lab.recordings.table_checks import TIMES
from tendon_mj.lab.recordings.units import si_name, unit_factors
from tendon_mj.typing import FloatArray

_OVER = 1.01  # of its period, that a counter with noise covers at most
_LEAST_SPREAD = 1e-12  # of the value that it is about


@dataclass(frozen=True)
class Measured:
    """A column is what ``sensor`` reads; ``noise``, its standard deviation [the column's unit].

    Raises `InvalidValueError` for an empty sensor name, and a noise that is not positive or beyond
    the sizes of `size_fault`.
    """

    sensor: str
    noise: float | None = None

    def __post_init__(self) -> None:
        if not self.sensor.strip():
            raise InvalidValueError(f"sensor must be a name, got {self.sensor!r}")
        if self.noise is not None and not 0 < self.noise < math.inf:
            raise InvalidValueError(f"noise must be > 0 and finite, got {self.noise!r}")
        _check_sizes(noise=self.noise or 0.0)


@dataclass(frozen=True)
class Uncertain:
    """A parameter's best guess and the range it may lie in [the parameter's own SI unit].

    ``each``: where the name stands for several parameters, whether each has a value of its own.

    Raises `InvalidValueError` unless low ≤ value ≤ high, all of a size as `size_fault` has it.
    """

    value: float
    low: float
    high: float
    each: bool = False

    def __post_init__(self) -> None:
        if not -math.inf < self.low <= self.value <= self.high < math.inf:
            raise InvalidValueError(
                f"low ≤ value ≤ high must hold, all finite, got"
                f" {self.low!r} ≤ {self.value!r} ≤ {self.high!r}"
            )
        _check_sizes(value=self.value, low=self.low, high=self.high)


@dataclass(frozen=True)
class Session:
    """A parameter that was set anew for each recording: its mean and its standard deviation.

    Both in the parameter's own SI unit. Raises `InvalidValueError` unless both are of a size as
    `size_fault` has it, and the spread is positive and not below 1e-12 of the value.
    """

    value: float
    spread: float

    def __post_init__(self) -> None:
        if not math.isfinite(self.value):
            raise InvalidValueError(f"value must be finite, got {self.value!r}")
        if not 0.0 < self.spread < math.inf:
            raise InvalidValueError(f"spread must be > 0 and finite, got {self.spread!r}")
        _check_sizes(value=self.value, spread=self.spread)
        if self.spread < _LEAST_SPREAD * abs(self.value):
            raise InvalidValueError(
                f"spread = {self.spread!r} is less than a number beside value = {self.value!r} can"
                f" differ by; give at least {_LEAST_SPREAD * abs(self.value):g}, or put the value"
                " into [known]"
            )


_ENTRIES: dict[str, type | tuple[type, ...]] = {
    "measured": Measured,
    "known": (int, float, np.number),
    "uncertain": Uncertain,
    "session": Session,
}


@dataclass(frozen=True)
class Source:
    """Where a column's values are in a file, and how they are read.

        value = factor × number + offset   [unit]

    column: of a table; dots lead into lists and objects of Parquet, as in ``position.0``;
    topic, field: of a log; dots lead into its messages;
    unit: without its underscore; empty: the one in which the column's name ends;
    period: number after which a counter begins again, by which its jumps are undone; 0: none.
    """

    column: str = ""
    topic: str = ""
    field: str = ""
    factor: float = 1.0
    offset: float = 0.0
    unit: str = ""
    period: float = 0.0

    def converted(self, numbers: FloatArray, column: str) -> FloatArray:
        """Numbers of the file in the unit in which the name of a column ends."""
        if self.period:
            numbers = np.unwrap(numbers, period=self.period)
        if self.factor != 1.0 or self.offset:
            numbers = self.factor * numbers + self.offset
        return numbers * self.ratio(column) if self.unit else numbers

    def period_fault(self, numbers: FloatArray) -> str:
        """That numbers of the file are further apart than their period; empty if not."""
        if not (self.period and numbers.size) or np.ptp(numbers) <= _OVER * self.period:
            return ""
        return (
            f"goes from {numbers.min():.6g} to {numbers.max():.6g}, further than period ="
            f" {self.period:g}; give the number after which the counter begins again, or leave"
            " period out"
        )

    def ratio(self, column: str) -> float:
        """The unit over that in which the name of a column ends."""
        return unit_factors()[f"_{self.unit}"][1] / si_name(column)[1] if self.unit else 1.0


@dataclass(frozen=True)
class Layout:
    """Where the columns of a recording are in its file.

    columns: [columns] of the description; topics: the same of a log, where they may be called
    [mcap]; header: names of the columns of a table that has none.
    """

    columns: Mapping[str, Source] = field(default_factory=dict)
    topics: Mapping[str, Source] = field(default_factory=dict)
    header: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Description:
    """Description of a time series: the TOML beside the CSV.

    model: folder of models/, or path of an MJCF file; source: where the numbers come from;
    drive: column → actuator or joint that it prescribes, or several (see `driven`);
    measured: column → the sensor that read it;
    known: parameter → value, never fitted [SI]; uncertain: parameter → range to fit within [SI];
    session: parameter → mean and spread of what was set anew for each recording [SI];
    hold: driven columns that keep their value until the next sample; else linear between samples;
    settle: time before the first sample [s], in which a replay brings the model to the first drive
    value; 0: the model starts in its reference pose, as it must where a force drives what is free;
    settling_time: of rows that are rests, the time from the end of the move to the reading [s];
    None: rows are samples of a motion.
    A parameter is named ``<element>.<parameter>``; `*`, `?` and `[…]` stand for several elements.
    """

    model: str
    source: str
    drive: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)
    measured: Mapping[str, Measured] = field(default_factory=dict)
    known: Mapping[str, float] = field(default_factory=dict)
    uncertain: Mapping[str, Uncertain] = field(default_factory=dict)
    session: Mapping[str, Session] = field(default_factory=dict)
    hold: tuple[str, ...] = ()
    settle: float = 0.5
    settling_time: float | None = None

    @property
    def quasi_static(self) -> bool:
        """Whether each row was read at rest, after a move from the rest before."""
        return self.settling_time is not None

    @property
    def driven(self) -> list[tuple[str, str]]:
        """Driven column and each actuator or joint that it prescribes."""
        return [
            (column, name)
            for column, names in self.drive.items()
            for name in ((names,) if isinstance(names, str) else names)
        ]

    def check(self, columns: Collection[str], where: str) -> None:
        """Raise `RecordingError`, beginning with ``where``, unless it fits the CSV's ``columns``.

        Refused: empty or unwritable texts, unknown columns, a column both driven and measured,
        an actuator driven twice, parameters misnamed, infinite, of a size that `size_fault`
        refuses, or in two of the tables.
        """
        for key, text in (("model", self.model), ("source", self.source)):
            check_text(text, f"{where}, {key}")
        if not 0.0 <= self.settle < math.inf:
            raise RecordingError(f"{where}, settle: {self.settle!r} [s] must be ≥ 0 and finite")
        if self.settling_time is not None and not 0.0 < self.settling_time < math.inf:
            raise RecordingError(
                f"{where}, [timing] settling_time: {self.settling_time!r} [s] must be > 0 and"
                " finite"
            )
        for table, kind in _ENTRIES.items():
            for name, entry in getattr(self, table).items():
                if not isinstance(entry, kind):
                    raise RecordingError(f"{where}, [{table}] {name!r}: cannot be {entry!r}")
        series = [name for name in columns if name not in TIMES]
        for table in ("drive", "measured"):
            for column in getattr(self, table):
                here = f"{where}, [{table}] {column!r}"
                if column in TIMES:
                    raise RecordingError(f"{here}: the clock is neither driven nor measured")
                if column not in series:
                    raise RecordingError(f"{here}: {unknown('column', column, series)}")
        driven: dict[str, str] = {}
        for column, names in self.drive.items():
            if not names:
                raise RecordingError(f"{where}, [drive] {column!r}: must not be empty")
        for column, actuator in self.driven:
            here = f"{where}, [drive] {column!r}"
            check_text(actuator, here)
            if actuator in driven:
                raise RecordingError(f"{here}: {driven[actuator]!r} already drives {actuator!r}")
            driven[actuator] = column
        for column in self.hold:
            if column not in self.drive:
                raise RecordingError(
                    f"{where}, hold: {unknown('driven column', column, self.drive)}"
                )
        for column, measured in self.measured.items():
            here = f"{where}, [measured] {column!r}"
            check_text(measured.sensor, here)
            if column in self.drive:
                raise RecordingError(f"{here}: is in [drive] too; a column is one or the other")
        for name, value in self.known.items():
            here = f"{where}, [known] {name!r}"
            _check_parameter(name, here)
            if not math.isfinite(value):
                raise RecordingError(f"{here}: {value!r} is not finite")
            if fault := size_fault(value):
                raise RecordingError(f"{here}: {fault}")
        for table, others in (("uncertain", ("known",)), ("session", ("known", "uncertain"))):
            for name in getattr(self, table):
                here = f"{where}, [{table}] {name!r}"
                _check_parameter(name, here)
                for other in others:
                    if name in getattr(self, other):
                        raise RecordingError(
                            f"{here}: is in [{other}] too; a parameter is one or the other"
                        )


def check_text(text: str, here: str) -> None:
    """Refuse a text that is empty, or that no file can hold.

    Raises:
        RecordingError: it begins with ``here``.
    """
    if not text.strip():
        raise RecordingError(f"{here}: must not be empty, got {text!r}")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise RecordingError(f"{here}: {text!r} cannot be written as UTF-8") from None


def _check_sizes(**numbers: float) -> None:
    for name, number in numbers.items():
        if fault := size_fault(number):
            raise InvalidValueError(f"{name}: {fault}")


def _check_parameter(name: str, here: str) -> None:
    check_text(name, here)
    parts = name.split(".")
    if len(parts) < 2 or not all(part.strip() for part in parts):
        raise RecordingError(
            f"{here}: a parameter is named '<element>.<parameter>', such as 'sheath.friction'"
        )
