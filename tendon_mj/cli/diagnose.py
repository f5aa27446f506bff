"""`tendon-mj diagnose`: what a model lacks against recordings, named, added and proven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.given_files import given_files
from tendon_mj.cli.output import Output, console, print_warnings, progress_bar
from tendon_mj.cli.typed_command import typed_command
from tendon_mj.errors import TendonError
from tendon_mj.lab.data_check import DataWarning, check_recording
from tendon_mj.lab.diagnosis import (
    Diagnosis,
    Spread,
    SysidResult,
    collect_provenance,
    files_of,
    fit_with_sysid,
    sysid_is_there,
    write_before_after,
)
from tendon_mj.lab.diagnosis import diagnose as find
from tendon_mj.lab.experiment_design import (
    ExperimentBounds,
    Suggestion,
    check_bounds,
    read_bounds,
    suggest_experiment,
)
from tendon_mj.lab.recordings import Recording, read_recording
from tendon_mj.lab.replay import engineering_unit, estimated_percent, plain, with_unit
from tendon_mj.show import ABSENT, MODEL, value_rows, write_report

_WRITES = (
    MODEL,
    *(f"[0-9]*_{when}.{ending}" for when in ("before", "after") for ending in ("csv", "toml")),
    *(f"{picture}.png" for picture in ("misfit", "gap", "proof", "before_after")),
)
_NEXT = ("next.csv", "next.toml")  # written where explanations tie
_LEFT_OUT = "The comparison with mujoco.sysid was left out (--no-sysid)."
_NOT_THERE = (
    "No comparison with mujoco.sysid: it lacks what it needs (pip install 'tendon-mj[sysid]')."
)


def diagnose(
    recordings: Annotated[tuple[Path, ...], tyro.conf.Positional],
    out: Path = Path("out/diagnose"),
    hold_out: tuple[Path, ...] = (),
    description: Path | None = None,
    model: str | None = None,
    settle: float | None = None,
    exclude: tuple[str, ...] = (),
    sysid: bool = True,
    next: Path | None = None,
) -> dict[str, object]:
    """Find what a model lacks against recordings, name it, add it, and prove it on other data.

    Args:
        recordings: CSVs (or Parquet, MCAP) of one rig, each with its TOML beside it unless
            --description names one.
        out: folder for result.json, report.html, model.xml, pictures and simulated recordings.
        hold_out: recordings for the proof alone. Without any, three or more recordings of different
            states or sessions of the rig are each predicted from the others, and of any others the
            last quarter of each is kept for the proof.
        description: TOML that says what the columns of all recordings are.
        model: to diagnose instead of the recordings' own: a name or an MJCF file.
        settle: time in seconds before the first sample in which the model comes to the first drive
            value; by default as the description says.
        exclude: effects of the catalogue that are not to be considered.
        sysid: whether to fit the same data with mujoco.sysid alone, for comparison.
        next: TOML with the bounds of what the rig can run; where explanations tie, the experiment
            within them that decides is written as next.csv and next.toml, to be filled in.

    Example:
        tendon-mj diagnose slow.csv fast.csv --hold-out other.csv --out out/diagnose
    """
    given = [*given_files((*recordings, *hold_out), description, [model]), next]
    output = Output(out, writes=_WRITES if next is None else _WRITES + _NEXT, given=given)
    bounds = read_bounds(next) if next else None
    train, held_out = (
        [_read(path, description, model, settle) for path in paths]
        for paths in (recordings, hold_out)
    )
    checks = _check((*train, *held_out))
    if bounds and train:  # before the diagnosis, which takes longer
        check_bounds(train, bounds)
    with progress_bar() as progress:
        diagnosis = find(train, held_out, exclude=exclude, checks=checks, progress=progress)
        fits = sysid and sysid_is_there()
        compared = fit_with_sysid(train, held_out, progress) if fits else None
        simulated = diagnosis.simulate(progress)
    no_sysid = _LEFT_OUT if not sysid else _NOT_THERE
    _say(diagnosis, compared, no_sysid)
    options = {
        "--hold-out": hold_out,
        "--description": description,
        "--model": model,
        "--exclude": exclude,
        "--next": next,
        "--settle": settle,
        "--out": out,
        "--no-sysid": not sysid,
    }
    command = typed_command("diagnose", recordings, options)
    provenance = collect_provenance(command, files_of((*recordings, *hold_out), description, train))
    for path in write_before_after(simulated, out):
        output.add(path)
    unwritten: TendonError | None = None
    try:  # before the report, which links to it
        output.add(diagnosis.write_model(out / MODEL))
    except TendonError as error:  # what was found is written all the same
        unwritten = error
        warning = f"There is no {MODEL}: {error}"
        diagnosis = replace(diagnosis, warnings=(*diagnosis.warnings, warning))
    for path in write_report(
        diagnosis, simulated, out, sysid=compared, no_sysid=no_sysid, provenance=provenance
    ):
        output.add(path)
    suggestion, failure = _suggest(diagnosis, bounds)
    if suggestion:
        console.print(suggestion.sentence, soft_wrap=True)
        template = suggestion.write(out / "next.csv")
        if template:
            output.add(template)
    result = diagnosis.result() | {
        "recordings": [recording.name for recording in train],
        "held_out": [recording.name for recording in held_out],
        "model": train[0].model,
        "sysid": compared.result() if compared else None,
        "next": suggestion.result() if suggestion else None,
        "provenance": provenance.result(),
    }
    output.result(result)
    output.close(f"{diagnosis.sentence} Report: {out / 'report.html'}")
    untold = unwritten or failure
    if untold:
        raise untold
    return result


def _check(recordings: Sequence[Recording]) -> list[DataWarning]:
    """Warnings about the recordings, printed before a search that would take them for the rig's."""
    checks = [w for one in recordings for w in check_recording(one, described=True).warnings]
    print_warnings(checks)
    return checks


def _suggest(
    diagnosis: Diagnosis, bounds: ExperimentBounds | None
) -> tuple[Suggestion | None, TendonError | None]:
    """The next experiment, or why there is none: what was diagnosed is written all the same."""
    if bounds is None:
        return None, None
    try:
        with progress_bar() as progress:
            return suggest_experiment(diagnosis, bounds, progress=progress), None
    except TendonError as error:
        return None, error


def _read(
    path: Path, description: Path | None, model: str | None, settle: float | None
) -> Recording:
    recording = read_recording(path, description)
    if model:
        recording = replace(recording, model=model, beside=None)
    return recording if settle is None else replace(recording, settle=settle)


def _say(diagnosis: Diagnosis, compared: SysidResult | None, no_sysid: str) -> None:
    console.print(diagnosis.located.sentence, soft_wrap=True)
    for finding in diagnosis.findings:
        console.print(
            f"  {finding.identifier} ({finding.where}), confidence"
            f" {estimated_percent(finding.confidence)}: {finding.equation}",
            soft_wrap=True,
        )
    values = {**diagnosis.calibrated, **diagnosis.parameters}
    for row, value in zip(value_rows(values), values.values(), strict=True):
        span = f"{row.low} … {row.high}"
        unit = "" if row.unit == ABSENT else f" {row.unit}"
        loose = f"at an end of its range {span}" if value.at_end else f"anywhere in {span}"
        sure = f"95 % within {span}" if value.determined else loose
        console.print(
            f"  {row.name} = {row.value}{unit}, {sure}; the model said {row.before}",
            soft_wrap=True,
        )
    for name, spread in diagnosis.sessions.items():
        console.print(_set_anew(name, spread), soft_wrap=True)
    for label, errors in (("train", diagnosis.train), ("held out", diagnosis.held_out)):
        console.print(
            f"{label}: rms error {errors.before:.2f} before, {errors.after:.2f} after,"
            f" noise floor {errors.noise_floor:.2f} [noise]"
        )
    if diagnosis.bars:
        weighed = diagnosis.weighed
        console.print(
            f"held out, in the unit of the verdict: {weighed.before:.2f} before,"
            f" {weighed.after:.2f} after [{weighed.unit}]",
            soft_wrap=True,
        )
    if compared:
        console.print(f"mujoco.sysid alone: {compared.held_out_rms:.2f} held out, in noise")
    else:
        console.print(no_sysid, soft_wrap=True)


def _set_anew(name: str, spread: Spread) -> str:
    """What was set anew for each recording, in one unit."""
    numbers = (*spread.values.values(), spread.estimated, spread.stated)
    unit = engineering_unit(spread.unit, numbers)
    *own, found, stated = (with_unit(plain(v * unit.factor), unit) for v in numbers)
    each = ", ".join(f"{value} in {r}" for r, value in zip(spread.values, own, strict=True))
    return f"  {name} was set anew: {each}; spread {found}, {stated} was stated"
