"""Makes the pictures of the README and of the models: `docs/overview.png`, `models/*/*.png`.

`python -m experiments.make_pictures`, where OpenGL is available.
"""

from __future__ import annotations

import io
import math
import tempfile
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont, ImageOps

from tendon_mj.builders import Bench, load_model
from tendon_mj.finger import prepare_finger, tap
from tendon_mj.replay import Drive, default_motion, record_frames
from tendon_mj.verification import slow_loop
from tendon_mj.view import INK, Offscreen, find_camera, loops_figure, render_clip

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"
PULLED = 0.7, 0.8  # time at which the bench's tendon is pulled hard, duration of the clip [s]
TAPPED = 0.5, 3.0  # time at which the finger touches the object, duration of the clip [s]
FPS = 30
TURNED = math.radians(60.0)  # of the joint's spool
WIDE, CLOSE = (890, 684), (498, 338)  # views of the joint [pixels]
GAP, FRAME, GREY = 12, 1, (205, 205, 205)


def frame(
    model: mujoco.MjModel, drive: Drive | ArrayLike, moment: float, duration: float
) -> Image.Image:
    """Frame of the clip that `tendon-mj render` and `simulate` make."""
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.mp4"
        render_clip(model, record_frames(model, drive, duration=duration, fps=FPS), clip)
        frames = imageio_ffmpeg.read_frames(clip)
        size = next(frames)["size"]
        picture = [np.frombuffer(f, np.uint8) for f in frames][round(moment * FPS)]
    return Image.fromarray(picture.reshape(size[1], size[0], 3))


def turned_joint(model: mujoco.MjModel) -> mujoco.MjData:
    """Simulate the joint until it is at rest after its spool has turned."""
    data = mujoco.MjData(model)
    while data.time < 3.0:
        data.ctrl[model.actuator("command").id] = TURNED * min(data.time, 1.0)
        mujoco.mj_step(model, data)
    return data


def draw_joint(model: mujoco.MjModel, data: mujoco.MjData) -> Image.Image:
    """Draw the joint in three views: all of it, its hinge and its spool."""
    followed = math.degrees(data.sensor("joint_angle").data[0])
    turned = math.degrees(data.sensor("spool_angle").data[0])
    views = {
        "view": (WIDE, "0.7 m of sheath, bent by 120°, with both tendons in it", (0, 0)),
        "hinge": (CLOSE, f"hinge: follows to {followed:.0f}°", (1, 0)),
        "spool": (CLOSE, f"motor's spool: turned to {turned:.0f}°", (1, 1)),
    }
    size = WIDE[0] + CLOSE[0] + 3 * GAP + 4 * FRAME, WIDE[1] + 2 * GAP + 2 * FRAME
    sheet = Image.new("RGB", size, "white")
    font = ImageFont.truetype(findfont("DejaVu Sans"), 18)
    for camera, ((width, height), text, (column, row)) in views.items():
        with Offscreen(model, width, height) as stage:
            shot = Image.fromarray(stage.draw(data, find_camera(model, camera)))
        ImageDraw.Draw(shot).text((20, height - 26), text, fill=INK, font=font, anchor="lm")
        place = (
            GAP + column * (WIDE[0] + 2 * FRAME + GAP),
            GAP + row * (WIDE[1] - CLOSE[1]),
        )
        sheet.paste(ImageOps.expand(shot, FRAME, GREY), place)
    return sheet


def as_image(figure: Figure) -> Image.Image:
    """Image of a figure at the resolution of `tendon-mj`."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=160)
    with Image.open(file) as picture:
        return picture.convert("RGB")


def main() -> None:
    """Write every picture."""
    bench = load_model("bench", scene=True)
    shot = frame(bench, default_motion("bench", bench), *PULLED)
    shot.save(MODELS / "bench" / "bench.png")
    joint = load_model("joint", scene=True)
    draw_joint(joint, turned_joint(joint)).save(MODELS / "joint" / "joint.png", optimize=True)
    prepared, controls = prepare_finger(tap(), load_model("finger", scene=True))
    frame(prepared.model, controls, *TAPPED).save(MODELS / "finger" / "finger.png", optimize=True)
    right = as_image(loops_figure(Bench(), slow_loop(Bench())))
    right = right.resize((round(right.width * shot.height / right.height), shot.height))
    both = Image.new("RGB", (shot.width + right.width, shot.height), "white")
    both.paste(shot, (0, 0))
    both.paste(right, (shot.width, 0))
    both.save(ROOT / "docs" / "overview.png", optimize=True)


if __name__ == "__main__":
    main()
