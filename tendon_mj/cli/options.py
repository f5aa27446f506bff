"""Kinds of options that several commands have, and the files that they name."""

from __future__ import annotations

import contextlib
import inspect
import itertools
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar, get_origin

import tyro

from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import files_in, read_description, table_beside
from tendon_mj.models import model_path

_Value = TypeVar("_Value")
_Path = TypeVar("_Path", Path, Path | None)
Recordings = Annotated[
    tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(help_behavior_hint="(required)")
]
OutFile = Annotated[_Path, tyro.conf.arg(metavar="FILE")]
# an option of several values that may be given more than once; `flat` has all of them
Repeated = tyro.conf.UseAppendAction[tuple[tuple[_Value, ...], ...]]
Required = Annotated[Repeated[_Value], tyro.conf.arg(help_behavior_hint="(required, repeatable)")]
METAVARS: Final = {  # argument of a command → its value in the help, if not its name
    "actuator": "ACTUATOR [ACTUATOR ...]",
    "arc_guides": "COUNT",
    "armature": "INERTIA",
    "axial_stiffness": "EA",
    "bounds": "TOML",
    "camera": "NAME",
    "catalogue": "EFFECT [EFFECT ...]",
    "change": '"NAME=VALUE[,...]" [...]',
    "description": "TOML",
    "draws": "COUNT",
    "duration": "SECONDS",
    "effect": "NAME=VALUE[,...] [...]",
    "efficiency": "ETA",
    "exclude": "EFFECT [EFFECT ...]",
    "extra_bend": "RADIANS",
    "fps": "RATE",
    "friction": "MU",
    "hold_out": "RECORDING [RECORDING ...]",
    "inner_guides": "COUNT",
    "input_end": "{first,last}",
    "length": "METRE",
    "models": "[MODEL ...]",
    "next": "TOML",
    "out": "FOLDER",
    "outputs": "OUTPUT [OUTPUT ...]",
    "parameter": '"NAME=VALUES" [...]',
    "policy": "FILE.py:NAME",
    "pretension": "NEWTON",
    "processes": "COUNT",
    "radius": "METRE",
    "recordings": "RECORDING [RECORDING ...]",
    "reproducibility": "SHARE",
    "rounds": "COUNT",
    "scheduler": "ADDRESS",
    "seconds": "SECONDS",
    "seed": "INTEGER",
    "servo": "JSON",
    "servo_gain": "GAIN",
    "servo_voltage": "VOLT",
    "settle": "SECONDS",
    "signals": "COLUMN [COLUMN ...]",
    "size": "WIDTHxHEIGHT",
    "tendon": "TENDON [TENDON ...]",
    "values_of": "{description,model}",
    "workers": "COUNT",
}


def described(argument: inspect.Parameter, hint: Any) -> Any:
    """Type of an argument with its metavar, and without a remark that its default is None."""
    if hint is bool:  # a flag
        return hint
    metavar = METAVARS.get(argument.name, argument.name.upper())
    remark = "" if argument.default is None else None
    parts: list[Any] = [tyro.conf.arg(metavar=metavar, help_behavior_hint=remark)]
    if get_origin(hint) is Annotated:  # which overrules
        parts, hint = [*parts, *hint.__metadata__], hint.__origin__
    return Annotated[(hint, *parts)]


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
            files += [*files_in(table), description or beside]
            if described:
                names.append(read_description(description or beside).model)
    for name in dict.fromkeys(names):
        with contextlib.suppress(TendonError):
            files.append(model_path(name))
    return files
