"""Kinds of options that several commands have, and the files that they name."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, TypeVar

import tyro

from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import described_model, table_beside
from tendon_mj.models import model_path

_Value = TypeVar("_Value")
Recordings = Annotated[
    tuple[Path, ...],
    tyro.conf.Positional,
    tyro.conf.arg(metavar="PATH [PATH ...]", help_behavior_hint="(required)"),
]
# an option of several values that may be given more than once; `flat` has all of them
Repeated = tyro.conf.UseAppendAction[tuple[tuple[_Value, ...], ...]]
Required = Annotated[Repeated[_Value], tyro.conf.arg(help_behavior_hint="(required, repeatable)")]


def flat(groups: Iterable[Iterable[_Value]]) -> tuple[_Value, ...]:
    """The values of a repeated option in their order."""
    return tuple(itertools.chain.from_iterable(groups))


def given_files(
    recordings: Iterable[Path] = (),
    description: Path | None = None,
    models: Iterable[str | None] = (),
) -> list[Path]:
    """Tables and descriptions of recordings, and MJCF files of models; unreadable ones are ignored.

    A description is of all recordings, else each has its own; models are else the recordings' own.
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
