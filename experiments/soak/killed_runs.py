"""Commands killed at random moments: files are whole, and the next run completes the work."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from PIL import Image

from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import read_recording

_ORPHANS = 0.5  # in which the workers of a killed run see that they are alone [s]


@dataclass
class KilledRuns:
    """Result of killed runs.

    Attributes:
        kills: number of runs that were killed before they ended.
        ended: number that ended before they would have been killed.
        broken: files that were found half-written.
        repeated: finished parts that a later run did again.
        failed: messages of the first or the last run, which are left alone, if it failed.
    """

    kills: int = 0
    ended: int = 0
    broken: list[str] = field(default_factory=list)
    repeated: list[str] = field(default_factory=list)
    failed: str = ""


def killed_runs(
    command: Sequence[str],
    out: Path,
    kills: int,
    seed: int = 0,
    *,
    finished: str = "",
    progress: Progress = silent,
) -> KilledRuns:
    """Run ``python -m <command> --out <out>``, kill it at random moments, and look at the files.

    Args:
        command: a module and its arguments, without ``--out``.
        out: folder for all runs.
        kills: number of runs to kill; as many may end before, after which all is done anew.
        seed: of the moments.
        finished: pattern of the files in ``out`` that a finished part leaves, which no later run
            may write again; if it is given, the runs begin with an empty folder.
        progress: is told of every run.
    """
    result, draw = KilledRuns(), random.Random(seed)
    whole_command = [sys.executable, "-m", *command, "--out", str(out)]
    began = time.perf_counter()
    first = subprocess.run(whole_command, capture_output=True, text=True)
    longest = time.perf_counter() - began
    if first.returncode != 0:
        result.failed = first.stderr.strip() or f"status {first.returncode}"
        return result
    if finished:
        shutil.rmtree(out)
    done: dict[Path, int] = {}
    while result.kills < kills and result.ended < kills:
        with subprocess.Popen(
            whole_command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as run:
            try:
                run.wait(draw.uniform(0.1, 1.0) * longest)
            except subprocess.TimeoutExpired:
                run.kill()
        ended = run.returncode >= 0  # a signal is negative
        result.ended += ended
        result.kills += not ended
        time.sleep(_ORPHANS)
        result.broken += [str(path) for path in sorted(out.rglob("*")) if not whole(path)]
        _see_finished(out, finished, done, result)
        if ended and finished:  # nothing is left to do
            shutil.rmtree(out)
            done.clear()
        progress(f"kill {command[0]}", result.kills, kills)
    last = subprocess.run(whole_command, capture_output=True, text=True)
    _see_finished(out, finished, done, result)
    if last.returncode != 0 or not any(out.glob(finished or "result.json")):
        result.failed = last.stderr.strip() or f"status {last.returncode}"
    return result


def _see_finished(out: Path, finished: str, done: dict[Path, int], result: KilledRuns) -> None:
    """Compare when finished parts were written with what ``done`` has, and add new ones to it."""
    for path in sorted(out.glob(finished)) if finished else []:
        written = path.stat().st_mtime_ns
        if done.setdefault(path, written) != written:
            result.repeated.append(str(path))


def whole(path: Path) -> bool:
    """Return whether a file is whole; a file that a killed run was writing begins with a dot.

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
