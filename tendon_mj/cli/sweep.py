"""`tendon-mj sweep`: rollouts of a model over grids and random draws of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import mujoco
import tyro
from matplotlib.figure import Figure

from tendon_mj.cli.given_files import given_files
from tendon_mj.cli.output import (
    Output,
    console,
    print_table,
    print_warnings,
    progress_bar,
)
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.recordings import Recording, read_recording
from tendon_mj.lab.replay import UNKNOWN
from tendon_mj.lab.sweep import (
    CSV,
    PLAN,
    TABLE,
    Axis,
    Policy,
    Sweep,
    SweepResult,
    check_folder,
    motion_recording,
    read_policy,
    run_sweep,
)
from tendon_mj.lab.sweep import Output as SweepOutput
from tendon_mj.lab.tasks import Workers
from tendon_mj.models import load_model, model_path
from tendon_mj.show import parameter_figure

_SHOWN = 8  # outputs on the console; result.json has all


def sweep(
    model: Annotated[str, tyro.conf.Positional],
    parameter: tuple[str, ...],
    out: Path = Path("out/sweep"),
    draws: int = 0,
    seed: int = 0,
    motion: str | None = None,
    policy: str | None = None,
    recording: Path | None = None,
    description: Path | None = None,
    duration: float | None = None,
    settle: float | None = None,
    outputs: tuple[str, ...] = (),
    processes: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    again: bool = False,
) -> dict[str, object]:
    """Simulate a model with many values of its parameters; a run that was ended goes on.

    Args:
        model: bench, joint, finger, finger_spring, or the path of an MJCF file.
        parameter: what varies: "flexor.friction=0.05:0.3:6" (six values of the range),
            "flexor.friction=0.1,0.2" (these), or "flexor.friction=0.05:0.3" (drawn from the range,
            or five values of it without --draws). A tendon stands for its sheath, and * for any
            text. Grids are combined with each other.
        out: folder for the table (rollouts/*.parquet, and table.csv up to 10000 rollouts),
            result.json and the picture.
        draws: random draws of the ranges that are no grids, the same for every combination of
            those.
        seed: of the draws.
        motion: as for render and view: of a finger curl, tap, press, hold or a CSV; of any other
            model a CSV with time_s and a column for every actuator that moves.
        policy: "file.py:name", a function that is called with model and data before every step,
            once the model has settled, and sets data.ctrl, or a class of which each rollout makes
            one; it finds there what the motion commands, or 0.
        recording: drives the model in place of a motion; outputs are then of what it measures, and
            include the error.
        description: TOML of the recording where it does not lie beside it.
        duration: of the motion in seconds; default: its own.
        settle: time in seconds before the first sample in which the model comes to the first
            command; by default as the recording says, and 0.5 before a motion.
        outputs: what is kept of a rollout: "tip_force.max"; final, min, max, mean, rms and (of a
            recording) error of a sensor, or the sensor alone for all of them; default: all.
        processes: of this machine, without Dask; default: as many as it has cores.
        workers: of a Dask cluster that lives as long as the run.
        scheduler: address of a Dask scheduler, such as tcp://10.0.0.1:8786.
        again: begin anew in a folder that holds another sweep.

    Example:
        tendon-mj sweep finger --parameter flexor.friction=0.05:0.3:6 --motion press
    """
    on = Workers(processes=processes, workers=workers, scheduler=scheduler)
    compiled = load_model(model)
    acting = read_policy(policy) if policy is not None else None
    driven = _driven(model, compiled, motion, acting, recording, description, duration)
    asked = Sweep(
        compiled,
        driven,
        parameter,
        draws=draws,
        seed=seed,
        outputs=outputs,
        measured=recording is not None,
        settle=settle,
        policy=acting,
    )
    if not again:
        check_folder(asked, out)
    recorded = [recording] if recording else []
    read = given_files(recorded, description, [model])
    given = [*read, motion, acting.path if acting else None]
    writes = (PLAN, CSV, "sweep.png")
    output = Output(out, tables=(CSV,), writes=writes, given=given, begin=False)
    print_warnings(timing_warnings(driven) if recording else [])
    console.print(
        f"{_counted(asked.design.rollouts)} of {asked.rollouts.steps} steps on {on}", soft_wrap=True
    )
    with progress_bar() as progress:
        found = run_sweep(asked, out, on=on, again=again, begin=output.begin, progress=progress)
    output.add(out / TABLE)
    table = found.write_csv(out / CSV)
    if table:
        output.add(table)
    axes, told = found.drawn()
    if axes and told:
        output.figure("sweep", _figure(found, axes, told, asked.units))
    failed = int((~found.solid).sum())
    result: dict[str, object] = {
        "model": model,
        "motion": driven.name,
        "policy": policy,
        "rollouts": asked.design.rollouts,
        "steps": asked.rollouts.steps,
        "failed": failed,
        "unsolved": found.unsolved,
        "parameters": {
            axis.name: {
                "targets": list(axis.targets),
                "unit": asked.units[axis.name],
                "low": axis.low,
                "high": axis.high,
            }
            for axis in asked.axes
        },
        "outputs": found.summaries,
    }
    output.result(result)
    shown = told or list(asked.outputs[:1])
    _print(found, shown)
    output.close(_sentence(found, shown[0], model, failed))
    return result


def _figure(
    found: SweepResult,
    axes: Sequence[Axis],
    outputs: Sequence[SweepOutput],
    units: Mapping[str, str],
) -> Figure:
    """Outputs over parameters, of the rollouts that stayed stable."""
    labels = {f"{axis.name} [{units[axis.name]}]": axis for axis in axes}
    return parameter_figure(
        {label: found.column(axis.name)[found.solid] for label, axis in labels.items()},
        {_labelled(output): found.column(output.name)[found.solid] for output in outputs},
        [label for label, axis in labels.items() if axis.drawn],
    )


def _driven(
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


def _print(found: SweepResult, outputs: list[SweepOutput]) -> None:
    rows = []
    for output in outputs[:_SHOWN]:
        summary = found.summaries[output.name]
        if "min" in summary:
            shares = [f"{name} {share:.0%}" for name, share in summary["share_of_variance"].items()]
            rows.append(
                (
                    output.name,
                    _span(summary, " … ", output),
                    f"{summary['mean']:.4g}",
                    ", ".join(shares),
                )
            )
    if rows:
        print_table(("output", "range", "mean", "share of its variance"), rows)


def _sentence(found: SweepResult, output: SweepOutput, model: str, failed: int) -> str:
    """What came out, of the first output."""
    rollouts, summary = found.rollouts, found.summaries[output.name]
    if "min" not in summary:
        every = "The rollout" if rollouts == 1 else f"All {rollouts} rollouts"
        return f"{every} of {model} became unstable."
    stable = "all stayed stable" if rollouts > 1 else "it stayed stable"
    ended = f"{failed} became unstable" if failed else stable
    if found.unsolved:
        ended += f", and in {found.unsolved} a sheath found no equilibrium at some time"
    varies = summary["min"] < summary["max"]
    goes = "goes from" if varies else "is"
    said = f"{output.name} {goes} {_span(summary, ' to ', output)}"
    if varies and summary["share_of_variance"]:
        name, share = max(summary["share_of_variance"].items(), key=lambda item: item[1])
        said += f", and {share:.0%} of its variance follows {name}"
    return f"In {_counted(rollouts)} of {model} {said}; {ended}."


def _counted(rollouts: int) -> str:
    return "1 rollout" if rollouts == 1 else f"{rollouts} rollouts"


def _span(summary: Mapping[str, float], between: str, output: SweepOutput) -> str:
    """Least and largest value with their unit, once where they are the same."""
    ends = (summary["min"], summary["max"])
    numbers = between.join(f"{end:.4g}" for end in dict.fromkeys(ends))
    return numbers if output.unit == UNKNOWN else f"{numbers} {output.unit}"


def _labelled(output: SweepOutput) -> str:
    return output.name if output.unit == UNKNOWN else f"{output.name} [{output.unit}]"
