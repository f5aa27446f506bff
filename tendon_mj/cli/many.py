"""`tendon-mj sweep`, `changes`, `fleet`: rollouts over parameters; recordings of rigs over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import mujoco
import tyro

from tendon_mj.cli.diagnose import read_one
from tendon_mj.cli.options import Repeated, Required, flat, given_files
from tendon_mj.cli.output import (
    Output,
    console,
    print_table,
    print_warnings,
    progress_bar,
    typed_command,
)
from tendon_mj.errors import InvalidValueError, RecordingError, TendonError
from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.diagnosis import collect_provenance
from tendon_mj.lab.fleet import REPRODUCIBILITY, RESULT_TABLE, compare_states, find_rigs, run_fleet
from tendon_mj.lab.recordings import Recording, read_recording, tables_in
from tendon_mj.lab.replay import load_recorded
from tendon_mj.lab.sweep import (
    CSV,
    PLAN,
    TABLE,
    Policy,
    SensorSummary,
    Sweep,
    SweepResult,
    check_folder,
    motion_recording,
    read_policy,
    run_sweep,
)
from tendon_mj.lab.units import UNKNOWN
from tendon_mj.lab.workers import Workers
from tendon_mj.models import load_model, model_path
from tendon_mj.show import (
    CHANGES,
    SPREAD,
    changes_figure,
    fleet_page,
    parameter_figure,
    spread_figure,
    write_table,
)
from tendon_mj.whole_file import whole_file

_PRINTED = 8  # outputs on the console; result.json has all
PAGE = "fleet.html"


def sweep(
    model: tyro.conf.Positional[str],
    parameter: Required[str],
    out: Path = Path("out/sweep"),
    draws: int = 0,
    seed: int = 0,
    motion: str | None = None,
    policy: str | None = None,
    recording: Path | None = None,
    description: Path | None = None,
    duration: float | None = None,
    settle: float | None = None,
    outputs: Repeated[str] = (),
    processes: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    again: bool = False,
) -> dict[str, object]:
    """Simulate a model with many values of its parameters; an interrupted run is continued.

    Args:
        model: MJCF file, or a model of the package: bench, joint, finger, finger_spring.
        parameter: Parameter and its values: "flexor.friction=0.05:0.3:6" has six values of the
            range, "flexor.friction=0.1,0.2" these two, and "flexor.friction=0.05:0.3" is drawn from
            the range, or has five values of it without --draws. A tendon stands for its sheath, and
            * for any text. Grids are combined with each other.
        out: Folder for the table (rollouts/*.parquet, and table.csv up to 10000 rollouts),
            result.json and the picture.
        draws: Random draws of the ranges without a grid, the same for every combination of grids.
        seed: Seed of the draws.
        motion: Motion of the finger: curl, tap, press, hold, or a CSV file. Motion of any other
            model: a CSV file with time_s and a column for each actuator that moves.
        policy: Function that is called with model and data before every step, once the model has
            settled, and sets data.ctrl, which has the motion's command, or 0; or a class, of which
            each rollout makes one.
        recording: Recording that drives the model in place of a motion. Outputs are then those of
            its measured columns, and include the error.
        description: TOML file of the recording, if it is not next to it.
        duration: Duration of the motion. By default its own.
        settle: Time before the first sample in which the model comes to the first command. By
            default that of the recording, and 0.5 s before a motion.
        outputs: Outputs to keep of each rollout, such as "tip_force.max": final, min, max, mean,
            rms and (of a recording) error of a sensor, or the sensor alone for all of them. By
            default all.
        processes: Processes on this machine, without Dask. By default as many as it has cores.
        workers: Workers of a Dask cluster that lives as long as the run.
        scheduler: Address of a running Dask scheduler, such as tcp://10.0.0.1:8786.
        again: Start again in a folder that holds another sweep.

    Example:
        tendon-mj sweep finger --parameter flexor.friction=0.05:0.3:6 --motion press
    """
    on = Workers(processes=processes, workers=workers, scheduler=scheduler)
    compiled = load_model(model)
    acting = read_policy(policy) if policy is not None else None
    driven = _driving_recording(model, compiled, motion, acting, recording, description, duration)
    plan = Sweep(
        compiled,
        driven,
        flat(parameter),
        draws=draws,
        seed=seed,
        outputs=flat(outputs),
        measured=recording is not None,
        settle=settle,
        policy=acting,
    )
    if not again:
        check_folder(plan, out)
    read = given_files([recording] if recording else [], description, [model])
    given = [*read, motion, acting.path if acting else None]
    output = Output(out, (CSV,), writes=(PLAN, CSV), given=given, begin=False)
    print_warnings(timing_warnings(driven) if recording else [])
    console.print(f"{_rollouts_text(plan.design.rollouts)} of {plan.rollouts.steps} steps on {on}")
    with progress_bar() as progress:
        done = run_sweep(plan, out, on=on, again=again, begin=output.begin, progress=progress)
    drawn = _write_tables(output, done, plan)
    result: dict[str, object] = {
        "model": model,
        "motion": driven.name,
        "policy": policy,
        "rollouts": plan.design.rollouts,
        "steps": plan.rollouts.steps,
        "failed": int((~done.solid).sum()),
        "unsolved": done.unsolved,
        "parameters": {
            axis.name: {
                "targets": list(axis.targets),
                "unit": plan.units[axis.name],
                "low": axis.low,
                "high": axis.high,
            }
            for axis in plan.axes
        },
        "outputs": done.summaries,
    }
    shown = drawn or list(plan.outputs[:1])
    _print_outputs(done, shown)
    return output.finish(result, _range_sentence(done, shown[0], model))


def _write_tables(output: Output, done: SweepResult, plan: Sweep) -> list[SensorSummary]:
    """Write tables and picture; returns the outputs in the picture."""
    output.add(output.folder / TABLE)
    table = done.write_csv(output.folder / CSV)
    if table:
        output.add(table)
    axes, drawn = done.drawn()
    if axes and drawn:  # of the rollouts that stayed stable
        labels = {f"{axis.name} [{plan.units[axis.name]}]": axis for axis in axes}
        units = {one: "" if one.unit == UNKNOWN else f" [{one.unit}]" for one in drawn}
        figure = parameter_figure(
            {label: done.column(axis.name)[done.solid] for label, axis in labels.items()},
            {f"{one.name}{unit}": done.column(one.name)[done.solid] for one, unit in units.items()},
            [label for label, axis in labels.items() if axis.grid is None],
        )
        output.figure("sweep", figure)
    return list(drawn)


def _driving_recording(
    name: str,
    model: mujoco.MjModel,
    motion: str | None,
    policy: Policy | None,
    recording: Path | None,
    description: Path | None,
    duration: float | None,
) -> Recording:
    if recording is None:
        if description is not None:
            raise InvalidValueError(f"--description {description}: there is no --recording")
        still = policy is not None
        return motion_recording(model_path(name).stem, model, motion, duration, still=still)
    given = {"motion": motion, "policy": policy, "duration": duration}
    other = next((f"--{k} {value}" for k, value in given.items() if value is not None), "")
    if other:
        raise InvalidValueError(f"{other} and --recording {recording}: give one of them")
    return read_recording(recording, description)


def _print_outputs(done: SweepResult, outputs: list[SensorSummary]) -> None:
    rows = []
    for output in outputs[:_PRINTED]:
        summary = done.summaries[output.name]
        if "min" in summary:
            shares = [f"{name} {share:.0%}" for name, share in summary["share_of_variance"].items()]
            low_high, mean = _range_text(summary, " … ", output), f"{summary['mean']:.4g}"
            rows.append((output.name, low_high, mean, ", ".join(shares)))
    if rows:
        print_table(("output", "range", "mean", "share of its variance"), rows)


def _range_sentence(done: SweepResult, output: SensorSummary, model: str) -> str:
    """Range of an output, and the parameter that it follows most."""
    rollouts, summary = done.rollouts, done.summaries[output.name]
    if "min" not in summary:
        every = "The rollout" if rollouts == 1 else f"All {rollouts} rollouts"
        return f"{every} of {model} became unstable."
    stable = "all stayed stable" if rollouts > 1 else "it stayed stable"
    failed = int((~done.solid).sum())
    ended = f"{failed} became unstable" if failed else stable
    if done.unsolved:
        ended += f", and in {done.unsolved} a sheath had no solved equilibrium at some time"
    varies = summary["min"] < summary["max"]
    goes = "goes from" if varies else "is"
    text = f"{output.name} {goes} {_range_text(summary, ' to ', output)}"
    if varies and summary["share_of_variance"]:
        name, share = max(summary["share_of_variance"].items(), key=lambda item: item[1])
        text += f", and {share:.0%} of its variance follows {name}"
    return f"In {_rollouts_text(rollouts)} of {model} {text}; {ended}."


def _rollouts_text(rollouts: int) -> str:
    return "1 rollout" if rollouts == 1 else f"{rollouts} rollouts"


def _range_text(summary: Mapping[str, float], between: str, output: SensorSummary) -> str:
    """Least and largest value with their unit, once where they are the same."""
    ends = (summary["min"], summary["max"])
    numbers = between.join(f"{end:.4g}" for end in dict.fromkeys(ends))
    return numbers if output.unit == UNKNOWN else f"{numbers} {output.unit}"


def changes(
    old: Annotated[Path, tyro.conf.Positional],
    new: Annotated[Path, tyro.conf.Positional],
    out: Path = Path("out/changes"),
    description: Path | None = None,
    model: str | None = None,
    reproducibility: float = REPRODUCIBILITY,
) -> dict[str, object]:
    """Find what changed on a rig between two recordings, or how small a change would be found.

    Args:
        old: Recording of the rig as it was, or a folder of recordings.
        new: The same of the rig as it is; best with the same motion.
        out: Folder for result.json.
        description: TOML file that describes the columns of all recordings.
        model: Model in place of the recordings' own: a name or an MJCF file.
        reproducibility: Share of itself by which a number comes back if nothing changed.

    Example:
        tendon-mj changes march.csv june.csv
    """
    states = [tables_in(path) for path in (old, new)]
    output = Output(out, given=given_files([*states[0], *states[1]], description, [model]))
    before, after = ([read_one(p, description, model, None) for p in paths] for paths in states)
    if not (before and after):
        raise RecordingError(f"changes needs recordings in both {old} and {new}")
    with progress_bar() as progress:
        progress("compare", 0, 1)
        compared = compare_states(before, after, load_recorded(before[0]), reproducibility)
        progress("compare", 1, 1)
    return output.finish(compared.result(), compared.sentence)


def fleet(
    folder: Annotated[Path, tyro.conf.Positional],
    out: Path = Path("out/fleet"),
    processes: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    again: bool = False,
) -> dict[str, object]:
    """Find which rigs of a fleet changed, what changed and since when, and which differ.

    Args:
        folder: Folder with a folder for each rig, which holds recordings named after their day,
            such as 2026-03-03.csv, each with its TOML file next to it, or one description.toml for
            all.
        out: Folder for the page, the table, result.json, and the results of each rig, which the
            next run does not compute again.
        processes: Processes on this machine, without Dask. By default as many as it has cores.
        workers: Workers of a Dask cluster that lives as long as the run.
        scheduler: Address of a running Dask scheduler, such as tcp://10.0.0.1:8786.
        again: Compute every rig again.

    Raises:
        TendonError: the folder is not a fleet, or no rig could be fitted; in the second case page
            and table have the reasons.

    Example:
        tendon-mj fleet hands --out out/hands
    """
    on = Workers(processes=processes, workers=workers, scheduler=scheduler)
    kept = out / "rigs"
    rigs = find_rigs(folder, kept)
    writes = (PAGE, RESULT_TABLE, f"{CHANGES}.png", f"{SPREAD}.png")
    output = Output(out, tables=(RESULT_TABLE,), writes=writes, begin=False)
    with progress_bar() as progress:
        result = run_fleet(rigs, kept, on=on, again=again, begin=output.begin, progress=progress)
    figures = {CHANGES: changes_figure(result), SPREAD: spread_figure(result)}
    pictures = {
        name: output.figure(name, figure).read_bytes()
        for name, figure in figures.items()
        if figure is not None
    }
    output.add(write_table(result, out / RESULT_TABLE))
    provenance = collect_provenance(typed_command.get())
    with whole_file(out / PAGE) as made:
        page = fleet_page(result, pictures, provenance, str(folder))
        made.write_text(page, encoding="utf-8")
    output.add(out / PAGE)
    numbers = result.result() | {"provenance": provenance.result()}
    for rig in result.with_findings:
        console.print(f"  {rig.sentence(result.units)}")
    sentences = filter(None, [result.sentence, result.warning, f"Page: {out / PAGE}"])
    output.finish(numbers, " ".join(sentences))
    failed = result.of("failed")
    if len(failed) == len(result.rigs):
        raise TendonError(f"no rig could be fitted; {failed[0].name}: {failed[0].error}")
    return numbers
