"""Provenance of a result: the versions, the command, the date, and the files that went into it."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tendon_mj.lab.recordings import Recording, table_beside
from tendon_mj.models import model_path

_PACKAGES = ("tendon-mj", "mujoco", "numpy", "scipy", "numba")


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes:
        date: ISO 8601, with the offset of local time.
        versions: "python" and packages → version.
        command: as it was typed; empty where there was none.
        files: file as it was given → SHA-256 of its bytes, in hexadecimal digits.
    """

    date: str
    versions: Mapping[str, str]
    command: str = ""
    files: Mapping[str, str] = field(default_factory=dict)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        return {
            "date": self.date,
            "versions": dict(self.versions),
            "command": self.command,
            "files": dict(self.files),
        }


def files_of(
    paths: Iterable[Path], description: Path | None, recordings: Iterable[Recording]
) -> list[Path]:
    """Files that a diagnosis of recordings read: their data, descriptions, and models.

    Args:
        paths: of the recordings, as given: a file of data, its TOML, or the stem of both.
        description: TOML of all recordings, where they have not one each.
        recordings: as read from them; a model's own includes are not among the files.
    """
    found = list[Path]()
    for path in paths:
        table, beside = table_beside(path)
        found += [table, description or beside]
    found += [model_path(model) for model in {r.model: None for r in recordings}]
    return list(dict.fromkeys(found))


def collect_provenance(command: str = "", files: Iterable[str | Path] = ()) -> Provenance:
    """Provenance of a result that is made now.

    Args:
        command: as it was typed.
        files: that went into it; each is read, to hash it.

    Raises:
        OSError: a file cannot be read.
    """
    hashed = {str(file): hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files}
    return Provenance(
        date=datetime.now().astimezone().isoformat(timespec="seconds"),
        versions={"python": platform.python_version()}
        | {name: version(name) for name in _PACKAGES},
        command=command,
        files=hashed,
    )
