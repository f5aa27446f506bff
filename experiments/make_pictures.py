"""Makes the pictures of the README and of the models: `docs/finger.*`, `models/*/*.png`.

`python -m experiments.make_pictures`, where OpenGL is available; with the names of some, like
`finger`, only these.
"""

from __future__ import annotations

import itertools
import math
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
from matplotlib.font_manager import findfont
from PIL import Image, ImageDraw, ImageFont, ImageOps

from tendon_mj.lab.finger import lasting, press, simulate_finger
from tendon_mj.lab.frames import FrameRecorder, Frames
from tendon_mj.lab.motion import Drive, default_motion, record_frames
from tendon_mj.models import load_model
from tendon_mj.show import Offscreen, draw_frames, find_camera, render_clip, style

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"
PULLED = 0.7, 0.8  # time at which the bench's tendon is pulled hard, duration of the clip [s]
PRESSED, HELD = 4.0, 2.0  # duration of the finger's clip, time at which it presses hardest [s]
PRESS_SIZE, PRESS_FPS, PRESS_QUALITY = (900, 440), 15, 72
FPS = 30
TURNED = math.radians(60.0)  # of the joint's spool
WIDE, CLOSE = (890, 684), (498, 338)  # views of the joint [pixels]
GAP, FRAME, GREY = 12, 1, (205, 205, 205)


def frame(model: mujoco.MjModel, drive: Drive, moment: float, duration: float) -> Image.Image:
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
        ImageDraw.Draw(shot).text(
            (20, height - 26), text, fill=style.LIGHT.ink, font=font, anchor="lm"
        )
        place = (
            GAP + column * (WIDE[0] + 2 * FRAME + GAP),
            GAP + row * (WIDE[1] - CLOSE[1]),
        )
        sheet.paste(ImageOps.expand(shot, FRAME, GREY), place)
    return sheet


def press_frames(fps: float) -> tuple[Frames, Frames]:
    """The finger presses once: frames with friction, and without."""
    model, trajectory = load_model("finger"), lasting(press(), PRESSED)
    recorders = [FrameRecorder(fps), FrameRecorder(fps)]
    for recorder, friction in zip(recorders, (None, 0.0), strict=True):
        simulate_finger(trajectory, model, friction=friction, recorder=recorder)
    with_friction, without = (recorder.frames() for recorder in recorders)
    return with_friction, without


def draw_finger() -> None:
    """The README's clip and still, for light pages and dark, and the picture of the model."""
    scene = load_model("finger", scene=True)
    frames, twin = press_frames(PRESS_FPS)
    scene.material("floor").rgba[3] = 0.0
    width, height = PRESS_SIZE
    for name, dark in (("finger", False), ("finger_dark", True)):
        drawn = draw_frames(
            scene, frames, width=width, height=height, camera="hand", twin=twin, dark=dark
        )
        first, *others = [Image.fromarray(image) for image in drawn]
        still = [first, *others][round(HELD * PRESS_FPS)]
        still.save(ROOT / "docs" / f"{name}.png", optimize=True)
        first.save(
            ROOT / "docs" / f"{name}.webp",
            save_all=True,
            append_images=others,
            duration=round(1000 / PRESS_FPS),
            loop=0,
            quality=PRESS_QUALITY,
            method=6,
        )
    close = draw_frames(scene, frames, width=1280, height=720, camera="finger", twin=twin)
    pressing = next(itertools.islice(close, round(HELD * PRESS_FPS), None))
    Image.fromarray(pressing).save(MODELS / "finger" / "finger.png", optimize=True)


def draw_bench() -> None:
    """The picture of the bench."""
    bench = load_model("bench", scene=True)
    shot = frame(bench, default_motion("bench", bench), *PULLED)
    shot.save(MODELS / "bench" / "bench.png", optimize=True)


def draw_joint_views() -> None:
    """The picture of the joint."""
    joint = load_model("joint", scene=True)
    draw_joint(joint, turned_joint(joint)).save(MODELS / "joint" / "joint.png", optimize=True)


PICTURES = {"bench": draw_bench, "joint": draw_joint_views, "finger": draw_finger}


def main(names: Sequence[str]) -> None:
    """Write the pictures of these names, or every one."""
    for name in names or PICTURES:
        PICTURES[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
