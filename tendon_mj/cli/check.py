"""`tendon-mj check`: recordings over their model before any fit, and what looks wrong."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.given_files import given_files
from tendon_mj.cli.output import Output, console, print_warnings, progress_bar
from tendon_mj.cli.values_of import ValuesOf, applied
from tendon_mj.errors import RecordingError, TendonWarning
from tendon_mj.lab.data_check import Checked, check_recording
from tendon_mj.lab.recordings import Recording, read_recording, tables_in
from tendon_mj.lab.replay import Misfit, column_unit, quantity, replay_error
from tendon_mj.models import load_model
from tendon_mj.show import replay_figure

_LABEL = "model as stated"


def check(
    recordings: Annotated[tuple[Path, ...], tyro.conf.Positional],
    out: Path = Path("out/check"),
    description: Path | None = None,
    model: str | None = None,
    values_of: ValuesOf | None = None,
    settle: float | None = None,
) -> dict[str, object]:
    """Draw recordings over their model before anything is fitted, and warn of what looks wrong.

    Args:
        recordings: CSVs (or Parquet, MCAP), or folders of them, each with its TOML beside it
            unless --description names one.
        out: folder for result.json and a picture of each recording.
        description: TOML that says what the columns of all recordings are.
        model: to simulate instead of the recordings' own: a name or an MJCF file.
        values_of: whether [known], [uncertain] and [session] of the description are applied to the
            model; by default all but what a diagnosis fitted, if it wrote the model.
        settle: time in seconds before the first sample in which the model comes to the first drive
            value; by default as the description says.

    Example:
        tendon-mj check pull.csv
    """
    recordings = tuple(table for path in recordings for table in tables_in(path))
    output = Output(out, given=given_files(recordings, description, [model]))
    if not recordings:
        raise RecordingError("check needs at least one recording")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", TendonWarning)
        read = _told_apart([read_recording(path, description) for path in recordings])
    of_tables = [str(one.message) for one in said if issubclass(one.category, TendonWarning)]
    shared = load_model(model) if model else None
    compiled = [shared or load_model(one.model, beside=one.beside) for one in read]
    described = [applied(values_of, *pair) for pair in zip(read, compiled, strict=True)]
    for text in of_tables:
        console.print(f"warning: {text}", soft_wrap=True)
    checked = []
    with progress_bar() as progress:
        for k, recording in enumerate(read):
            progress("simulate", k, len(read))
            found = check_recording(recording, compiled[k], described=described[k], settle=settle)
            checked.append(found)
        progress("simulate", len(read), len(read))
    for one in checked:
        if one.simulated is not None and one.recording.measured:
            figure = replay_figure(one.recording, {_LABEL: one.simulated})
            output.figure(one.recording.name, figure)
        _say(one)
    result: dict[str, object] = {
        "recordings": [_result(one) for one in checked],
        "table_warnings": of_tables,
    }
    output.result(result)
    output.close(_conclusion(checked, len(of_tables)))
    return result


def _told_apart(recordings: list[Recording]) -> list[Recording]:
    """Recordings of one name, as of folders of their own, with their number before it."""
    if len({one.name for one in recordings}) == len(recordings):
        return recordings
    return [replace(one, name=f"{k}_{one.name}") for k, one in enumerate(recordings)]


def _errors(one: Checked) -> dict[str, Misfit]:
    return {} if one.simulated is None else replay_error(one.recording, one.simulated)


def _say(one: Checked) -> None:
    for column, error in _errors(one).items():
        console.print(
            f"{one.recording.name}: {one.recording.written(column)} rms error"
            f" {quantity(error.rmse, column_unit(column))}{error.of_range}",
            soft_wrap=True,
        )
    print_warnings(one.warnings)


def _result(one: Checked) -> dict[str, object]:
    errors = _errors(one)
    return {
        "name": one.recording.name,
        "source": one.recording.source,
        "model": one.recording.model,
        "samples": int(one.recording.time.size),
        "simulated": one.simulated is not None,
        "rmse": {column: error.rmse for column, error in errors.items()},
        "share_of_range": {column: error.share_of_range for column, error in errors.items()},
        "warnings": [warning.result() for warning in one.warnings],
    }


def _conclusion(checked: Sequence[Checked], of_tables: int) -> str:
    count, recordings = of_tables + sum(len(one.warnings) for one in checked), len(checked)
    of = "1 recording" if recordings == 1 else f"{recordings} recordings"
    if not count:
        shares = [e.share_of_range for one in checked for e in _errors(one).values()]
        shares = [share for share in shares if math.isfinite(share)]
        off = f"; the model is off by up to {max(shares):.0%} of a column's range" if shares else ""
        return f"Checked {of}: nothing looks wrong{off}. What remains is for tendon-mj diagnose."
    said = "1 warning" if count == 1 else f"{count} warnings"
    return f"Checked {of}: {said}. A diagnosis would take such faults for properties of the rig."
