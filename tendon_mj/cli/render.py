"""`tendon-mj render`: an offscreen clip of a model with its tendons drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.builders.load import load_model, model_path
from tendon_mj.cli.output import Output, progress_bar
from tendon_mj.finger.control import prepare_finger
from tendon_mj.finger.trajectories import curl
from tendon_mj.replay.default_motion import Drive, default_motion
from tendon_mj.replay.frames import Array, record_frames
from tendon_mj.view.render.clip import render_clip


def render(
    model: Annotated[str, tyro.conf.Positional],
    out: Path = Path("out/render"),
    duration: float = 6.0,
) -> dict[str, object]:
    """Write an MP4 of a model in motion, its tendons coloured by their tension.

    Args:
        model: bench, joint, finger, finger_spring, or the path of an MJCF file.
        out: folder for the clip and result.json.
        duration: of the clip in seconds.

    Example:
        tendon-mj render finger --duration 4
    """
    output = Output(out)
    name = model_path(model).stem
    compiled = load_model(model, scene=True)
    drive: Drive | Array = default_motion(name, compiled)
    if name in ("finger", "finger_spring"):
        prepared, drive = prepare_finger(curl(), compiled)
        compiled = prepared.model
    with progress_bar() as progress:
        frames = record_frames(compiled, drive, duration=duration, progress=progress)
        path = render_clip(compiled, frames, out / f"{name}.mp4", progress=progress)
    output.add(path)
    result: dict[str, object] = {"clip": path.name, "duration_s": duration}
    output.result(result)
    tensions = [tension for cable in frames.cables.values() for tension in cable.tensions.flat]
    span = (
        f"tensions from {min(tensions):.1f} to {max(tensions):.1f} N" if tensions else "no sheath"
    )
    output.close(f"{path.name} shows {duration:g} s of {name}, with {span}.")
    return result
