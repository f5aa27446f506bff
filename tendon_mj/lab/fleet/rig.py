"""A rig of a fleet: the folder of its dated recordings."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from pathlib import Path

from tendon_mj.errors import RecordingError, TendonError
from tendon_mj.lab.fleet.date_in_name import date_in_name
from tendon_mj.lab.recordings import Recording, read_recording

DESCRIPTION = "description.toml"  # of all tables of a rig, or of all rigs
TABLES = (".csv", ".parquet", ".mcap")
RESULT_TABLE = "fleet.csv"  # of a run over a fleet
_DATED = "its file or a folder above it is named after the day, as 2026-03-03.csv"


@dataclass(frozen=True)
class Rig:
    """One rig of a fleet.

    Attributes:
        name: of its folder.
        tables: date → file of a recording, in the order of time.
        descriptions: file of a recording → its description; a file without one has it beside it.
        error: why its recordings cannot be told apart; empty where they can.
    """

    name: str
    tables: Mapping[datetime, Path]
    descriptions: Mapping[Path, Path]
    error: str = ""

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
        found, refused = self.read_each()
        for reason in refused.values():
            raise RecordingError(reason)
        return tuple(found.values())

    def read_each(self) -> tuple[dict[datetime, Recording], dict[datetime, str]]:
        """Date → recording that can be read, and date → why another cannot, or is of no use."""
        found, refused = dict[datetime, Recording](), dict[datetime, str]()
        for date, path in self.tables.items():
            try:
                recording = self._read(date)
                first = next(iter(found.values()), recording)
                if _model_of(recording) != _model_of(first):
                    raise RecordingError(
                        f"{path}: its model is {recording.model!r}, and that of the rig's first"
                        f" recording {first.model!r}; a rig has one model"
                    )
                found[date] = recording
            except (TendonError, OSError) as error:
                refused[date] = str(error)
        return found, refused

    def without(self, dates: Collection[datetime]) -> Rig:
        """The rig with fewer recordings."""
        return replace(self, tables={d: p for d, p in self.tables.items() if d not in dates})

    def read_first(self) -> Recording:
        """The first recording that can be read.

        Raises:
            RecordingError: none can; with the reason of the first.
        """
        refused = list[Exception]()
        for date in self.dates:
            try:
                return self._read(date)
            except (TendonError, OSError) as error:
                refused.append(error)
        raise RecordingError(none_left(self.dates, str(refused[0])))

    def _read(self, date: datetime) -> Recording:
        path = self.tables[date]
        return replace(read_recording(path, self.descriptions.get(path)), name=stamp(date))


def none_left(dates: Collection[datetime], reason: str) -> str:
    """That no recording of a rig can be used, with the reason of the first."""
    if len(dates) == 1:
        return reason
    return f"none of its {len(dates)} recordings can be used; the first: {reason}"


def stamp(date: datetime) -> str:
    """A date as a recording's name has it: without a dot, which parameters' names have."""
    if date == _midnight(date):
        return f"{date:%Y-%m-%d}"
    return f"{date:%Y-%m-%d %H:%M:%S}" + (f",{date:%f}" if date.microsecond else "")


def find_rigs(folder: Path, apart: Path | None = None) -> list[Rig]:
    """The rigs of a fleet: each folder in ``folder``, with its recordings at whatever depth.

    A table's date is that in its file's name, or else in that of the nearest folder above it, see
    `date_in_name`. Its description lies beside it, or is the nearest ``description.toml`` from
    there up to ``folder``. Links are followed; names that begin with a dot are left out. A rig
    without recordings, or with a table without a date or description, or two of one date, is there
    with its error.

    Args:
        folder: of the fleet.
        apart: folder in it that is no rig's, such as that of results; those of earlier results are
            left out too.

    Raises:
        RecordingError: no folder in it has recordings, or a recording lies in none, or beside
            results.
    """
    if not folder.is_dir():
        raise RecordingError(f"{folder} is no folder; a fleet is a folder with one for each rig")
    for path in sorted(folder.iterdir()):
        if path.is_file() and _is_table(path) and _is_dated(path, folder / "any"):
            raise RecordingError(
                f"{path} lies directly in the fleet's folder; a recording lies in the folder of its"
                f" rig, as {folder / 'rig_1' / path.name}"
            )
    inner = [p for p in sorted(folder.iterdir()) if p.is_dir() and not p.name.startswith(".")]
    for other in (p for p in inner if _holds(p, apart)):
        dated = [path for path in _tables(other) if _is_dated(path, other)]
        if dated:
            raise RecordingError(
                f"{other} has recordings, such as {dated[0].name}, and the results go there too"
                " (--out); give another folder for these"
            )
    rigs = [_rig(one, folder) for one in inner if not (_holds(one, apart) or _is_result(one))]
    if not any(_tables(folder / rig.name) for rig in rigs):
        raise RecordingError(
            f"{folder}: no folder in it has recordings ({', '.join(TABLES)}); a fleet has one"
            " folder for each rig, with its recordings in it"
        )
    return rigs


def _is_result(folder: Path) -> bool:
    """Whether an earlier run over the fleet wrote the folder, and no recording lies there."""
    return any(folder.rglob(RESULT_TABLE)) and not any(
        _is_dated(path, folder) for path in _tables(folder)
    )


def _holds(folder: Path, other: Path | None) -> bool:
    return other is not None and other.resolve().is_relative_to(folder.resolve())


def _rig(folder: Path, fleet: Path) -> Rig:
    name = _as_text(folder.name)
    try:
        return Rig(name, *_recordings(folder, fleet))
    except RecordingError as error:
        return Rig(name, {}, {}, _as_text(str(error)))


def _as_text(name: str) -> str:
    r"""A name that any file can hold: bytes in it that are not UTF-8 are written as \udcff."""
    return name.encode(errors="backslashreplace").decode()


def _recordings(folder: Path, fleet: Path) -> tuple[dict[datetime, Path], dict[Path, Path]]:
    """Date → table, in the order of time, and table → description that is not beside it."""
    dated: dict[datetime, Path] = {}
    described: dict[Path, Path] = {}
    for path in _tables(folder):
        if _as_text(str(path)) != str(path):
            raise RecordingError(f"{path}: the bytes of its name are not UTF-8; rename it")
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
    if not dated:
        raise RecordingError(f"{folder}: no recordings ({', '.join(TABLES)})")
    return dict(sorted(dated.items())), described


def _tables(folder: Path) -> list[Path]:
    """Every table in a folder; a linked folder is followed, unless it leads back to one above."""
    found = list[Path]()
    for name, folders, files in os.walk(folder, followlinks=True):
        inside = Path(name)
        above = {inside.resolve(), *inside.resolve().parents}
        folders[:] = [
            f for f in folders if not f.startswith(".") and (inside / f).resolve() not in above
        ]
        found += [inside / f for f in files if _is_table(inside / f)]
    return sorted(found)


def _is_table(path: Path) -> bool:
    return path.suffix.lower() in TABLES and not path.name.startswith(".")


def _date_of(path: Path, rig: Path) -> datetime:
    above = path.relative_to(rig.parent).parts[1:-1]
    for name in (path.stem, *reversed(above)):
        try:
            date = date_in_name(name)
        except RecordingError as error:
            raise RecordingError(f"{path}: {error}") from None
        if date is not None:
            return date
    raise RecordingError(f"{path}: no date; {_DATED}, or 2026-03-03/{path.name}")


def _is_dated(path: Path, rig: Path) -> bool:
    try:
        return bool(_date_of(path, rig))
    except RecordingError:
        return False


def _model_of(recording: Recording) -> Path:
    """A model's name, or the path of its file without the ways round."""
    path = Path(recording.model)
    return path.resolve() if path.is_file() else path


def _shared_description(path: Path, fleet: Path) -> Path | None:
    for above in path.parents:
        if (above / DESCRIPTION).is_file():
            return above / DESCRIPTION
        if above == fleet:
            break
    return None


def _midnight(date: datetime) -> datetime:
    return datetime(date.year, date.month, date.day)
