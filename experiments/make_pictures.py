"""Makes the pictures of the README and of the models: `docs/overview.png`, `models/*/*.png`.

Run it where OpenGL is to be had.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
from matplotlib.font_manager import findfont
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont, ImageOps

from tendon_mj.builders.bench import Bench
from tendon_mj.builders.load import load_model
from tendon_mj.finger.control import prepare_finger
from tendon_mj.finger.trajectories import tap
from tendon_mj.replay.default_motion import Drive, default_motion
from tendon_mj.replay.frames import record_frames
from tendon_mj.verification.comparison import slow_loop
from tendon_mj.view.figures.loops import loops_figure
from tendon_mj.view.render.clip import render_clip
from tendon_mj.view.render.offscreen import Offscreen, find_camera
from tendon_mj.view.render.panel import INK

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"
PULLED = 0.7, 0.8  # when the bench's tendon is pulled hard, and how long the clip is [s]
TAPPED = 0.5, 3.0  # when the finger touches the object, the same [s]
FPS = 30
TURNED = math.radians(60.0)  # of the joint's spool
WIDE, CLOSE = (890, 684), (498, 338)  # views of the joint [pixels]
GAP, FRAME, GREY = 12, 1, (205, 205, 205)


def frame(
    model: mujoco.MjModel, drive: Drive | ArrayLike, moment: float, duration: float
) -> Image.Image:
    """A picture out of the clip that `tendon-mj render` and `simulate` make."""
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.mp4"
        render_clip(model, record_frames(model, drive, duration=duration, fps=FPS), clip)
        frames = imageio_ffmpeg.read_frames(clip)
        size = next(frames)["size"]
        picture = [np.frombuffer(f, np.uint8) for f in frames][round(moment * FPS)]
    return Image.fromarray(picture.reshape(size[1], size[0], 3))


def joint() -> Image.Image:
    """The joint at rest after its spool has turned: all of it, its hinge and its spool."""
    model = load_model("joint", scene=True)
    data = mujoco.MjData(model)
    while data.time < 3.0:
        data.ctrl[model.actuator("command").id] = TURNED * min(data.time, 1.0)
        mujoco.mj_step(model, data)
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


def finger() -> Image.Image:
    """The finger as it taps the object."""
    prepared, controls = prepare_finger(tap(), load_model("finger", scene=True))
    return frame(prepared.model, controls, *TAPPED)


def loops(bench: Bench, folder: Path) -> Image.Image:
    """The loops that `tendon-mj compare` draws."""
    figure = loops_figure(bench, slow_loop(bench))
    figure.savefig(folder / "loops.png", dpi=160)
    with Image.open(folder / "loops.png") as picture:
        return picture.convert("RGB")


def main() -> None:
    """Write all of them."""
    bench = load_model("bench", scene=True)
    shot = frame(bench, default_motion("bench", bench), *PULLED)
    shot.save(MODELS / "bench" / "bench.png")
    joint().save(MODELS / "joint" / "joint.png", optimize=True)
    finger().save(MODELS / "finger" / "finger.png", optimize=True)
    with tempfile.TemporaryDirectory() as folder:
        right = loops(Bench(), Path(folder))
    right = right.resize((round(right.width * shot.height / right.height), shot.height))
    both = Image.new("RGB", (shot.width + right.width, shot.height), "white")
    both.paste(shot, (0, 0))
    both.paste(right, (shot.width, 0))
    both.save(ROOT / "docs" / "overview.png", optimize=True)


if __name__ == "__main__":
    main()
