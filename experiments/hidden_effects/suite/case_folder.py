"""Folders of a suite's cases as any tool reads them, and of its results as the scorer does."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Collection
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.worker_processes import worker_processes
from tendon_mj.errors import TendonError
from tendon_mj.recordings import Recording, read_recording
from tendon_mj.whole_file import whole_file


@dataclass(frozen=True, kw_only=True)
class Case:
    """What a tool is given of a case.

    Attributes:
        name: of its folder.
        train, held_out: recordings to explain, and those that prove it.
        exclude: effects to take out of the catalogue.
    """

    name: str
    train: list[Recording]
    held_out: list[Recording]
    exclude: Collection[str]


Solve = Callable[[Case], dict[str, Any]]  # case → content of result.json


def read_case(folder: Path) -> Case:
    """Read the recordings of a case and its ``case.json``, never the keys."""
    return Case(
        name=folder.name,
        train=_recordings(folder, "train"),
        held_out=_recordings(folder, "held_out"),
        exclude=json.loads((folder / "case.json").read_text(encoding="utf-8"))["exclude"],
    )


def solve_suite(
    solve: Solve, suite: Path, out: Path, *, cases: int, processes: int, again: bool
) -> None:
    """Write result.json and run.json (seconds, error) for every case, and print the progress.

    Args:
        solve: what is run on each case, in processes of its own.
        suite: folder of cases.
        out: folder for a folder per case.
        cases: the first so many only; 0 is all.
        processes: number of worker processes.
        again: solve also cases that already have a result.
    """
    folders = sorted(p.parent for p in suite.glob("*/case.json"))
    folders = folders[:cases] if cases else folders
    todo = [f for f in folders if again or not (out / f.name / "run.json").exists()]
    begun = time.monotonic()
    with worker_processes(processes) as pool:
        waiting = [pool.submit(_one, solve, folder, out / folder.name) for folder in todo]
        for done, future in enumerate(as_completed(waiting), 1):
            spent = time.monotonic() - begun
            print(f"{done}/{len(todo)}, {spent:.0f} s: {future.result()}", flush=True)


def _one(solve: Solve, folder: Path, out: Path) -> str:
    """Solve one case; return a line with its verdict."""
    case = read_case(folder)
    out.mkdir(parents=True, exist_ok=True)
    begun, error, summary = time.monotonic(), "", "failed"
    try:
        result = solve(case)
        summary = f"{result['verdict']} {', '.join(result['effects'])}"
        text = json.dumps(result, indent=1, allow_nan=False) + "\n"
        with whole_file(out / "result.json") as made:
            made.write_text(text, encoding="utf-8")
    except TendonError as failure:
        error = summary = str(failure)
    about = {"seconds": time.monotonic() - begun, "error": error}
    with whole_file(out / "run.json") as made:  # last: with it the case is done
        made.write_text(json.dumps(about) + "\n", encoding="utf-8")
    return f"{folder.name} {summary}"


def _recordings(case: Path, kind: str) -> list[Recording]:
    return [read_recording(path) for path in sorted(case.glob(f"{kind}_*.csv"))]
