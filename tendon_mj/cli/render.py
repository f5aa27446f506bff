"""`tendon-mj render` and `view`: a model in motion, as a clip or in a window or browser."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import mujoco
import tyro

from tendon_mj.cli.options import given_files
from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import find_motion
from tendon_mj.lab.replay import check_frames, frictionless, record_frames
from tendon_mj.models import load_model, model_names, model_path
from tendon_mj.show import check_size, find_camera, render_clip
from tendon_mj.show.live import open_window, prepare, serve

DURATION = 6.0  # of a clip of a model without a motion of its own [s]


def render(
    model: tyro.conf.Positional[str],
    out: Path = Path("out/render"),
    duration: float | None = None,
    motion: str | None = None,
    camera: str | None = None,
    size: str = "1280x720",
    fps: float = 30.0,
    twin: bool = True,
) -> dict[str, object]:
    """Write an MP4 of a model in motion, its tendons coloured by their tension.

    Behind the model stands its frictionless twin in grey, under the same drive.

    Args:
        model: bench, joint, finger, finger_spring, or the path of an MJCF file.
        out: folder for the clip and result.json.
        duration: of the clip in seconds; default: that of the motion, or 6.
        motion: of a finger: curl, tap, press, hold or a CSV as for simulate; default: curl. Of any
            other model: a CSV with time_s and a column for every actuator that moves, like
            command_rad; default: each slowly through its control range, or through -1 to 1 where
            it has none.
        camera: name of one of the model's cameras; default: its first.
        size: width x height of the clip in pixels, like 1280x720.
        fps: frames per second.
        twin: whether to draw the frictionless twin.

    Example:
        tendon-mj render finger --motion press --duration 4
    """
    output = Output(out, writes=("*.mp4",), given=[*given_files(models=[model]), motion])
    width, height = _size(size)
    check_size(width, height)
    name = model_path(model).stem
    compiled = load_model(model, scene=True)
    find_camera(compiled, camera)
    if duration is not None:
        check_frames(compiled, duration, fps)
    chosen = find_motion(name, compiled, motion, duration)
    own_length = chosen.duration if math.isfinite(chosen.duration) else DURATION
    length = own_length if duration is None else duration
    if motion is None and name not in model_names():
        _print_what_moves(compiled)
    moving = chosen.prepared(compiled)
    without = frictionless(moving) if twin else {}
    record = partial(record_frames, moving, chosen.drive, duration=length, fps=fps)
    with progress_bar() as progress:
        frames = record(progress=progress)
        path = render_clip(
            moving,
            frames,
            out / f"{name}.mp4",
            width=width,
            height=height,
            camera=camera,
            twin=record(parameters=without) if without else None,
            progress=progress,
        )
    output.add(path)
    shown = len(frames.time) / fps
    result: dict[str, object] = {"clip": path.name, "duration_s": shown}
    output.result(result)
    moved = "" if (frames.poses != frames.poses[0]).any() else ", in which nothing moves"
    tensions = [tension for cable in frames.cables.values() for tension in cable.tensions.flat]
    span = (
        f"tensions from {min(tensions):.1f} to {max(tensions):.1f} N" if tensions else "no sheath"
    )
    output.close(
        f"{path.name} shows {shown:.3g} s of {name}{moved}, with {span}, at {fps:g} frames/s, "
        f"{width} x {height}."
    )
    return result


def view(
    model: tyro.conf.Positional[str],
    motion: str | None = None,
    web: bool = False,
    port: int = 8080,
    seconds: float | None = None,
) -> None:
    """Watch a model move, its tendons coloured by their tension, with the tensions as curves.

    Args:
        model: bench, joint, finger, finger_spring, or the path of an MJCF file.
        motion: of the finger: curl, tap, press, hold or a CSV of joint angles or tensions; of any
            other model a CSV with time_s and a column for each actuator.
        web: whether to serve a page for a browser, with sliders for friction and all other live
            parameters, instead of opening MuJoCo's viewer, which needs a screen.
        port: of that page; where it is taken, the next one that is free.
        seconds: after which to end; by default when the window is closed, or at Ctrl-C.

    Example:
        tendon-mj view finger --motion press --web
    """
    if seconds is not None and not seconds > 0.0:
        raise InvalidValueError(f"--seconds {seconds:g} must be greater than 0")
    prepared = prepare(model, motion)
    if prepared.still:
        console.print(f"{model} does not move: {prepared.still}")
    if web:
        done = serve(prepared, port=port, seconds=seconds, announce=console.print)
    else:
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


def _print_what_moves(compiled: mujoco.MjModel) -> None:
    """Print the source of the motion of a model without control ranges."""
    free = [
        compiled.actuator(k).name or f"actuator {k}"
        for k in range(compiled.nu)
        if not compiled.actuator_ctrllimited[k] and compiled.actuator_plugin[k] < 0
    ]
    if not compiled.nu:
        console.print("the model has no actuator: only gravity and springs move it")
    elif free:
        console.print(f"without ctrlrange, so moved through -1 to 1: {', '.join(free)}")
