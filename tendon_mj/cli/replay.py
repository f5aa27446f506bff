"""`tendon-mj replay`: simulate a recording, and show the error."""

from __future__ import annotations

import copy
import math
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.given_files import given_files
from tendon_mj.cli.output import Output, console, print_warnings, progress_bar
from tendon_mj.cli.values_of import ValuesOf, applied
from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.recordings import Recording, read_recording, write_recording
from tendon_mj.lab.replay import (
    Adjustable,
    Misfit,
    column_unit,
    matching,
    quantity,
    read_intervals,
    replay_error,
    replay_recording,
)
from tendon_mj.models import load_model
from tendon_mj.show import replay_figure

DESCRIBED, KEPT = "as described", "with the model's values"
WITHOUT = "friction 0"
_WRITES = ("simulated_[0-9]*.csv", "simulated_[0-9]*.toml")


def replay(
    recording: Annotated[Path, tyro.conf.Positional],
    out: Path = Path("out/replay"),
    description: Path | None = None,
    model: str | None = None,
    values_of: ValuesOf | None = None,
    settle: float | None = None,
    change: tuple[str, ...] = (),
) -> dict[str, object]:
    """Simulate a recording with and without friction, and draw both beside the measurement.

    Args:
        recording: a CSV (or Parquet, MCAP), with its TOML beside it unless --description names
            another.
        out: folder for result.json, the simulated recordings and the picture.
        description: TOML that says what the columns are.
        model: to replay on instead of the recording's own: a name or an MJCF file.
        values_of: whether [known], [uncertain] and [session] of the description are applied to the
            model; by default all but what a diagnosis fitted, if it wrote the model.
        settle: time in seconds before the first sample in which the model comes to the first drive
            value; by default as the description says.
        change: more variants, each like "*.friction=0.1,joint.stiffness=0.03".

    Example:
        tendon-mj replay rig.csv --change "*.friction=0.1"
    """
    given = given_files([recording], description, [model])
    output = Output(out, writes=_WRITES, given=given)
    measured = read_recording(recording, description)
    if not measured.measured:
        raise RecordingError(
            f"{recording}: no column is [measured], so there is nothing to compare"
        )
    print_warnings(timing_warnings(measured))
    compiled = load_model(model) if model else load_model(measured.model, beside=measured.beside)
    described = applied(values_of, measured, compiled)
    kept = not described and bool(read_intervals(compiled) or values_of)
    stated = KEPT if kept else DESCRIBED
    variants: dict[str, dict[str, float]] = {stated: {}}
    known = Adjustable(copy.copy(compiled)).names()
    frictions = [name for name in known if name.endswith(".friction")]
    if frictions:
        variants[WITHOUT] = dict.fromkeys(frictions, 0.0)
    variants |= {text: _parse(text, known) for text in change}
    simulated = {}
    with progress_bar() as progress:
        for k, (label, parameters) in enumerate(variants.items()):
            progress("replay", k, len(variants))
            simulated[label] = replay_recording(
                measured, compiled, parameters=parameters, described=described, settle=settle
            )
        progress("replay", len(variants), len(variants))
    result: dict[str, object] = {}
    errors_of: dict[str, dict[str, Misfit]] = {}
    for k, (label, answer) in enumerate(simulated.items()):
        errors = errors_of[label] = replay_error(measured, answer)
        result[label] = {
            column: {"rmse": error.rmse, "share_of_range": error.share_of_range}
            for column, error in errors.items()
        }
        for column, error in errors.items():
            console.print(
                f"{label}: {measured.written(column)} rms error {_rms(error, column)}"
                f"{error.of_range}",
                soft_wrap=True,
            )
        output.add(write_recording(answer, out / f"simulated_{k}.csv"))
    output.figure("replay", replay_figure(measured, simulated))
    output.result({"recording": str(recording), "source": measured.source, "rmse": result})
    output.close(_conclusion(measured, errors_of, stated))
    return result


def _conclusion(
    measured: Recording, errors: Mapping[str, Mapping[str, Misfit]], stated: str
) -> str:
    """What came out, in a sentence: of every column the error as stated and without friction."""
    parts = [
        f"{measured.written(column)} by {_rms(errors[stated][column], column)}"
        + (
            f" (without friction {_rms(errors[WITHOUT][column], column)})"
            if WITHOUT in errors
            else ""
        )
        for column in measured.measured
    ]
    return f"{stated.capitalize()}, the simulation misses {', '.join(parts)}, rms."


def _rms(error: Misfit, column: str) -> str:
    return quantity(error.rmse, column_unit(column))


def _parse(text: str, known: Collection[str]) -> dict[str, float]:
    """Parameters of ``name=value,…``; a pattern means all that it matches; a plain name wins."""
    plain: dict[str, float] = {}
    wild: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = part.rpartition("=")
        try:
            given = float(value)
        except ValueError:
            equals = ""
        if not equals:
            raise InvalidValueError(f"--change {text!r}: {part!r} is not like name=value")
        if not math.isfinite(given):
            raise InvalidValueError(f"--change {text!r}: {part!r} is not finite; give a number")
        names = matching(name.strip(), known, f"--change {text!r}")
        chosen = plain if names == [name.strip()] else wild
        for one in names:
            if chosen.setdefault(one, given) != given:
                raise InvalidValueError(
                    f"--change {text!r}: {one} is given {chosen[one]:g} and {given:g}; for a"
                    " variant of its own for each, write them apart: --change a=1 a=2"
                )
    return wild | plain
