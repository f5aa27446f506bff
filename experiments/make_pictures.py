"""Makes the pictures of the README and of the bench: `docs/overview.png`, `models/bench/bench.png`.

Run it where OpenGL is to be had.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from PIL import Image

from tendon_mj.simulate.bench import Bench
from tendon_mj.simulate.comparison import slow_loop
from tendon_mj.simulate.library import load_model
from tendon_mj.view.clip import render_clip
from tendon_mj.view.loops import bench_loops_figure
from tendon_mj.view.motion import default_motion

ROOT = Path(__file__).parents[1]
MOMENT = 0.7  # of the clip at which the tendon is pulled hard [s]
FPS = 30


def frame(model: str, moment: float) -> Image.Image:
    """A picture out of the clip that `tendon-mj render` makes."""
    compiled = load_model(model, scene=True)
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.mp4"
        render_clip(compiled, default_motion(model, compiled), clip, duration=moment + 0.1, fps=FPS)
        frames = imageio_ffmpeg.read_frames(clip)
        size = next(frames)["size"]
        picture = [np.frombuffer(f, np.uint8) for f in frames][round(moment * FPS)]
    return Image.fromarray(picture.reshape(size[1], size[0], 3))


def loops(bench: Bench, folder: Path) -> Image.Image:
    """The loops that `tendon-mj compare` draws."""
    figure = bench_loops_figure(bench, slow_loop(bench))
    figure.savefig(folder / "loops.png", dpi=160)
    with Image.open(folder / "loops.png") as picture:
        return picture.convert("RGB")


def main() -> None:
    """Write both pictures."""
    shot = frame("bench", MOMENT)
    shot.save(ROOT / "models" / "bench" / "bench.png")
    with tempfile.TemporaryDirectory() as folder:
        right = loops(Bench(), Path(folder))
    right = right.resize((round(right.width * shot.height / right.height), shot.height))
    both = Image.new("RGB", (shot.width + right.width, shot.height), "white")
    both.paste(shot, (0, 0))
    both.paste(right, (shot.width, 0))
    both.save(ROOT / "docs" / "overview.png", optimize=True)


if __name__ == "__main__":
    main()
