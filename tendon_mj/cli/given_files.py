"""Files that a command was given to read, with those that its models are made of."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import described_model, table_beside
from tendon_mj.model_files import files_of_model
from tendon_mj.models import model_path


def given_files(
    recordings: Iterable[Path] = (),
    description: Path | None = None,
    models: Iterable[str | None] = (),
) -> list[Path]:
    """Tables and descriptions of recordings, and what the models are made of.

    What cannot be read is left to who reads it.

    Args:
        recordings: paths as for `read_recording`.
        description: of all of them; default: each has its own.
        models: names or MJCF files; default: those of the recordings.
    """
    found: list[Path] = []
    sought = [name for name in models if name is not None]
    own = not sought
    for path in recordings:
        if path.name in ("", ".."):  # a folder
            continue
        table, beside = table_beside(path)
        described = description or beside
        found += [table, described]
        if own:
            with contextlib.suppress(TendonError):
                sought.append(described_model(described))
    for name in dict.fromkeys(sought):
        with contextlib.suppress(TendonError):
            found += files_of_model(model_path(name))
    return found
