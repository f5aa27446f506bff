"""A recording's description as TOML: parsed by the standard library, written by hand."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from tendon_mj.errors import InvalidValueError, RecordingError, unknown
from tendon_mj.recordings.description import Description, Measured, Uncertain

TABLES = ("drive", "measured", "known", "uncertain")
KEYS = ("model", "source", *TABLES)

_UNQUOTED = 'a name that has a dot is quoted, such as "sheath.friction" = …'
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def parse_description(text: str, where: str) -> Description:
    """Read a description from TOML text; messages begin with ``where``, the file.

    Raises `RecordingError` for broken TOML (naming its row), unknown keys (naming the nearest
    valid one), values of the wrong kind, and whatever `Measured` and `Uncertain` refuse.
    """
    try:
        toml = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also an integer of 5000 digits
        raise RecordingError(f"{where}: not TOML: {error}") from None
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
        drive={name: _text(*entry) for name, entry in entries["drive"].items()},
        measured={name: _measured(*entry) for name, entry in entries["measured"].items()},
        known={name: _number(*entry) for name, entry in entries["known"].items()},
        uncertain={name: _uncertain(*entry) for name, entry in entries["uncertain"].items()},
    )


def format_description(description: Description) -> str:
    """Write a description as TOML text, which `parse_description` reads back bit for bit."""
    measured = {
        column: f"{{ sensor = {_quote(m.sensor)}"
        + (f", noise = {float(m.noise)!r} }}" if m.noise is not None else " }")
        for column, m in description.measured.items()
    }
    uncertain = {
        name: f"{{ value = {float(u.value)!r}, low = {float(u.low)!r}, high = {float(u.high)!r} }}"
        for name, u in description.uncertain.items()
    }
    drive = {column: _quote(actuator) for column, actuator in description.drive.items()}
    known = {name: repr(float(value)) for name, value in description.known.items()}
    lines = [f"model = {_quote(description.model)}", f"source = {_quote(description.source)}"]
    for title, table in zip(TABLES, (drive, measured, known, uncertain), strict=True):
        if table:
            lines += ["", f"[{title}]", *(f"{_key(k)} = {v}" for k, v in table.items())]
    return "\n".join(lines) + "\n"


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
    _check_keys(entry, keys, keys, here)
    try:
        return Uncertain(*(_number(entry[key], f"{here}, {key}") for key in keys))
    except InvalidValueError as error:
        raise RecordingError(f"{here}: {error}") from None


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


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _quote(name)


def _quote(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + re.sub(r"[\x00-\x1f\x7f]", lambda c: f"\\u{ord(c[0]):04x}", escaped) + '"'
