"""What was computed of each rig, kept in a file of its own, so that a killed run goes on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tendon_mj.lab.fleet.rig import Rig
from tendon_mj.lab.tasks import versions
from tendon_mj.whole_file import whole_file

_OF, _FOUND = "of", "found"
_LONGEST = 250  # name of a rig [bytes]: that of a file has 255 at most


class RigFiles:
    """Keeps a file of plain numbers for each rig.

    What was computed of other recordings, another model, or by another version, does not count.

    Args:
        folder: made if it is not there.
        of: rig → what its file is of.
        again: whether what is there is computed again.
    """

    def __init__(self, folder: Path, of: Mapping[str, str], *, again: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._of = folder, of
        self._fresh = set[str]() if again else {rig for rig in of if self._read(rig) is not None}

    def done(self) -> set[str]:
        """Rigs whose file is of what it should be."""
        return set(self._fresh)

    def write(self, key: str, result: Mapping[str, Any]) -> None:
        """Keep what was found of a rig."""
        text = json.dumps({_OF: self._of[key], _FOUND: result})
        with whole_file(self._path(key)) as made:
            made.write_text(text, encoding="utf-8")
        self._fresh.add(key)

    def read(self, key: str) -> dict[str, Any]:
        """What was found of a rig that is done."""
        found = self._read(key)
        if found is None:
            raise KeyError(key)
        return found

    def _path(self, rig: str) -> Path:
        name = rig.encode()
        if len(name) > _LONGEST:
            short = name[: _LONGEST - 20].decode(errors="ignore")
            rig = f"{short} {hashlib.sha256(name).hexdigest()[:16]}"
        return self._folder / f"{rig}.json"

    def _read(self, rig: str) -> dict[str, Any] | None:
        try:
            kept = json.loads(self._path(rig).read_text(encoding="utf-8"))
            return dict(kept[_FOUND]) if kept[_OF] == self._of[rig] else None
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None


def digest_of(rig: Rig, model: str) -> str:
    """16 hexadecimal digits of a rig's files, the digest of its model, and what computes."""
    whole = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    for path in rig.files:
        whole.update(path.name.encode() + _content(path))
    for date in rig.dates:
        whole.update(date.isoformat().encode())
    whole.update(model.encode())
    return whole.hexdigest()[:16]


def _content(path: Path) -> bytes:
    """Bytes of a file; none of one that cannot be read, or is none."""
    try:
        return path.read_bytes() if path.is_file() else b""
    except OSError:
        return b""
