"""Files that a command was given to read."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import described_model, table_beside
from tendon_mj.models import model_path


def given_files(
    recordings: Iterable[Path] = (),
    description: Path | None = None,
    models: Iterable[str | None] = (),
) -> list[Path]:
    """Tables and descriptions of recordings, and MJCF files of models; unreadable ones are ignored.

    Args:
        recordings: paths as for `read_recording`.
        description: of all of them; default: each has its own.
        models: names or MJCF files; default: those of the recordings.
    """
    files, names = list[Path](), [name for name in models if name is not None]
    described = not names
    for path in recordings:
        with contextlib.suppress(TendonError):
            table, beside = table_beside(path)
            files += [table, description or beside]
            if described:
                names.append(described_model(description or beside))
    for name in dict.fromkeys(names):
        with contextlib.suppress(TendonError):
            files.append(model_path(name))
    return files
