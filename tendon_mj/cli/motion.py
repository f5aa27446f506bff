"""`tendon-mj render`, `view` and `simulate`: models in motion, as clips, in a window or browser."""

from __future__ import annotations

import glob
import math
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import mujoco
import numpy as np
import tyro

from tendon_mj.cli.options import given_files
from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.lab import finger
from tendon_mj.lab.frames import FrameRecorder, Frames, check_frames
from tendon_mj.lab.friction_effect import friction_sentence, most_first, sheathed_tendons
from tendon_mj.lab.motion import demonstration_time, frictionless, record_frames, without_range
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.units import force_unit
from tendon_mj.models import Finger, load_model, model_names, model_path
from tendon_mj.show import check_size, draw_frames, find_camera, finger_figure, render_clip
from tendon_mj.show.live import open_window, prepare, serve

FingerModel = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="{finger,finger_spring}")]
_WITHOUT = "friction 0"
_SOME = 12.0  # duration of a motion for a check of frames, at most [s]
_LONG = 10.0  # expected time of a clip that is printed [s]


def render(
    model: tyro.conf.Positional[str],
    out: Path = Path("out/render"),
    duration: float | None = None,
    motion: str | None = None,
    tendon: str | None = None,
    camera: str | None = None,
    size: str = "1280x720",
    fps: float = 30.0,
    twin: bool = True,
) -> dict[str, object]:
    """Write an MP4 of a model in motion, its tendons coloured by their tension.

    Behind the model stands its frictionless twin in grey, under the same drive.

    Args:
        model: MJCF file, or a model of the package: bench, joint, finger, finger_spring.
        out: Folder for the clip and result.json.
        duration: Duration of the clip. By default that of the motion, or until every actuator has
            moved, 6 to 12 s.
        motion: Motion of the finger: curl, tap, press, hold, or a CSV file as for simulate. Motion
            of any other model: a CSV file with time_s and a column for each actuator that moves,
            such as command_rad. By default the finger curls, and the actuators of any other model
            go one after the other through four fifths of their control range, or from -1 to 1
            without one. It begins at the first keyframe, or where actuators have no force.
        tendon: Name or pattern, such as "index*", of the tendons that are coloured and whose
            tensions are shown; by default also only these are pulled. Without it all are, and those
            that lose most by friction have numbers.
        camera: Name of a camera of the model. By default the first that shows the tendons, or one
            that frames them.
        size: Width and height of the clip in pixels.
        fps: Frames per second.
        twin: Draw the frictionless twin.

    Example:
        tendon-mj render finger --motion press --duration 4
    """
    output = Output(out, writes=("*.mp4",), given=[*given_files(models=[model]), motion])
    width, height = _size(size)
    check_size(width, height)
    name = model_path(model).stem
    compiled = load_model(model, scene=True)
    find_camera(compiled, camera)
    check_frames(compiled, _SOME if duration is None else duration, fps)
    tendons = sheathed_tendons(compiled, tendon) if tendon else None
    chosen = finger.find_motion(name, compiled, motion, duration, tendons)
    length = duration if duration is not None else chosen.duration
    if not math.isfinite(length):
        length = demonstration_time(compiled, tendons)
    if motion is None and name not in model_names():
        _print_what_moves(compiled)
    moving = chosen.prepared(compiled)
    without = frictionless(moving) if twin else {}
    record = partial(record_frames, moving, chosen.drive, fps=fps, at_rest=True)
    draw: Any = {"width": width, "height": height, "camera": camera}
    _print_time(moving, record, bool(without), length, fps, draw)
    with progress_bar() as progress:
        frames = most_first(moving, record(duration=length, progress=progress), tendons)
        other = record(duration=length, parameters=without, progress=progress) if without else None
        caption = friction_sentence(moving, frames, other)
        path = render_clip(
            moving,
            frames,
            out / f"{name}.mp4",
            twin=other,
            caption=caption,
            progress=progress,
            **draw,
        )
    output.add(path)
    shown = len(frames.time) / fps
    moved = "" if (frames.poses != frames.poses[0]).any() else ", in which nothing moves"
    ends = [f(cable.tensions) for cable in frames.cables.values() for f in (np.nanmin, np.nanmax)]
    unit, span = force_unit(ends), "no sheath"
    if ends:
        low, high = (unit.factor * end for end in (min(ends), max(ends)))
        span = f"tensions from {low:.1f} to {high:.1f} {unit.symbol}"
    sentence = (
        f"{path.name} shows {shown:.3g} s of {name}{moved}, with {span}, at {fps:g} frames/s, "
        f"{width} x {height}.{f' {caption}' if caption else ''}"
    )
    return output.finish({"clip": path.name, "duration_s": shown}, sentence)


def view(
    model: tyro.conf.Positional[str],
    motion: str | None = None,
    tendon: str | None = None,
    web: bool = False,
    port: int = 8080,
    seconds: float | None = None,
) -> None:
    """Watch a model move, its tendons coloured by their tension, with the tensions as curves.

    Args:
        model: MJCF file, or a model of the package: bench, joint, finger, finger_spring.
        motion: Motion of the finger: curl, tap, press, hold, or a CSV file of joint angles or
            tensions. Motion of any other model: a CSV file with time_s and a column for each
            actuator that moves. It begins at the first keyframe, or where actuators have no force.
        tendon: Name or pattern, such as "index*", of the tendons whose tensions are shown; by
            default also only these are pulled.
        web: Serve a page for a browser, with sliders for friction and all other live parameters,
            instead of opening MuJoCo's viewer, which needs a screen.
        port: Port of that page. If it is taken, the next free port is used.
        seconds: Time after which the view ends. By default it ends when the window is closed, or at
            Ctrl-C.

    Example:
        tendon-mj view finger --motion press --web
    """
    if seconds is not None and not seconds > 0.0:
        raise InvalidValueError(f"--seconds {seconds:g} must be greater than 0")
    with progress_bar() as progress:
        prepared = prepare(model, motion, tendon, progress)
    if prepared.sentence:
        console.print(prepared.sentence)
    if prepared.still:
        console.print(f"{prepared.still}: only gravity and springs move it")
    if web:
        done = serve(prepared, port=port, seconds=seconds, announce=console.print)
    else:
        console.print("the space bar halts it, and Tab shows MuJoCo's panel of settings")
        done = open_window(prepared, seconds)
    console.print(done.sentence())


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        return int(width), int(height)
    except ValueError:
        raise InvalidValueError(
            f"--size {text}: give width x height in pixels, like 1280x720"
        ) from None


def _print_time(
    model: mujoco.MjModel,
    record: Callable[..., Frames],
    has_twin: bool,
    length: float,
    fps: float,
    draw: Mapping[str, Any],
) -> None:
    """Print the time that a clip will take, from two of its frames, and what makes it shorter."""
    begin = time.perf_counter()
    frames = record(duration=2.0 / fps)
    simulated = time.perf_counter()
    pictures = draw_frames(model, frames, **draw)
    next(pictures)  # which takes longer than the others
    first = time.perf_counter()
    next(pictures)
    a_picture, a_frame = time.perf_counter() - first, 0.5 * (simulated - begin)
    expected = length * fps * (1 + has_twin) * (a_frame + a_picture)
    if expected > _LONG:
        console.print(
            f"this takes about {expected:.0f} s; a shorter --duration, fewer --fps, a smaller"
            f" --size{' and --no-twin' if has_twin else ''} make it less"
        )


def _print_what_moves(compiled: mujoco.MjModel) -> None:
    """Print the source of the motion of a model without control ranges."""
    swung = np.flatnonzero(without_range(compiled) & (compiled.actuator_plugin < 0))
    free = [compiled.actuator(k).name or f"actuator {k}" for k in swung]
    if not compiled.nu:
        console.print("the model has no actuator: only gravity and springs move it")
    elif free:
        console.print(f"without ctrlrange, so moved through -1 to 1: {', '.join(free)}")


def simulate(
    model: FingerModel,
    motion: str = "curl",
    out: Path = Path("out/simulate"),
    friction: float | None = None,
    clamp: bool = False,
    clip: bool = True,
) -> dict[str, object]:
    """Let the finger follow joint angles or tendon tensions, with friction and without.

    Args:
        model: The finger, or finger_spring, which has springs in place of the extensor.
            The commands view and render show any model in motion.
        motion: Motion to follow: curl, tap, press, hold, or a CSV file with time_s and either
            mcp_rad, pip_rad, dip_rad or flexor_N, extensor_N.
        out: Folder for the recordings, the plots, the clip and result.json.
        friction: Friction coefficient mu of the sheaths, in place of the model's.
        clamp: Clip values outside a joint's range, or a motor's strength, instead of refusing them.
        clip: Render an MP4 of the finger with friction, and behind it in grey without.

    Example:
        tendon-mj simulate finger --motion press --friction 0.2
    """
    finger.check_finger(model)
    label = "friction as in the model" if friction is None else f"friction {friction:g}"
    runs = {label: friction} if friction == 0.0 else {label: friction, _WITHOUT: 0.0}
    stem = Path(motion).stem
    stems = {name: f"{stem}_frictionless" if name == _WITHOUT else stem for name in runs}
    writes = [glob.escape(f"{name}.csv") for name in stems.values()]
    output = Output(out, writes=writes, given=[motion])
    trajectory = finger.find_trajectory(motion)
    if clamp:
        trajectory = finger.clamped(trajectory, Finger())
    compiled = load_model(model)
    recorders = {name: FrameRecorder() if clip else None for name in runs}
    answers: dict[str, Recording] = {}
    result: dict[str, Any] = {"model": model, "motion": trajectory.name}
    for name, value in runs.items():
        answer = finger.simulate_finger(
            trajectory, compiled, name=model, friction=value, recorder=recorders[name]
        )
        answers[name] = answer
        result[name] = {**finger.summarise(answer), "tracking": _tracking(answer)}
        output.add(write_recording(answer, out / f"{stems[name]}.csv"))
    output.figure(trajectory.name, finger_figure(answers))
    if clip:
        result["clip"] = _write_clip(output, trajectory.name, model, recorders.values())
    _print_tracking(answers, result)
    return output.finish(result, _loss_sentence({label: result[label] for label in answers}))


def _loss_sentence(summaries: Mapping[str, Mapping[str, float]]) -> str:
    text = "; ".join(
        f"with {label} the flexor loses up to {1.0 - 1.0 / s['flexor_input_over_output_max']:.0%}"
        f" of its tension and the tip presses with up to {s['tip_force_max_N']:.2f} N"
        for label, s in summaries.items()
    )
    return f"{text[0].upper()}{text[1:]}."


def _tracking(answer: Recording) -> dict[str, dict[str, float]]:
    return {
        column: {"rmse": error.rmse, "largest": error.largest, "bias": error.bias}
        for column, error in finger.tracking_error(answer).items()
    }


def _write_clip(
    output: Output, name: str, model: str, recorders: Iterable[FrameRecorder | None]
) -> str | None:
    """Write the clip, and return the name of its file; None on a machine that cannot draw."""
    frames, *twin = (recorder.frames() for recorder in recorders if recorder)
    scene = load_model(model, scene=True)
    path = output.folder / f"{name}.mp4"
    try:
        with progress_bar() as progress:
            render_clip(scene, frames, path, twin=twin[0] if twin else None, progress=progress)
    except EngineError as error:
        console.print(f"no clip: {error}")
        return None
    return output.add(path).name


def _print_tracking(labels: Iterable[str], result: Mapping[str, Any]) -> None:
    for label in labels:
        run = result[label]
        console.print(
            f"{label}: flexor T_in/T_out {run['flexor_input_over_output_min']:.2f} to "
            f"{run['flexor_input_over_output_max']:.2f}, tip force up to "
            f"{run['tip_force_max_N']:.2f} N"
        )
        errors = [f"{column} {error['rmse']:.3g}" for column, error in run["tracking"].items()]
        console.print(f"  tracking error, rms: {', '.join(errors)}")
