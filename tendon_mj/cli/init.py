"""`tendon-mj init`: a description of recordings of a model, to be filled in."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.output import console
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.replay import format_template
from tendon_mj.models import load_model, model_names, model_path
from tendon_mj.whole_file import whole_file


def init(
    model: Annotated[str, tyro.conf.Positional],
    out: Path | None = None,
) -> Path:
    """Write a description of recordings of a model: all its sensors and actuators, to be filled in.

    Args:
        model: MJCF file, or a model of the package.
        out: TOML file to write; by default the model's name in the current folder. One that is
            there is kept.

    Example:
        tendon-mj init my_rig.xml --out pull.toml
    """
    compiled = load_model(model)
    path = out if out is not None else Path(f"{model_path(model).stem}.toml")
    if path.exists():
        raise InvalidValueError(f"{path} is there already; give another --out, or remove it first")
    named = model
    if model not in model_names() and Path(model).is_file():
        named = Path(os.path.relpath(model, path.parent)).as_posix()
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as made:
        made.write_text(format_template(compiled, named), encoding="utf-8", newline="\n")
    console.print(
        f"Wrote {path}, to be filled in: actuators {compiled.nactuator}, sensors"
        f" {compiled.nsensor}; then: tendon-mj check RECORDING.csv --description {path}",
        soft_wrap=True,
    )
    return path
