"""Rigs of a fleet: folders of dated recordings.

    FLEET/description.toml          of all recordings that have no other
    FLEET/finger_01/2026-03-01.csv
    FLEET/finger_01/2026-03-02T14:30.csv

A table is named after its date in ISO 8601, with a time of day if there are several a day:
``2026-03-02T14:30`` or, where a name can't have colons, ``2026-03-02T1430``. Its description is
the TOML beside it, the ``description.toml`` of its rig, or that of the fleet.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import date, datetime, time
from pathlib import Path
from typing import NamedTuple

import mujoco

from tendon_mj.errors import RecordingError, TendonError
from tendon_mj.lab.recordings import (
    FORMATS,
    Recording,
    is_same_model,
    read_description,
    read_recording,
)
from tendon_mj.lab.workers import versions
from tendon_mj.models import load_model, model_digest

DESCRIPTION = "description.toml"
RESULT_TABLE = "fleet.csv"  # of a run over a fleet


class RigData(NamedTuple):
    """The recordings of a rig, None for each that cannot be used; why it cannot; the model."""

    recordings: list[Recording | None]
    reasons: list[str]
    model: mujoco.MjModel | None


@dataclass(frozen=True)
class Rig:
    """One rig of a fleet."""

    name: str  # of its folder
    # date → table and description of a recording, in the order of time
    files: Mapping[datetime, tuple[Path, Path]]
    error: str = ""  # why the rig cannot be used; empty if it can

    @property
    def dates(self) -> tuple[datetime, ...]:
        """Date of each recording."""
        return tuple(self.files)

    def read(self) -> RigData:
        """The recordings, named after their dates, and the model of the first that can be read."""
        recordings, reasons = list[Recording | None](), list[str]()
        first, model = None, None
        for when, (table, description) in self.files.items():
            recording, reason = None, ""
            try:
                recording = replace(read_recording(table, description), name=stamp(when))
                first = first or recording
                if not is_same_model(recording.model, first.model):
                    raise RecordingError(
                        f"{table}: its model is {recording.model!r}, and that of the rig's first"
                        f" recording {first.model!r}; a rig has one model"
                    )
                model = model or load_model(recording.model, beside=recording.beside)
            except (TendonError, OSError) as error:
                recording, reason = None, str(error)
            recordings.append(recording)
            reasons.append(reason)
        return RigData(recordings, reasons, model)

    def digest(self) -> str:
        """16 hexadecimal digits of what decides its result: versions, dates, files and models."""
        digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
        models = dict[str, Path]()
        for when, (table, toml) in self.files.items():
            digest.update(when.isoformat().encode())
            with suppress(TendonError, OSError):  # the recording is left out when it is read
                digest.update(table.read_bytes())
                digest.update(toml.read_bytes())
                models[read_description(toml).model] = toml.parent
        for model, folder in models.items():
            with suppress(TendonError):
                digest.update(model_digest(load_model(model, beside=folder)).encode())
        return digest.hexdigest()[:16]

    def without(self, reasons: Sequence[str]) -> Rig:
        """The rig without the recordings that have a reason not to be used."""
        pairs = zip(self.files.items(), reasons, strict=True)
        return replace(self, files={when: files for (when, files), reason in pairs if not reason})


def stamp(when: datetime) -> str:
    """A date as the name of a recording: without a dot, which parameters' names have."""
    if when.time() == time():
        return f"{when:%Y-%m-%d}"
    return f"{when:%Y-%m-%d %H:%M:%S}" + (f",{when:%f}" if when.microsecond else "")


def find_rigs(folder: Path, out: Path | None = None) -> list[Rig]:
    """The rigs of a fleet: every subfolder except results and hidden folders.

    A rig without recordings, with a table without a date or a description, or with two tables of
    one date is returned with its error. ``out``: folder for results, which may lie
    in ``folder``.
    """
    if not folder.is_dir():
        raise RecordingError(f"{folder} is not a folder; a fleet is a folder with one for each rig")
    if loose := list(filter(_date, _tables(folder))):
        raise RecordingError(
            f"{loose[0]} lies directly in the fleet's folder; move it to the folder of its rig, for"
            f" example {folder / 'rig_1' / loose[0].name}"
        )
    rigs = [_rig(path, folder) for path in sorted(folder.iterdir()) if _is_rig(path, out)]
    if all(rig.error and not _tables(folder / rig.name) for rig in rigs):
        raise RecordingError(
            f"{folder}: no folder in it has recordings ({', '.join(FORMATS)}); a fleet has one"
            " folder for each rig, with its recordings in it"
        )
    return rigs


def _is_rig(folder: Path, out: Path | None) -> bool:
    if not folder.is_dir() or folder.name.startswith("."):
        return False
    dated = list(filter(_date, _tables(folder)))
    holds_out = out is not None and out.resolve().is_relative_to(folder.resolve())
    if dated and holds_out:
        raise RecordingError(
            f"{folder} holds recordings, such as {dated[0].name}, and is also --out; choose another"
            " --out"
        )
    return bool(dated) or not (holds_out or any(folder.rglob(RESULT_TABLE)))


def _rig(folder: Path, fleet: Path) -> Rig:
    files = dict[datetime, tuple[Path, Path]]()
    try:
        for table in _tables(folder):
            when = _date(table)
            if when is None:
                raise RecordingError(
                    f"{table}: its name is not a date; name it after the day, as 2026-03-01.csv, or"
                    " after day and time, as 2026-03-01T1430.csv"
                )
            if when in files:
                raise RecordingError(f"{files[when][0]} and {table} are of one date, {stamp(when)}")
            files[when] = table, _description(table, fleet)
        if not files:
            raise RecordingError(f"{folder}: no recordings ({', '.join(FORMATS)})")
    except RecordingError as error:
        return Rig(folder.name, {}, str(error))
    return Rig(folder.name, dict(sorted(files.items())))


def _description(table: Path, fleet: Path) -> Path:
    places = (table.with_suffix(".toml"), table.with_name(DESCRIPTION), fleet / DESCRIPTION)
    for path in places:
        if path.is_file():
            return path
    own, of_rig, of_fleet = places
    raise RecordingError(f"{table}: no description: neither {own.name} nor {of_rig} nor {of_fleet}")


def _tables(folder: Path) -> list[Path]:
    files = sorted(folder.iterdir())
    return [p for p in files if p.suffix.lower() in FORMATS and not p.name.startswith(".")]


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
