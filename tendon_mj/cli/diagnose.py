"""`tendon-mj diagnose`: what a model lacks against recordings, named, added and proven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.builders.load import load_model
from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.diagnosis import Diagnosis
from tendon_mj.diagnosis import diagnose as find
from tendon_mj.diagnosis.sysid import SysidResult, fit_with_sysid, sysid_is_there
from tendon_mj.progress import Progress
from tendon_mj.recordings.recording import Recording, read_recording, write_recording
from tendon_mj.replay.patch import patch_model
from tendon_mj.replay.replay import replay
from tendon_mj.view.report.figures import diagnosis_figures
from tendon_mj.view.report.report import report_page, short

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
    exclude: tuple[str, ...] = (),
    sysid: bool = True,
) -> dict[str, object]:
    """Find what a model lacks against recordings, name it, add it, and prove it on other data.

    Args:
        recordings: CSVs of one rig, each with its TOML beside it unless --description names one.
        out: folder for result.json, report.html, model.xml, pictures and simulated recordings.
        hold_out: recordings for the proof alone; without any, the last quarter of each recording
            is kept for it.
        description: TOML that says what the columns of all recordings are.
        model: to diagnose instead of the recordings' own: a name or an MJCF file.
        exclude: effects of the catalogue that are not to be considered.
        sysid: whether to fit the same data with mujoco.sysid alone, for comparison.
    """
    output = Output(out)
    train, held_out = (
        [_read(path, description, model) for path in paths] for paths in (recordings, hold_out)
    )
    with progress_bar() as progress:
        diagnosis = find(train, held_out, exclude=exclude, progress=progress)
        compared = _compare(train, held_out, progress) if sysid else None
        simulated = _simulate(diagnosis, train, held_out, progress)
    no_sysid = _LEFT_OUT if not sysid else _NOT_THERE
    result = diagnosis.result() | {
        "recordings": [recording.name for recording in train],
        "held_out": [recording.name for recording in held_out],
        "model": train[0].model,
        "sysid": compared.result() if compared else None,
    }
    _say(diagnosis, compared, no_sysid)
    for k, (measured, before, after) in enumerate(simulated):
        output.add(write_recording(before, out / f"{k}_{measured.name}_before.csv"))
        output.add(write_recording(after, out / f"{k}_{measured.name}_after.csv"))
    figures = diagnosis_figures(diagnosis, simulated[-1], compared.signals if compared else None)
    page = report_page(
        diagnosis,
        train,
        held_out,
        figures,
        shown=simulated[-1][0].name,
        sysid=compared,
        no_sysid=no_sysid,
    )
    for name, figure in figures.items():
        output.figure(name, figure)
    report = out / "report.html"
    report.write_text(page, encoding="utf-8")
    output.add(report)
    output.add(_write_model(diagnosis, train[0], out / "model.xml"))
    output.result(result)
    output.close()
    return result


def _read(path: Path, description: Path | None, model: str | None) -> Recording:
    recording = read_recording(path, description)
    return replace(recording, model=model) if model else recording


def _compare(
    train: Sequence[Recording], held_out: Sequence[Recording], progress: Progress
) -> SysidResult | None:
    return fit_with_sysid(train, held_out, progress) if sysid_is_there() else None


def _simulate(
    diagnosis: Diagnosis,
    train: Sequence[Recording],
    held_out: Sequence[Recording],
    progress: Progress,
) -> list[tuple[Recording, Recording, Recording]]:
    """Each recording of the proof, simulated calibrated alone, and with what was found."""
    shown = held_out or train
    compiled = load_model(train[0].model)
    after = _found(diagnosis)
    before = {name: diagnosis.before[name] for name in diagnosis.calibrated}
    rows = []
    for k, recording in enumerate(shown):
        progress("simulate before and after", k, len(shown))
        answers = [replay(recording, compiled, parameters=values) for values in (before, after)]
        rows.append((recording, answers[0], answers[1]))
    progress("simulate before and after", len(shown), len(shown))
    return rows


def _found(diagnosis: Diagnosis) -> dict[str, float]:
    """Every parameter that was fitted, as the final model has it."""
    names = (*diagnosis.calibrated, *diagnosis.parameters)
    return {name: diagnosis.model[name] for name in names}


def _write_model(diagnosis: Diagnosis, recording: Recording, path: Path) -> Path:
    """The model with what the rig is known to have and what was found."""
    found = _found(diagnosis)
    fitted = {**diagnosis.calibrated, **diagnosis.parameters}
    intervals = {
        name: (value.low, value.high)
        for name, value in fitted.items()
        if value.determined and value.low <= found[name] <= value.high
    }
    stated = {name: uncertain.value for name, uncertain in recording.uncertain.items()}
    values = {**recording.known, **stated, **found}
    return patch_model(recording.model, values, path, intervals=intervals)


def _say(diagnosis: Diagnosis, compared: SysidResult | None, no_sysid: str) -> None:
    console.print(diagnosis.sentence, soft_wrap=True)
    console.print(diagnosis.located.sentence, soft_wrap=True)
    for finding in diagnosis.findings:
        console.print(
            f"  {finding.identifier} ({finding.where}), confidence {finding.confidence:.0%}:"
            f" {finding.equation}",
            soft_wrap=True,
        )
    for name, value in {**diagnosis.calibrated, **diagnosis.parameters}.items():
        span = f"{short(value.low)} … {short(value.high)}"
        loose = f"at an end of its range {span}" if value.at_end else f"anywhere in {span}"
        sure = f"95 % within {span}" if value.determined else loose
        console.print(
            f"  {name} = {short(value.value)}{value.suffix}, {sure};"
            f" the model said {short(value.before)}",
            soft_wrap=True,
        )
    for label, gap in (("train", diagnosis.train), ("held out", diagnosis.held_out)):
        console.print(
            f"{label}: rms error {gap.before:.2f} before, {gap.after:.2f} after,"
            f" floor {gap.noise_floor:.2f} [noise]"
        )
    if compared:
        console.print(f"mujoco.sysid alone: {compared.held_out_rms:.2f} held out, in noise")
    else:
        console.print(no_sysid, soft_wrap=True)
