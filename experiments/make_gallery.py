"""Makes the pictures in `docs/gallery`, which the page `docs/gallery.md` shows.

`python -m experiments.make_gallery [NAME…]` runs the command behind each picture, or behind those
that are named, and keeps the picture in the size of a page.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "gallery"
WIDTH = 1000  # [pixels]
COLOURS = 128
# picture -> command without its --out, and the file that it writes there
SOURCES = {
    "compare_loops": ("tendon_mj compare", "loops.png"),
    "compare_convergence": ("tendon_mj compare", "convergence.png"),
    "replay": ("tendon_mj replay models/bench/recordings/twin.csv", "replay.png"),
    "press": ("tendon_mj simulate finger --motion press --no-clip", "press.png"),
    "sweep_friction": ("examples/sweep_friction.py", "sweep_friction.png"),
    "figure_4a": ("experiments.kaneko1991", "figure_4a.png"),
    "figure_5": ("experiments.kaneko1991", "figure_5.png"),
    "force_servo_steps": ("experiments.force_servo", "strategies.png"),
    "force_servo_limit_cycle": ("experiments.force_servo", "limit_cycle.png"),
}


def reduced(picture: Image.Image) -> Image.Image:
    """A picture in the width of a page and few colours."""
    if picture.width > WIDTH:
        size = WIDTH, round(picture.height * WIDTH / picture.width)
        picture = picture.resize(size, Image.Resampling.LANCZOS)
    return picture.convert("RGB").quantize(COLOURS)


def produce(command: str, out: str) -> None:
    """Run a command into a folder; a script writes into the one in which it runs."""
    if command.endswith(".py"):
        subprocess.run([sys.executable, str(ROOT / command)], cwd=out, check=True)
    else:
        given = [sys.executable, "-m", *command.split(), "--out", out]
        subprocess.run(given, cwd=ROOT, check=True)


def main(names: list[str]) -> None:
    """Run each command once and keep its pictures."""
    chosen = {name: SOURCES[name] for name in names} if names else SOURCES
    FOLDER.mkdir(exist_ok=True)
    for command in dict.fromkeys(command for command, _ in chosen.values()):
        with tempfile.TemporaryDirectory() as out:
            produce(command, out)
            for name, (other, file) in chosen.items():
                if other == command:
                    picture = reduced(Image.open(Path(out) / file))
                    picture.save(FOLDER / f"{name}.png", optimize=True)
                    print(FOLDER / f"{name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
