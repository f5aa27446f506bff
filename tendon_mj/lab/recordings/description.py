"""The description of a recording: its model, the meaning of each column and parameter; its TOML."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, asdict, dataclass, field, fields, replace
from typing import Any, TypeVar

import numpy as np
import tomli_w

from tendon_mj.errors import InvalidValueError, RecordingError, unknown
from tendon_mj.lab.recordings.files import read_toml
from tendon_mj.lab.units import (
    ANY_NUMBER,
    NOT_NEGATIVE,
    POSITIVE_NUMBER,
    TIMES,
    UNIT_FACTORS,
    NumberRange,
    claimed_unit,
    name_fault,
    si_name,
)
from tendon_mj.typing import FloatArray

_TABLES = ("drive", "measured", "known", "uncertain", "session")
KEYS = ("model", "source", "settle", "timing", "period", "header", *_TABLES, "columns")

UNSAID = "unit?"  # in [columns], for a unit that neither a file nor its user has said
_OVER = 1.01  # of its period, that a counter with noise covers at most
_LEAST_SPREAD = 1e-12  # of the value that it is about
_SETTLING_TIME = 10.0  # [s] of rests if none is stated; a model that rests earlier is read then
_UNQUOTED = 'a name that has a dot is quoted, such as "sheath.friction" = …'
_Entry = TypeVar("_Entry")


@dataclass(frozen=True)
class Measured:
    """A column is the reading of ``sensor``, with a standard deviation ``noise`` [its unit].

    Raises `InvalidValueError` for an empty sensor name, and a noise outside 1e-30 … 1e30.
    """

    sensor: str
    noise: float | None = None

    def __post_init__(self) -> None:
        if not self.sensor.strip():
            raise InvalidValueError(f"sensor must be a name, got {self.sensor!r}")
        if self.noise is not None:
            POSITIVE_NUMBER.check("noise", self.noise)


@dataclass(frozen=True)
class Uncertain:
    """A parameter's best guess and the range it may lie in [the parameter's own SI unit].

    ``each``: where the name stands for several parameters, whether each has a value of its own.

    Raises `InvalidValueError` unless low ≤ value ≤ high, all 0 or within 1e-30 … 1e30 in size.
    """

    value: float
    low: float
    high: float
    each: bool = False

    def __post_init__(self) -> None:
        for name in ("value", "low", "high"):
            ANY_NUMBER.check(name, getattr(self, name))
        if not self.low <= self.value <= self.high:
            raise InvalidValueError(
                f"low ≤ value ≤ high must hold, got {self.low!r} ≤ {self.value!r} ≤ {self.high!r}"
            )


@dataclass(frozen=True)
class Session:
    """A parameter that is set for each recording: its mean and its standard deviation.

    Both in the parameter's own SI unit. Raises `InvalidValueError` unless the value is 0 or within
    1e-30 … 1e30 in size, and the spread is positive and not below 1e-12 of the value.
    """

    value: float
    spread: float

    def __post_init__(self) -> None:
        ANY_NUMBER.check("value", self.value)
        POSITIVE_NUMBER.check("spread", self.spread)
        if self.spread < _LEAST_SPREAD * abs(self.value):
            raise InvalidValueError(
                f"spread = {self.spread!r} is smaller than the rounding error of value ="
                f" {self.value!r}; give at least {_LEAST_SPREAD * abs(self.value):g}, or put the"
                " value into [known]"
            )


@dataclass(frozen=True)
class _Drive:
    """Entry of [drive]: actuators or joints, and whether they keep their value between samples."""

    actuator: str | tuple[str, ...]
    hold: bool = False


@dataclass(frozen=True)
class _Timing:
    """Entry [timing]: whether rows are rests, and the time from the end of the move to them [s]."""

    quasi_static: bool = False
    settling_time: float | None = None

    def __post_init__(self) -> None:
        if self.settling_time is not None and not self.quasi_static:
            raise InvalidValueError("settling_time is of rests; write quasi_static = true too")
        if self.quasi_static and self.settling_time is None:
            object.__setattr__(self, "settling_time", _SETTLING_TIME)


@dataclass(frozen=True)
class Source:
    """Place of a column's values in a file, and their conversion.

    value = factor × number + offset [unit]; dots lead into lists and objects: ``position.0``.
    """

    column: str = ""  # of a table
    topic: str = ""  # of a log
    field: str = ""  # of its messages
    factor: float = 1.0
    offset: float = 0.0
    unit: str = ""  # without its underscore; empty: the one in which the column's name ends
    period: float = 0.0  # after which a counter begins again; its jumps are undone; 0: none

    def __post_init__(self) -> None:
        NumberRange(zero=False).check("factor", self.factor)
        ANY_NUMBER.check("offset", self.offset)
        NOT_NEGATIVE.check("period", self.period)

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
        return UNIT_FACTORS[f"_{self.unit}"][1] / si_name(column)[1] if self.unit else 1.0


@dataclass(frozen=True)
class TableLayout:
    """Places of the columns of a recording in its file."""

    columns: Mapping[str, Source] = field(default_factory=dict)  # [columns]
    header: tuple[str, ...] = ()  # names of the columns of a table that has none
    period: float = 0.0  # between rows of a table that has no clock [s]
    settled: bool = False  # whether rows are rests, of which none can be left out


@dataclass(frozen=True, kw_only=True)
class Description:
    """Description of a time series: the TOML beside the CSV.

    model: folder of models/, or path of an MJCF file; source: origin of the numbers;
    drive: column → actuator or joint that it prescribes, or several (see `driven`);
    measured: column → the sensor that read it;
    known: parameter → value, never fitted [SI]; uncertain: parameter → range to fit within [SI];
    session: parameter → mean and spread of a value that is set for each recording [SI];
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
        """Raise `RecordingError`, beginning with ``where``, unless it fits the table's ``columns``.

        Refused: empty texts, unknown columns, a column both driven and measured, an actuator driven
        twice, parameters misnamed, out of range, or in two of the tables.
        """
        _check_text(self.model, f"{where}, model")
        _check_text(self.source, f"{where}, source")
        faults = [NOT_NEGATIVE.fault("settle", self.settle, "s")]
        if self.settling_time is not None:
            faults.append(POSITIVE_NUMBER.fault("[timing] settling_time", self.settling_time, "s"))
        for fault in filter(None, faults):
            raise RecordingError(f"{where}, {fault}")
        for table, kind in (("measured", Measured), ("uncertain", Uncertain), ("session", Session)):
            for name, entry in getattr(self, table).items():
                if not isinstance(entry, kind):
                    raise RecordingError(f"{where}, [{table}] {name!r}: cannot be {entry!r}")
        self._check_actuators(where)
        self._check_columns(columns, where)
        self._check_parameters(where)

    def _check_actuators(self, where: str) -> None:
        driven: dict[str, str] = {}
        for column, names in self.drive.items():
            here = f"{where}, [drive] {column!r}"
            for actuator in (names,) if isinstance(names, str) else names or ("",):
                _check_text(actuator, here)
                if other := driven.get(actuator):
                    raise RecordingError(f"{here}: {other!r} already drives {actuator!r}")
                driven[actuator] = column

    def _check_columns(self, columns: Collection[str], where: str) -> None:
        series = [name for name in columns if name not in TIMES]
        for table in ("drive", "measured"):
            for column in getattr(self, table):
                fault = "" if column in series else unknown("column", column, series)
                if column in TIMES:
                    fault = "the clock is neither driven nor measured"
                elif table == "measured" and column in self.drive:
                    fault = "is also in [drive]; list it in one table only"
                if fault:
                    raise RecordingError(f"{where}, [{table}] {column!r}: {fault}")
        for column in self.hold:
            if column not in self.drive:
                fault = unknown("driven column", column, self.drive)
                raise RecordingError(f"{where}, hold: {fault}")

    def _check_parameters(self, where: str) -> None:
        tables: dict[str, str] = {}
        for table in ("known", "uncertain", "session"):
            for name, entry in getattr(self, table).items():
                here = f"{where}, [{table}] {name!r}"
                parts = name.split(".")
                if len(parts) < 2 or not all(map(str.strip, parts)):
                    raise RecordingError(
                        f"{here}: a parameter is named '<element>.<parameter>', such as"
                        " 'sheath.friction'"
                    )
                if name in tables:
                    raise RecordingError(
                        f"{here}: is also in [{tables[name]}]; list it in one table only"
                    )
                tables[name] = table
                if table == "known" and (fault := ANY_NUMBER.fault(repr(name), entry)):
                    raise RecordingError(f"{where}, [known] {fault}")

    def in_si(self, where: str) -> Description:
        """The description of the same columns in SI; messages begin with ``where``."""
        measured = {}
        for column, entry in self.measured.items():
            name, factor = si_name(column)
            noise = None if entry.noise is None else entry.noise * factor
            try:
                measured[name] = Measured(entry.sensor, noise)
            except InvalidValueError as error:
                raise RecordingError(f"{where}, [measured] {column!r}, in SI: {error}") from None
        return replace(
            self,
            drive={si_name(column)[0]: actuator for column, actuator in self.drive.items()},
            measured=measured,
            hold=tuple(si_name(column)[0] for column in self.hold),
        )


def parse_toml(text: str, where: str) -> tuple[Description, TableLayout]:
    """A description in TOML, and its places of columns; messages begin with ``where``, the file."""
    toml = read_toml(text, where)
    check_keys(toml, KEYS, ("model", "source"), where)
    drive = {
        name: read_entry(_Drive, e if isinstance(e, dict) else {"actuator": e}, here)
        for name, (e, here) in _table(toml, "drive", where).items()
    }
    timing = read_entry(_Timing, toml.get("timing", {}), f"{where}, [timing]")
    description = Description(
        model=_text(toml["model"], f"{where}, model"),
        source=_text(toml["source"], f"{where}, source"),
        settle=read_number(toml.get("settle", Description.settle), f"{where}, settle"),
        settling_time=timing.settling_time,
        drive={name: entry.actuator for name, entry in drive.items()},
        measured=read_entries(Measured, toml, "measured", where),
        known={name: read_number(*entry) for name, entry in _table(toml, "known", where).items()},
        uncertain=read_entries(Uncertain, toml, "uncertain", where),
        session=read_entries(Session, toml, "session", where),
        hold=tuple(name for name, entry in drive.items() if entry.hold),
    )
    header = toml.get("header", [])
    if not isinstance(header, list):
        raise RecordingError(f"{where}, header: must be a list of names, got {header!r}")
    columns = {
        name: _source(name, *entry) for name, entry in _table(toml, "columns", where).items()
    }
    names = tuple(_text(name, f"{where}, header") for name in header)
    period = read_number(toml.get("period", 0.0), f"{where}, period")
    if fault := NOT_NEGATIVE.fault("period", period, "s"):
        raise RecordingError(f"{where}, {fault}")
    return description, TableLayout(columns, names, period, description.quasi_static)


def format_description(description: Description, model: str) -> str:
    """Write a description, of that model, as TOML that reads back bit for bit."""
    drive: dict[str, Any] = {
        column: names if isinstance(names, str) else list(names)
        for column, names in description.drive.items()
    }
    if description.hold:  # all as tables, as TOML would put the others before them
        drive = {
            column: {"actuator": names, "hold": column in description.hold}
            for column, names in drive.items()
        }
    document: dict[str, Any] = {"model": model, "source": description.source}
    if description.settle != Description.settle:
        document["settle"] = float(description.settle)
    if description.settling_time is not None:
        settling = float(description.settling_time)
        document["timing"] = {"quasi_static": True, "settling_time": settling}
    tables: dict[str, dict[str, Any]] = {
        "drive": drive,
        "measured": {column: _plain(m) for column, m in description.measured.items()},
        "known": {name: float(value) for name, value in description.known.items()},
        "uncertain": {name: _plain(u) for name, u in description.uncertain.items()},
        "session": {name: _plain(s) for name, s in description.session.items()},
    }
    return tomli_w.dumps(document | {title: table for title, table in tables.items() if table})


def _plain(entry: Measured | Uncertain | Session) -> dict[str, Any]:
    """Fields for TOML, without those that are not set."""
    return {
        key: value if isinstance(value, str | bool) else float(value)
        for key, value in asdict(entry).items()
        if value is not None and value is not False
    }


def _source(name: str, entry: Any, here: str) -> Source:
    if fault := name_fault(name):
        raise RecordingError(f"{here}: {fault}")
    if isinstance(entry, str):
        return Source(column=entry)
    if not isinstance(entry, dict):
        raise RecordingError(
            f'{here}: write "<column of the file>", or {{ column = … }}, or {{ topic = …, field ='
            f" … }}, got {entry!r}"
        )
    keys = [f.name for f in fields(Source)]
    needed = ["column"] if "column" in entry else ["topic", "field"]
    if name in TIMES:  # of a log it is its log time
        keys, needed = ["column", "unit", "factor", "period"], ["column"]
    check_keys(entry, keys, needed, here)
    source = read_entry(Source, entry, here)
    if name in TIMES and (fault := POSITIVE_NUMBER.fault("factor", source.factor)):
        raise RecordingError(f"{here}: {fault}")
    if source.unit:
        target = UNIT_FACTORS[claimed_unit(name)][0]
        kin = [u.removeprefix("_") for u, (si, _) in UNIT_FACTORS.items() if si == target]
        if source.unit == UNSAID:
            raise RecordingError(
                f"{here}, unit: say in which unit the numbers of {source.column or source.field!r}"
                f" are, in place of {UNSAID!r}: one of {', '.join(kin)}; counts also need a factor"
            )
        if source.unit not in kin:
            raise RecordingError(f"{here}, unit: {unknown('unit', source.unit, kin)}")
    return source


def read_entry(kind: type[_Entry], entry: Any, here: str) -> _Entry:
    """A dataclass from a TOML table, whose keys are its fields; messages begin with ``here``."""
    known: dict[str, Any] = {f.name: f for f in fields(kind)}  # type: ignore[arg-type]
    needed = [name for name, f in known.items() if f.default is MISSING]
    if not isinstance(entry, dict):
        form = ", ".join(f"{name} = …" for name in needed)
        raise RecordingError(f"{here}: write {{ {form} }}, got {entry!r}")
    if any(isinstance(value, dict) for value in entry.values()):
        raise RecordingError(f"{here}: {_UNQUOTED}")
    check_keys(entry, known, needed, here)
    values = {k: _READERS[known[k].type](value, f"{here}, {k}") for k, value in entry.items()}
    try:
        return kind(**values)
    except InvalidValueError as error:
        raise RecordingError(f"{here}: {error}") from None


def read_entries(
    kind: type[_Entry], toml: Mapping[str, Any], key: str, where: str
) -> dict[str, _Entry]:
    """Name → entry of a table of TOML, each as of `read_entry`; messages begin with ``where``."""
    return {name: read_entry(kind, *entry) for name, entry in _table(toml, key, where).items()}


def _table(toml: Mapping[str, Any], key: str, where: str) -> dict[str, tuple[Any, str]]:
    """Name → entry of a table, and its place for messages."""
    table = toml.get(key, {})
    if not isinstance(table, dict):
        raise RecordingError(f"{where}, {key}: must be a table [{key}], got {table!r}")
    return {name: (entry, f"{where}, [{key}] {name!r}") for name, entry in table.items()}


def check_keys(
    entry: Mapping[str, Any], valid: Collection[str], needed: Iterable[str], here: str
) -> None:
    """Raise `RecordingError` for an unknown key, naming the nearest, and for a missing one."""
    for key in entry:
        if key not in valid:
            raise RecordingError(f"{here}: {unknown('key', key, valid)}")
    for key in needed:
        if key not in entry:
            raise RecordingError(f"{here}: {key!r} is missing")


def _flag(entry: Any, here: str) -> bool:
    if not isinstance(entry, bool):
        raise RecordingError(f"{here}: must be true or false, got {entry!r}")
    return entry


def read_number(entry: Any, here: str) -> float:
    """A number of TOML; messages begin with ``here``."""
    if isinstance(entry, dict):
        raise RecordingError(f"{here}: {_UNQUOTED}")
    if isinstance(entry, bool) or not isinstance(entry, int | float):
        raise RecordingError(f"{here}: must be a number, got {entry!r}")
    return float(entry)


def _text(entry: Any, here: str) -> str:
    if not isinstance(entry, str):
        raise RecordingError(f"{here}: must be a text in quotes, got {entry!r}")
    return entry


def _names(entry: Any, here: str) -> str | tuple[str, ...]:
    return tuple(_text(e, here) for e in entry) if isinstance(entry, list) else _text(entry, here)


_READERS: dict[str, Callable[[Any, str], Any]] = {
    "str": _text,
    "str | tuple[str, ...]": _names,
    "float": read_number,
    "float | None": read_number,
    "bool": _flag,
}


def _check_text(text: str, here: str) -> None:
    if not text or not text.strip():
        raise RecordingError(f"{here}: must not be empty, got {text!r}")
