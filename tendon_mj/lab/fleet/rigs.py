"""Rigs of a fleet: folders of dated recordings.

    FLEET/description.toml          of all recordings that have no other
    FLEET/finger_01/2026-03-01.csv
    FLEET/finger_01/2026-03-02T14:30.csv

A table is named after its date in ISO 8601, with a time of day where there are several a day:
``2026-03-02T14:30`` or, where a name can't have colons, ``2026-03-02T1430``. Its description is
the TOML beside it, the ``description.toml`` of its rig, or that of the fleet.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from datetime import date, datetime, time
from pathlib import Path

from tendon_mj.errors import RecordingError, TendonError
from tendon_mj.lab.recordings import Recording, read_recording

DESCRIPTION = "description.toml"
_TABLES = (".csv", ".parquet", ".mcap")
RESULT_TABLE = "fleet.csv"  # of a run over a fleet


@dataclass(frozen=True)
class Rig:
    """One rig of a fleet.

    Attributes:
        name: of its folder.
        tables: date → file of a recording, in the order of time.
        descriptions: likewise, its description.
        error: why the rig cannot be used; empty where it can.
    """

    name: str
    tables: Mapping[datetime, Path]
    descriptions: Mapping[datetime, Path]
    error: str = ""

    @property
    def dates(self) -> tuple[datetime, ...]:
        """Date of each recording."""
        return tuple(self.tables)

    def read_first(self) -> Recording:
        """The first recording that can be read.

        Raises:
            RecordingError: none can; with the reason for the first.
        """
        refused = dict[datetime, str]()
        for when in self.tables:
            try:
                return self._read(when)
            except (TendonError, OSError) as error:
                refused[when] = str(error)
        raise RecordingError(unusable(refused))

    def read(self) -> tuple[dict[datetime, Recording], dict[datetime, str]]:
        """Date → recording, and date → reason why a recording cannot be used."""
        recordings, refused = dict[datetime, Recording](), dict[datetime, str]()
        for when, path in self.tables.items():
            try:
                recording = self._read(when)
                first = next(iter(recordings.values()), recording)
                if _model_of(recording) != _model_of(first):
                    raise RecordingError(
                        f"{path}: its model is {recording.model!r}, and that of the rig's first"
                        f" recording {first.model!r}; a rig has one model"
                    )
                recordings[when] = recording
            except (TendonError, OSError) as error:
                refused[when] = str(error)
        return recordings, refused

    def _read(self, when: datetime) -> Recording:
        recording = read_recording(self.tables[when], self.descriptions[when])
        return replace(recording, name=stamp(when))

    def without(self, dates: Collection[datetime]) -> Rig:
        """The rig with fewer recordings."""
        return replace(self, tables={d: p for d, p in self.tables.items() if d not in dates})


def stamp(when: datetime) -> str:
    """A date as the name of a recording: without a dot, which parameters' names have."""
    if when.time() == time():
        return f"{when:%Y-%m-%d}"
    return f"{when:%Y-%m-%d %H:%M:%S}" + (f",{when:%f}" if when.microsecond else "")


def unusable(refused: Mapping[datetime, str]) -> str:
    """That no recording of a rig can be used, with the reason for the first."""
    first = refused[min(refused)]
    if len(refused) == 1:
        return first
    return f"none of its {len(refused)} recordings can be used; the first: {first}"


def find_rigs(folder: Path, out: Path | None = None) -> list[Rig]:
    """The rigs of a fleet: every subfolder except results and hidden folders.

    A rig without recordings, with a table without a date or a description, or with two tables of
    one date is returned with its error.

    Args:
        folder: of the fleet, see the module's docstring.
        out: folder for results, which may lie in ``folder``.

    Raises:
        RecordingError: no folder has recordings, a recording lies directly in ``folder``, or
            ``out`` is in the folder of a rig.
    """
    if not folder.is_dir():
        raise RecordingError(f"{folder} is not a folder; a fleet is a folder with one for each rig")
    for path in _tables(folder):
        if _date(path):
            raise RecordingError(
                f"{path} lies directly in the fleet's folder; move it to the folder of its rig, for"
                f" example {folder / 'rig_1' / path.name}"
            )
    rigs = [_rig(path, folder) for path in sorted(folder.iterdir()) if _is_rig(path, out)]
    if all(rig.error and not _tables(folder / rig.name) for rig in rigs):
        raise RecordingError(
            f"{folder}: no folder in it has recordings ({', '.join(_TABLES)}); a fleet has one"
            " folder for each rig, with its recordings in it"
        )
    return rigs


def _is_rig(folder: Path, out: Path | None) -> bool:
    if not folder.is_dir() or folder.name.startswith("."):
        return False
    dated = [path for path in _tables(folder) if _date(path)]
    holds_out = out is not None and out.resolve().is_relative_to(folder.resolve())
    if dated and holds_out:
        raise RecordingError(
            f"{folder} holds recordings, such as {dated[0].name}, and is also --out; choose another"
            " --out"
        )
    return bool(dated) or not (holds_out or any(folder.rglob(RESULT_TABLE)))


def _rig(folder: Path, fleet: Path) -> Rig:
    tables, descriptions = dict[datetime, Path](), dict[datetime, Path]()
    try:
        for path in _tables(folder):
            when = _date(path)
            if when is None:
                raise RecordingError(
                    f"{path}: its name is not a date; name it after the day, as 2026-03-01.csv, or"
                    " after day and time, as 2026-03-01T1430.csv"
                )
            if when in tables:
                raise RecordingError(f"{tables[when]} and {path} are of one date, {stamp(when)}")
            tables[when], descriptions[when] = path, _description(path, fleet)
        unread = [f.name for f in folder.iterdir() if f.is_dir() and _tables(f)]
        if unread:
            raise RecordingError(
                f"{folder}: recordings in its folder {min(unread)!r} are not read; move them to"
                f" {folder}, with the date as their name"
            )
        if not tables:
            raise RecordingError(f"{folder}: no recordings ({', '.join(_TABLES)})")
    except RecordingError as error:
        return Rig(folder.name, {}, {}, str(error))
    return Rig(folder.name, dict(sorted(tables.items())), dict(sorted(descriptions.items())))


def _description(table: Path, fleet: Path) -> Path:
    places = (table.with_suffix(".toml"), table.with_name(DESCRIPTION), fleet / DESCRIPTION)
    for path in places:
        if path.is_file():
            return path
    own, of_rig, of_fleet = places
    raise RecordingError(f"{table}: no description: neither {own.name} nor {of_rig} nor {of_fleet}")


def _tables(folder: Path) -> list[Path]:
    files = sorted(folder.iterdir())
    return [p for p in files if p.suffix.lower() in _TABLES and not p.name.startswith(".")]


def _date(table: Path) -> datetime | None:
    """Date and time of day by a table's name; None without one, or with a time zone."""
    day, with_time, clock = table.stem.partition("T")
    try:
        when = datetime.combine(
            date.fromisoformat(day), time.fromisoformat(clock) if with_time else time()
        )
    except ValueError:
        return None
    return when if when.tzinfo is None else None


def _model_of(recording: Recording) -> Path:
    """A model's name, or the resolved path of its file."""
    path = Path(recording.model)
    return path.resolve() if path.is_file() else path
