"""`tendon-mj simulate`: the finger along a trajectory, with friction and without."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tyro

from tendon_mj.builders.finger import Finger
from tendon_mj.builders.library import load_model, load_spec
from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.finger.control import rehearse
from tendon_mj.finger.control import simulate as follow
from tendon_mj.finger.tracking_error import tracking_error
from tendon_mj.finger.trajectories import Trajectory, clamped, find_trajectory
from tendon_mj.recordings.recording import Recording, write_recording
from tendon_mj.verification.finger_step_cost import step_cost
from tendon_mj.view.figures.finger import finger_figure
from tendon_mj.view.render.clip import render_clip

WITHOUT = "friction 0"


def simulate(
    model: Annotated[Literal["finger", "finger_spring"], tyro.conf.Positional],
    motion: str = "curl",
    out: Path = Path("out/simulate"),
    friction: float | None = None,
    clamp: bool = False,
    clip: bool = True,
) -> dict[str, object]:
    """Let the finger follow joint angles or tendon tensions, with friction and without.

    Args:
        model: the finger, or its variant with springs in place of the extensor.
        motion: curl, tap, press, hold, or a CSV with time_s and either mcp_rad, pip_rad, dip_rad or
            flexor_N, extensor_N.
        out: folder for the recordings, the plots, the clip and result.json.
        friction: mu of the sheaths in place of the model's.
        clamp: take what lies beyond a joint's range, or a motor's strength, at the range instead of
            refusing it.
        clip: whether to render an MP4 (of the motion with friction).
    """
    trajectory = find_trajectory(motion)
    if clamp:
        trajectory = clamped(trajectory, Finger())
    label = "friction as in the model" if friction is None else f"friction {friction:g}"
    runs = {label: friction} if friction == 0.0 else {label: friction, WITHOUT: 0.0}
    stems = {name: _stem(trajectory, name) for name in runs}
    _keep(Path(motion), out, stems.values())
    output, compiled = Output(out), load_model(model)
    answers: dict[str, Recording] = {}
    result: dict[str, object] = {"model": model, "motion": trajectory.name}
    for name, value in runs.items():
        answer = follow(trajectory, compiled, name=model, friction=value)
        answers[name] = answer
        result[name] = {**_summary(answer), "tracking": _tracking(answer)}
        output.add(write_recording(answer, out / f"{stems[name]}.csv"))
    output.figure(trajectory.name, finger_figure(answers))
    if model == "finger" and not trajectory.by_tension:
        finger = Finger() if friction is None else dataclasses.replace(Finger(), friction=friction)
        with_friction, without = step_cost(finger, trajectory)
        result["step_cost"] = {"ratio": with_friction / without, "step_s": with_friction}
    if clip:
        _render(output, trajectory, model, friction, result)
    output.result(result)
    _say(answers, result)
    output.close()
    return result


def _stem(trajectory: Trajectory, run: str) -> str:
    """What a run's recording is called, without ending."""
    return f"{trajectory.name}_frictionless" if run == WITHOUT else trajectory.name


def _keep(motion: Path, out: Path, stems: Iterable[str]) -> None:
    """Refuse to write a recording over the table that it follows."""
    for stem in stems:
        path = out / f"{stem}.csv"
        if path.exists() and motion.exists() and path.samefile(motion):
            raise InvalidValueError(
                f"--out {out}: the recording {path.name} would take the place of the motion "
                f"{motion}; choose another folder"
            )


def _summary(answer: Recording) -> dict[str, float]:
    columns = answer.columns
    numbers = {"tip_force_max_N": float(columns["tip_force_N"].max())}
    ratio = columns["flexor_input_tension_N"] / np.maximum(columns["flexor_output_tension_N"], 1e-3)
    numbers["flexor_input_over_output_max"] = float(ratio.max())
    numbers["flexor_input_over_output_min"] = float(ratio.min())
    return numbers


def _tracking(answer: Recording) -> dict[str, dict[str, float]]:
    return {
        column: {"rmse": error.rmse, "largest": error.largest, "bias": error.bias}
        for column, error in tracking_error(answer).items()
    }


def _render(
    output: Output,
    trajectory: Trajectory,
    model: str,
    friction: float | None,
    result: dict[str, object],
) -> None:
    spec = load_spec(model, scene=True)
    if friction is not None:
        for plugin in [p for p in spec.plugins if "friction" in p.config]:
            plugin.config = {**plugin.config, "friction": repr(friction)}
    ready, controls = rehearse(trajectory, spec.compile(), Finger())
    duration = float(trajectory.time[-1])
    try:
        with progress_bar() as progress:
            path = render_clip(
                ready,
                controls,
                output.folder / f"{trajectory.name}.mp4",
                duration=duration,
                progress=progress,
            )
    except EngineError as error:  # a machine without GL still gets the rest
        console.print(f"no clip: {error}", soft_wrap=True)
        result["clip"] = None
        return
    result["clip"] = output.add(path).name


def _say(answers: dict[str, Recording], result: dict[str, object]) -> None:
    for label, answer in answers.items():
        numbers = _summary(answer)
        low, high = numbers["flexor_input_over_output_min"], numbers["flexor_input_over_output_max"]
        console.print(
            f"{label}: flexor tension in over out {low:.2f} to {high:.2f}, "
            f"tip force up to {numbers['tip_force_max_N']:.2f} N",
            soft_wrap=True,
        )
        off = [f"{c} {e['rmse']:.3g}" for c, e in _tracking(answer).items()]
        console.print(f"  off what was asked, rms: {', '.join(off)}", soft_wrap=True)
    cost = result.get("step_cost")
    if isinstance(cost, dict):
        console.print(
            f"a step takes {cost['step_s'] * 1e6:.1f} µs, {cost['ratio']:.2f} × that of the finger "
            "with MuJoCo's own tendons"
        )
