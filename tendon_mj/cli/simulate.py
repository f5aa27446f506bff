"""`tendon-mj simulate`: the finger along a trajectory, with friction and without."""

from __future__ import annotations

import glob
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import tyro

from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.errors import EngineError
from tendon_mj.lab.finger import (
    clamped,
    find_trajectory,
    simulate_finger,
    summarise,
    tracking_error,
)
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.replay import FrameRecorder, Frames
from tendon_mj.lab.verification import finger_step_cost
from tendon_mj.models import Finger, load_model
from tendon_mj.show import finger_figure, render_clip

_WITHOUT = "friction 0"


def simulate(
    model: tyro.conf.Positional[Literal["finger", "finger_spring"]],
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
        clamp: clip values outside a joint's range, or a motor's strength, instead of refusing them.
        clip: whether to render an MP4: with friction, and in grey behind it without.

    Example:
        tendon-mj simulate finger --motion press --friction 0.2
    """
    label = "friction as in the model" if friction is None else f"friction {friction:g}"
    runs = {label: friction} if friction == 0.0 else {label: friction, _WITHOUT: 0.0}
    stem = Path(motion).stem
    stems = {name: f"{stem}_frictionless" if name == _WITHOUT else stem for name in runs}
    writes = [glob.escape(f"{name}.csv") for name in stems.values()]
    output = Output(out, writes=writes, given=[motion])
    trajectory = find_trajectory(motion)
    if clamp:
        trajectory = clamped(trajectory, Finger())
    compiled = load_model(model)
    recorders = {name: FrameRecorder() if clip else None for name in runs}
    answers: dict[str, Recording] = {}
    result: dict[str, Any] = {"model": model, "motion": trajectory.name}
    for name, value in runs.items():
        answer = simulate_finger(
            trajectory, compiled, name=model, friction=value, recorder=recorders[name]
        )
        answers[name] = answer
        errors = tracking_error(answer)
        tracking = {
            column: {"rmse": error.rmse, "largest": error.largest, "bias": error.bias}
            for column, error in errors.items()
        }
        result[name] = {**summarise(answer), "tracking": tracking}
        output.add(write_recording(answer, out / f"{stems[name]}.csv"))
    output.figure(trajectory.name, finger_figure(answers))
    if model == "finger" and not trajectory.by_tension:
        cost = finger_step_cost(trajectory, friction=friction)
        result["step_cost"] = {"ratio": cost.ratio, "step_s": cost.step}
    if clip:
        frames = [recorder.frames() for recorder in recorders.values() if recorder]
        result["clip"] = _write_clip(output, trajectory.name, model, frames)
    output.result(result)
    _print_summary(answers, result)
    output.close(_sentence({label: result[label] for label in answers}))
    return result


def _sentence(summaries: Mapping[str, Mapping[str, float]]) -> str:
    text = "; ".join(
        f"with {label} the flexor loses up to {1.0 - 1.0 / s['flexor_input_over_output_max']:.0%}"
        f" of its tension and the tip presses with up to {s['tip_force_max_N']:.2f} N"
        for label, s in summaries.items()
    )
    return f"{text[0].upper()}{text[1:]}."


def _write_clip(output: Output, name: str, model: str, recorded: Sequence[Frames]) -> str | None:
    """Write the clip, and return the name of its file; None on a machine that cannot draw."""
    frames, *twin = recorded
    scene = load_model(model, scene=True)
    path = output.folder / f"{name}.mp4"
    try:
        with progress_bar() as progress:
            render_clip(scene, frames, path, twin=twin[0] if twin else None, progress=progress)
    except EngineError as error:
        console.print(f"no clip: {error}")
        return None
    return output.add(path).name


def _print_summary(labels: Iterable[str], result: Mapping[str, Any]) -> None:
    for label in labels:
        run = result[label]
        console.print(
            f"{label}: flexor T_in/T_out {run['flexor_input_over_output_min']:.2f} to "
            f"{run['flexor_input_over_output_max']:.2f}, tip force up to "
            f"{run['tip_force_max_N']:.2f} N"
        )
        errors = [f"{column} {error['rmse']:.3g}" for column, error in run["tracking"].items()]
        console.print(f"  tracking error, rms: {', '.join(errors)}")
    if cost := result.get("step_cost"):
        console.print(
            f"a step takes {cost['step_s'] * 1e6:.1f} µs, {cost['ratio']:.2f} × that of the finger "
            "with MuJoCo's own tendons"
        )
