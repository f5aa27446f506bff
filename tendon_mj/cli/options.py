"""Kinds of options that several commands have, and the command as it was typed."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from contextvars import ContextVar
from pathlib import Path
from typing import Annotated, TypeVar

import tyro

typed_command = ContextVar("typed_command", default="")  # for the provenance of a result

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
