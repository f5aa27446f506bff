"""Commands killed at random moments: what they leave is whole, and the next run does it all."""

from __future__ import annotations

import json
import random
import subprocess
import sys
import time
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from PIL import Image

from tendon_mj.progress import Progress, silent
from tendon_mj.recordings import read_recording


@dataclass
class KilledRuns:
    """What killed runs left.

    Attributes:
        kills: number of runs that were killed before they ended.
        ended: number that ended before they would have been killed.
        broken: files that were found half-written.
        failed: messages of the last run, which was left alone, if it failed.
    """

    kills: int = 0
    ended: int = 0
    broken: list[str] = field(default_factory=list)
    failed: str = ""


def killed_runs(
    arguments: Sequence[str], out: Path, kills: int, seed: int = 0, progress: Progress = silent
) -> KilledRuns:
    """Run ``tendon-mj <arguments> --out <out>``, kill it at random moments, and look at the files.

    Args:
        arguments: of the command, without ``--out``.
        out: folder for all runs.
        kills: number of runs to kill.
        seed: of the moments.
        progress: is told of every run.
    """
    found, draw = KilledRuns(), random.Random(seed)
    command = [sys.executable, "-m", "tendon_mj", *arguments, "--out", str(out)]
    began = time.perf_counter()
    subprocess.run(command, capture_output=True, check=True)
    longest = time.perf_counter() - began
    for k in range(kills):
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
            try:
                run.wait(draw.uniform(0.3, 1.0) * longest)
                found.ended += 1
            except subprocess.TimeoutExpired:
                run.kill()
                found.kills += 1
        found.broken += [str(path) for path in sorted(out.rglob("*")) if not whole(path)]
        progress(f"kill {arguments[0]}", k + 1, kills)
    last = subprocess.run(command, capture_output=True, text=True)
    if last.returncode != 0 or not (out / "result.json").exists():
        found.failed = last.stderr.strip() or f"status {last.returncode}"
    return found


def whole(path: Path) -> bool:
    """Whether a file is no half of one; what a killed run was writing has a name with a dot first.

    A recording's table and description are two files, and either may be missing.
    """
    if not path.is_file() or path.name.startswith("."):
        return True
    try:
        match path.suffix:
            case ".json":
                json.loads(path.read_text("utf-8"))
            case ".toml":
                tomllib.loads(path.read_text("utf-8"))
            case ".xml":
                ElementTree.parse(path)
            case ".png":
                Image.open(path).load()
            case ".html":
                return path.read_text("utf-8").rstrip().endswith("</html>")
            case ".csv" if path.with_suffix(".toml").exists():
                read_recording(path)
    except (ValueError, OSError, ElementTree.ParseError):
        return False
    return True
