"""A rig of a fleet: the folder of its dated recordings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from pathlib import Path

from tendon_mj.errors import RecordingError
from tendon_mj.recordings.recording import Recording, read_recording

DESCRIPTION = "description.toml"  # of all tables of a rig, or of all rigs
TABLES = (".csv", ".parquet", ".mcap")
_DAY, _TIME = r"(\d{4})[-_]?(\d{2})[-_]?(\d{2})", r"(\d{2})[-_:.hH]?(\d{2})(?:[-_:.mM]?(\d{2}))?"
_DATE = re.compile(rf"(?<!\d){_DAY}(?:[-_T ]?{_TIME})?(?!\d)")
_DATED = "its file or a folder above it is named after the day, as 2026-03-03.csv"


@dataclass(frozen=True)
class Rig:
    """One rig of a fleet.

    Attributes:
        name: of its folder.
        tables: date → file of a recording, in the order of time.
        descriptions: file of a recording → its description; a file without one has it beside it.
    """

    name: str
    tables: Mapping[datetime, Path]
    descriptions: Mapping[Path, Path]

    @cached_property
    def dates(self) -> tuple[datetime, ...]:
        """When each recording was made."""
        return tuple(self.tables)

    @property
    def files(self) -> list[Path]:
        """Every table and description."""
        beside = [p.with_suffix(".toml") for p in self.tables.values()]
        described = {*self.descriptions.values(), *(p for p in beside if p.is_file())}
        return [*self.tables.values(), *sorted(described)]

    def read(self) -> tuple[Recording, ...]:
        """The recordings in the order of time, each named after its date.

        Raises:
            RecordingError: one cannot be read, or has the model of another kind of rig.
        """
        found = [self._read(date) for date in self.tables]
        for path, recording in zip(self.tables.values(), found, strict=True):
            if recording.model != found[0].model:
                raise RecordingError(
                    f"{path}: its model is {recording.model!r}, and that of the rig's first"
                    f" recording {found[0].model!r}; a rig has one model"
                )
        return tuple(found)

    def read_first(self) -> Recording:
        """The first recording."""
        return self._read(self.dates[0])

    def _read(self, date: datetime) -> Recording:
        path = self.tables[date]
        return replace(read_recording(path, self.descriptions.get(path)), name=stamp(date))


def stamp(date: datetime) -> str:
    """A date as a recording's name has it: without a dot, which parameters' names have."""
    return date.strftime("%Y-%m-%d" if date == _midnight(date) else "%Y-%m-%d %H:%M:%S")


def find_rigs(folder: Path, apart: Path | None = None) -> list[Rig]:
    """The rigs of a fleet: each folder in ``folder`` that has recordings, at whatever depth.

    A table's date is that in its file's name, or else in that of the nearest folder above it
    (ISO 8601, with or without separators, with or without a time of day). Its description lies
    beside it, or is the nearest ``description.toml`` from there up to ``folder``.

    Args:
        folder: of the fleet.
        apart: folder in it that is no rig's, such as that of results.

    Raises:
        RecordingError: no rig, a table without a date or description, or two of one date.
    """
    if not folder.is_dir():
        raise RecordingError(f"{folder} is no folder; a fleet is a folder with one for each rig")
    rigs = [
        _rig(inner, folder)
        for inner in sorted(p for p in folder.iterdir() if p.is_dir())
        if not inner.name.startswith(".") and not _holds(inner, apart) and _tables(inner)
    ]
    if not rigs:
        raise RecordingError(
            f"{folder}: no folder in it has recordings ({', '.join(TABLES)}); a fleet has one"
            " folder for each rig, with its recordings in it"
        )
    return rigs


def _holds(folder: Path, other: Path | None) -> bool:
    return other is not None and other.resolve().is_relative_to(folder.resolve())


def _rig(folder: Path, fleet: Path) -> Rig:
    dated: dict[datetime, Path] = {}
    described: dict[Path, Path] = {}
    for path in _tables(folder):
        date = _date_of(path, folder)
        if date in dated:
            raise RecordingError(
                f"{dated[date]} and {path} are of one date, {stamp(date)}; name them with the time"
                " of day too, as 2026-03-03T14-30.csv"
            )
        dated[date] = path
        shared = _shared_description(path, fleet)
        if not path.with_suffix(".toml").is_file():
            if shared is None:
                raise RecordingError(
                    f"{path}: no {path.with_suffix('.toml').name} beside it, and no {DESCRIPTION}"
                    f" there or above it up to {fleet}"
                )
            described[path] = shared
    return Rig(folder.name, dict(sorted(dated.items())), described)


def _tables(folder: Path) -> list[Path]:
    found = (p for p in folder.rglob("*") if p.suffix.lower() in TABLES and p.is_file())
    return sorted(p for p in found if not p.name.startswith("."))


def _date_of(path: Path, rig: Path) -> datetime:
    above = path.relative_to(rig.parent).parts[1:-1]
    for name in (path.stem, *reversed(above)):
        for match in _DATE.finditer(name):
            try:
                return datetime(*(int(part) for part in match.groups() if part))  # type: ignore[arg-type]
            except ValueError:  # 20261399
                continue
    raise RecordingError(f"{path}: no date; {_DATED}, or 2026-03-03/{path.name}")


def _shared_description(path: Path, fleet: Path) -> Path | None:
    for above in path.parents:
        if (above / DESCRIPTION).is_file():
            return above / DESCRIPTION
        if above == fleet:
            break
    return None


def _midnight(date: datetime) -> datetime:
    return datetime(date.year, date.month, date.day)
