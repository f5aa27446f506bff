"""A recording's description as TOML."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import tomli_w

from tendon_mj.errors import InvalidValueError, RecordingError, unknown
from tendon_mj.lab.recordings.description import (
    Description,
    Layout,
    Measured,
    Session,
    Source,
    Uncertain,
)
from tendon_mj.lab.recordings.magnitude import size_fault
from tendon_mj.lab.recordings.table_checks import TIMES, name_fault
from tendon_mj.lab.recordings.toml_text import read_toml
from tendon_mj.lab.recordings.units import claimed_unit, unit_factors

TABLES = ("drive", "measured", "known", "uncertain", "session")
KEYS = ("model", "source", "settle", "timing", "header", *TABLES, "columns", "mcap")

_SETTLING_TIME = 10.0  # [s] of rests where none is stated; a model that rests earlier is read then

_UNQUOTED = 'a name that has a dot is quoted, such as "sheath.friction" = …'


def parse_layout(text: str, where: str) -> Layout:
    """Read a description's [columns], [mcap] and header: where the columns are in the file.

    Raises `RecordingError` for what `read_toml` refuses, and entries that say no place, or a unit
    that is not one of the column's kind.
    """
    toml = read_toml(text, where)
    maps = {}
    for title in ("columns", "mcap"):
        table = toml.get(title, {})
        if not isinstance(table, dict):
            raise RecordingError(f"{where}, {title}: must be a table [{title}], got {table!r}")
        maps[title] = {
            name: _source(name, entry, f"{where}, [{title}] {name!r}")
            for name, entry in table.items()
        }
    header = toml.get("header", [])
    if not isinstance(header, list):
        raise RecordingError(f"{where}, header: must be a list of names, got {header!r}")
    names = tuple(_text(name, f"{where}, header") for name in header)
    return Layout(maps["columns"], maps["mcap"] or maps["columns"], names)


def parse_description(text: str, where: str) -> Description:
    """Read a description from TOML text; messages begin with ``where``, the file.

    Raises `RecordingError` for what `read_toml` refuses, unknown keys (naming the nearest valid
    one), values of the wrong kind, and whatever `Measured` and `Uncertain` refuse.
    """
    toml = read_toml(text, where)
    _check_keys(toml, KEYS, ("model", "source"), where)
    for key in TABLES:
        if not isinstance(toml.setdefault(key, {}), dict):
            raise RecordingError(f"{where}, {key}: must be a table [{key}], got {toml[key]!r}")
    entries = {
        key: {name: (entry, f"{where}, [{key}] {name!r}") for name, entry in toml[key].items()}
        for key in TABLES
    }
    return Description(
        model=_text(toml["model"], f"{where}, model"),
        source=_text(toml["source"], f"{where}, source"),
        settle=_number(toml.get("settle", Description.settle), f"{where}, settle"),
        settling_time=_settling_time(toml.get("timing", {}), f"{where}, [timing]"),
        drive={name: _driven(*entry)[0] for name, entry in entries["drive"].items()},
        measured={name: _measured(*entry) for name, entry in entries["measured"].items()},
        known={name: _number(*entry) for name, entry in entries["known"].items()},
        uncertain={name: _uncertain(*entry) for name, entry in entries["uncertain"].items()},
        session={name: _session(*entry) for name, entry in entries["session"].items()},
        hold=tuple(name for name, entry in entries["drive"].items() if _driven(*entry)[1]),
    )


def format_description(description: Description) -> str:
    """Write a description as TOML text, which `parse_description` reads back bit for bit."""
    measured = {
        column: {"sensor": m.sensor} | ({} if m.noise is None else {"noise": float(m.noise)})
        for column, m in description.measured.items()
    }
    uncertain = {
        name: {"value": float(u.value), "low": float(u.low), "high": float(u.high)}
        | ({"each": True} if u.each else {})
        for name, u in description.uncertain.items()
    }
    session = {
        name: {"value": float(s.value), "spread": float(s.spread)}
        for name, s in description.session.items()
    }
    drive: dict[str, Any] = {
        column: names if isinstance(names, str) else list(names)
        for column, names in description.drive.items()
    }
    if description.hold:  # all as tables: TOML has tables after what is none, in another order
        drive = {
            column: {"actuator": names, "hold": column in description.hold}
            for column, names in drive.items()
        }
    known = {name: float(value) for name, value in description.known.items()}
    document: dict[str, Any] = {"model": description.model, "source": description.source}
    if description.settle != Description.settle:
        document["settle"] = float(description.settle)
    if description.settling_time is not None:
        document["timing"] = {
            "quasi_static": True,
            "settling_time": float(description.settling_time),
        }
    tables = (drive, measured, known, uncertain, session)
    document |= {title: table for title, table in zip(TABLES, tables, strict=True) if table}
    return tomli_w.dumps(document)


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
    texts, numbers = ["column", "topic", "field", "unit"], ["factor", "offset", "period"]
    needed = ["column"] if "column" in entry else ["topic", "field"]
    if name in TIMES:  # of a log it is its log time
        texts, numbers, needed = ["column", "unit"], ["factor"], ["column"]
    _check_keys(entry, (*texts, *numbers), needed, here)
    values: dict[str, Any] = {k: _text(entry[k], f"{here}, {k}") for k in texts if k in entry}
    for key in numbers:
        if key in entry:
            values[key] = number = _number(entry[key], f"{here}, {key}")
            positive = key == "period" or name in TIMES
            if not math.isfinite(number) or size_fault(number):
                raise RecordingError(f"{here}, {key}: {number!r} is out of range")
            if (number == 0.0 and key != "offset") or (number < 0.0 and positive):
                raise RecordingError(f"{here}, {key}: cannot be {number!r}; leave it out for none")
    if "unit" in entry:
        target = unit_factors()[claimed_unit(name)][0]
        kin = [u.removeprefix("_") for u, (si, _) in unit_factors().items() if si == target]
        if entry["unit"] not in kin:
            raise RecordingError(f"{here}, unit: {unknown('unit', entry['unit'], kin)}")
    return Source(**values)


def _settling_time(table: Any, here: str) -> float | None:
    """Settling time of rows that are rests; None where they are samples of a motion."""
    if not isinstance(table, dict):
        raise RecordingError(f"{here}: write [timing] and quasi_static = true, got {table!r}")
    _check_keys(table, ("quasi_static", "settling_time"), (), here)
    if _flag(table.get("quasi_static", False), f"{here} quasi_static"):
        return _number(table.get("settling_time", _SETTLING_TIME), f"{here} settling_time")
    if "settling_time" in table:
        raise RecordingError(f"{here} settling_time: is of rests; write quasi_static = true too")
    return None


def _driven(entry: Any, here: str) -> tuple[str | tuple[str, ...], bool]:
    """Actuators or joints of a driven column, and whether it holds its value between samples."""
    if isinstance(entry, dict):
        _check_keys(entry, ("actuator", "hold"), ("actuator",), here)
        hold = _flag(entry.get("hold", False), f"{here}, hold")
        return _driven(entry["actuator"], here)[0], hold
    if isinstance(entry, list):
        return tuple(_text(name, here) for name in entry), False
    return _text(entry, here), False


def _measured(entry: Any, here: str) -> Measured:
    if not isinstance(entry, dict):
        raise RecordingError(f'{here}: write {{ sensor = "<name>" }}, got {entry!r}')
    _check_keys(entry, ("sensor", "noise"), ("sensor",), here)
    noise = _number(entry["noise"], f"{here}, noise") if "noise" in entry else None
    try:
        return Measured(_text(entry["sensor"], f"{here}, sensor"), noise)
    except InvalidValueError as error:
        raise RecordingError(f"{here}: {error}") from None


def _uncertain(entry: Any, here: str) -> Uncertain:
    keys = ("value", "low", "high")
    if not isinstance(entry, dict):
        raise RecordingError(f"{here}: write {{ value = …, low = …, high = … }}, got {entry!r}")
    if any(isinstance(value, dict) for value in entry.values()):
        raise RecordingError(f"{here}: {_UNQUOTED}")
    _check_keys(entry, (*keys, "each"), keys, here)
    each = _flag(entry.get("each", False), f"{here}, each")
    try:
        value, low, high = (_number(entry[key], f"{here}, {key}") for key in keys)
        return Uncertain(value, low, high, each)
    except InvalidValueError as error:
        raise RecordingError(f"{here}: {error}") from None


def _session(entry: Any, here: str) -> Session:
    keys = ("value", "spread")
    if not isinstance(entry, dict):
        raise RecordingError(f"{here}: write {{ value = …, spread = … }}, got {entry!r}")
    if any(isinstance(value, dict) for value in entry.values()):
        raise RecordingError(f"{here}: {_UNQUOTED}")
    _check_keys(entry, keys, keys, here)
    try:
        return Session(*(_number(entry[key], f"{here}, {key}") for key in keys))
    except InvalidValueError as error:
        raise RecordingError(f"{here}: {error}") from None


def _flag(entry: Any, here: str) -> bool:
    if not isinstance(entry, bool):
        raise RecordingError(f"{here}: must be true or false, got {entry!r}")
    return entry


def _number(entry: Any, here: str) -> float:
    if isinstance(entry, dict):
        raise RecordingError(f"{here}: {_UNQUOTED}")
    if isinstance(entry, bool) or not isinstance(entry, int | float):
        raise RecordingError(f"{here}: must be a number, got {entry!r}")
    try:
        return float(entry)
    except OverflowError:
        raise RecordingError(f"{here}: {str(entry)[:20]}… is too large a number") from None


def _text(entry: Any, here: str) -> str:
    if not isinstance(entry, str):
        raise RecordingError(f"{here}: must be a text in quotes, got {entry!r}")
    return entry


def _check_keys(
    entry: Mapping[str, Any], valid: Collection[str], needed: Iterable[str], here: str
) -> None:
    for key in entry:
        if key not in valid:
            raise RecordingError(f"{here}: {unknown('key', key, valid)}")
    for key in needed:
        if key not in entry:
            raise RecordingError(f"{here}: {key!r} is missing")
