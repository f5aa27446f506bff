"""`tendon-mj render`: an offscreen clip of a model with its tendons drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import tyro
from numpy.typing import ArrayLike

from tendon_mj.builders.finger import Finger
from tendon_mj.builders.library import load_model, model_path
from tendon_mj.cli.output import Output, progress_bar
from tendon_mj.finger.control import rehearse
from tendon_mj.finger.trajectories import curl
from tendon_mj.replay.default_motion import default_motion
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
    """
    output = Output(out)
    name = model_path(model).stem
    compiled = load_model(model, scene=True)
    drive: Callable[[float], ArrayLike] | ArrayLike = default_motion(name, compiled)
    if name in ("finger", "finger_spring"):
        compiled, drive = rehearse(curl(), compiled, Finger())
    with progress_bar() as progress:
        path = render_clip(
            compiled,
            drive,
            out / f"{name}.mp4",
            duration=duration,
            progress=progress,
        )
    output.add(path)
    result: dict[str, object] = {"clip": path.name, "duration_s": duration}
    output.result(result)
    output.close()
    return result
