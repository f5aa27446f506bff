"""`tendon-mj diagnose`: the effect that a model lacks, named, added and tested on other data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from tendon_mj.cli.options import Recordings, Repeated, flat, given_files
from tendon_mj.cli.output import Output, console, print_warnings, progress_bar, typed_command
from tendon_mj.errors import INTERRUPTED, TendonError, UnknownNameError
from tendon_mj.lab.data_check import DataWarning, check_recording
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Diagnosis,
    Effect,
    SysidResult,
    collect_provenance,
    files_of,
    fit_with_sysid,
    sysid_is_there,
    write_before_after,
)
from tendon_mj.lab.diagnosis import diagnose as find
from tendon_mj.lab.experiment import ExperimentBounds, check_bounds, read_bounds
from tendon_mj.lab.experiment_design import Suggestion, suggest_experiment
from tendon_mj.lab.recordings import Recording, read_recording
from tendon_mj.lab.units import engineering_unit, estimated_percent
from tendon_mj.show import ABSENT, MODEL, headline, value_rows, write_report

_Result = TypeVar("_Result")
_WRITES = (
    MODEL,
    *(f"[0-9]*_{when}.{ending}" for when in ("before", "after") for ending in ("csv", "toml")),
    *(f"{picture}.png" for picture in ("rig", "misfit", "gap", "proof", "before_after")),
)
_NEXT = ("next.csv", "next.toml")  # written where explanations tie
_LEFT_OUT = "The comparison with mujoco.sysid was left out (--no-sysid)."
_SKIPPED = "The comparison with mujoco.sysid was interrupted."
_NOT_THERE = (
    "No comparison with mujoco.sysid: its packages are missing (pip install 'tendon-mj[sysid]')."
)


def diagnose(
    recordings: Recordings,
    out: Path = Path("out/diagnose"),
    hold_out: Repeated[Path] = (),
    description: Path | None = None,
    model: str | None = None,
    settle: float | None = None,
    exclude: Repeated[str] = (),
    catalogue: Repeated[str] = (),
    sysid: bool = True,
    next: Path | None = None,
) -> dict[str, object]:
    """Find the effect that a model lacks, name it, add it, and prove it on other data.

    Args:
        recordings: CSV, Parquet or MCAP files, bags of ROS or episodes of LeRobot of one rig. Each
            has its TOML file next to it, unless --description gives one for all.
        out: Folder for result.json, report.html, model.xml, pictures and simulated recordings.
        hold_out: Recordings that only test the result. Without any, the result is tested on the
            last quarter of each recording. Three or more recordings of different states or
            sessions of the rig are instead predicted each from the others.
        description: TOML file that describes the columns of all recordings.
        model: Model to diagnose in place of the recordings' own: a name or an MJCF file.
        settle: Time before the first sample in which the model comes to the first drive value. By
            default that of the description.
        exclude: Effects of the catalogue to leave out.
        catalogue: Effects of the catalogue to consider, and no others. By default all.
        sysid: Fit the same data with mujoco.sysid alone, for comparison, after everything else.
            Ctrl-C skips it.
        next: TOML file with the bounds of an experiment. If the recordings cannot tell effects
            apart, the experiment within the bounds that can is written as next.csv and next.toml,
            to be filled in.

    Example:
        tendon-mj diagnose slow.csv fast.csv --hold-out other.csv --out out/diagnose
    """
    paths = (*recordings, *flat(hold_out))
    given = [*given_files(paths, description, [model]), next]
    output = Output(out, writes=_WRITES if next is None else _WRITES + _NEXT, given=given)
    bounds = read_bounds(next) if next else None
    read = [read_one(path, description, model, settle) for path in paths]
    train, held_out = read[: len(recordings)], read[len(recordings) :]
    checks = _warn_of_data(read)
    if bounds and train:  # before the diagnosis, which takes longer
        check_bounds(train, bounds)
    effects = _chosen(flat(catalogue))
    with progress_bar() as progress:
        diagnosis = find(
            train,
            held_out,
            catalogue=effects,
            exclude=flat(exclude),
            checks=checks,
            progress=progress,
        )
        simulated = diagnosis.simulate(progress)
    provenance = collect_provenance(typed_command.get(), files_of(paths, description, train))
    output.written += write_before_after(simulated, out)
    diagnosis, failures = _write_model(output, diagnosis)  # before the report, which links to it
    compares = sysid and sysid_is_there()
    no_sysid = _SKIPPED if compares else _NOT_THERE if sysid else _LEFT_OUT
    report = partial(write_report, diagnosis, simulated, out, provenance=provenance)
    output.written += report(no_sysid=no_sysid)  # before the verdict, after which Ctrl-C may come
    _print_diagnosis(diagnosis)

    def compare() -> SysidResult:
        console.print("Comparing with mujoco.sysid; Ctrl-C skips this.")
        with progress_bar() as progress:
            fitted = fit_with_sysid(train, held_out, progress)
        report(sysid=fitted)
        return fitted

    suggestion = bounds and _unless_interrupted(
        partial(_suggest, output, diagnosis, bounds, failures)
    )
    compared = _unless_interrupted(compare) if compares else None
    console.print(
        f"mujoco.sysid alone: {compared.held_out_rms:.2f} held out, in noise"
        if compared
        else no_sysid
    )
    result = {
        **diagnosis.result(),
        "recordings": [recording.name for recording in train],
        "held_out": [recording.name for recording in held_out],
        "model": train[0].model,
        "sysid": compared and compared.result(),
        "next": suggestion and suggestion.result(),
        "provenance": provenance.result(),
    }
    output.finish(result, f"{diagnosis.sentence} Report: {out / 'report.html'}")
    if failures:
        raise TendonError(str(failures[0]))
    return result


def _chosen(identifiers: Sequence[str]) -> dict[str, Effect]:
    """Effects of the catalogue with these identifiers; all if there are none."""
    for identifier in identifiers:
        if identifier not in CATALOGUE:
            raise UnknownNameError("effect", identifier, CATALOGUE, "--catalogue")
    return {name: CATALOGUE[name] for name in identifiers or CATALOGUE}


def _unless_interrupted(do: Callable[[], _Result]) -> _Result | None:
    """The result of a step that Ctrl-C skips; None if it did."""
    try:
        return do()
    except KeyboardInterrupt:
        pass
    except TendonError as error:  # as which the plugins report a Ctrl-C
        if INTERRUPTED not in str(error):
            raise
    console.print("Skipped; the rest is written all the same.")
    return None


def _warn_of_data(recordings: Sequence[Recording]) -> list[DataWarning]:
    """Warnings about the recordings, printed before a search that would blame the rig for them."""
    checks = [w for one in recordings for w in check_recording(one, described=True).warnings]
    print_warnings(checks)
    return checks


def _write_model(output: Output, diagnosis: Diagnosis) -> tuple[Diagnosis, list[TendonError]]:
    """The diagnosis, with a warning where its model could not be written, and why it could not."""
    try:
        output.add(diagnosis.write_model(output.folder / MODEL))
    except TendonError as error:  # the rest is written all the same
        warning = f"There is no {MODEL}: {error}"
        return replace(diagnosis, warnings=(*diagnosis.warnings, warning)), [error]
    return diagnosis, []


def read_one(
    path: Path, description: Path | None, model: str | None, settle: float | None
) -> Recording:
    """Read a recording, with another model or settling time if they are given."""
    recording = read_recording(path, description)
    if model:
        recording = replace(recording, model=model, beside=None)
    return recording if settle is None else replace(recording, settle=settle)


def _suggest(
    output: Output, diagnosis: Diagnosis, bounds: ExperimentBounds, failures: list[TendonError]
) -> Suggestion | None:
    """Print and write the next experiment; the error of a search that failed is a failure."""
    try:
        with progress_bar() as progress:
            suggestion = suggest_experiment(diagnosis, bounds, progress=progress)
    except TendonError as error:
        failures.append(error)
        return None
    if suggestion:
        console.print(suggestion.sentence)
        template = suggestion.write(output.folder / "next.csv")
        if template:
            output.add(template)
    return suggestion


def _print_diagnosis(diagnosis: Diagnosis) -> None:
    console.print(f"{diagnosis.verdict}: {headline(diagnosis)}")
    console.print(diagnosis.located.sentence)
    for finding in diagnosis.findings:
        console.print(
            f"  {finding.identifier} ({finding.where}), confidence"
            f" {estimated_percent(finding.confidence)}: {finding.equation}"
        )
    values = {**diagnosis.calibrated, **diagnosis.parameters}
    if diagnosis.closest:
        console.print(
            "The numbers of what comes closest, not proven, are in report.html and result.json."
        )
        values = {}
    elif diagnosis.verdict == "unknown":
        console.print("Numbers that fit best, not proven:")
    for row in value_rows(values):
        value, span = row.fitted, f"{row.low} … {row.high}"
        unit = "" if row.unit == ABSENT else f" {row.unit}"
        loose = f"at an end of its range {span}" if value.at_end else f"anywhere in {span}"
        sure = f"95 % within {span}" if value.determined else loose
        console.print(f"  {row.name} = {row.value}{unit}, {sure}; the model has {row.before}")
    for name, spread in diagnosis.sessions.items():  # in one unit
        numbers = (*spread.values.values(), spread.estimated, spread.stated)
        shown = engineering_unit(spread.unit, numbers)
        *each, estimated, stated = map(shown.write, numbers)
        listed = ", ".join(f"{text} in {r}" for r, text in zip(spread.values, each, strict=True))
        console.print(f"  {name}, of each session: {listed}; spread {estimated}, stated {stated}")
    for label, errors in (("train", diagnosis.train), ("held out", diagnosis.held_out)):
        console.print(
            f"{label}: rms error {errors.before:.2f} before, {errors.after:.2f} after,"
            f" noise floor {errors.noise_floor:.2f} [noise]"
        )
    if diagnosis.bars:
        weighed = diagnosis.weighed
        console.print(
            f"held out, in the unit of the verdict: {weighed.before:.2f} before,"
            f" {weighed.after:.2f} after [{weighed.unit}]"
        )
