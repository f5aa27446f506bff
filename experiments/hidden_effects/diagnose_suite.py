"""Diagnoses every case of a suite; `python -m experiments.hidden_effects.diagnose_suite --help`.

It reads recordings and ``case.json``, never the keys.
"""

from __future__ import annotations

import json
import os
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import tyro

from tendon_mj.diagnosis import diagnose
from tendon_mj.errors import TendonError
from tendon_mj.recordings import Recording, read_recording
from tendon_mj.replay import Simulator


@dataclass(frozen=True, kw_only=True)
class SuiteDiagnosis:
    """Diagnosis of a suite of hidden cases.

    Attributes:
        suite: folder of cases.
        out: folder for a folder per case with result.json and run.json (seconds, error).
        cases: the first so many only; 0 is all.
        processes: number of worker processes.
        again: diagnose also cases that already have a verdict.
    """

    suite: Path
    out: Path
    cases: int = 0
    processes: int = 2
    again: bool = False


def diagnose_suite(settings: SuiteDiagnosis) -> None:
    """Write a verdict on every case, and print the progress."""
    folders = sorted(p.parent for p in settings.suite.glob("*/case.json"))
    folders = folders[: settings.cases] if settings.cases else folders
    todo = [
        f for f in folders if settings.again or not (settings.out / f.name / "run.json").exists()
    ]
    begun = time.monotonic()
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = "1"  # a process has one core; spawned ones read it before NumPy
    with ProcessPoolExecutor(settings.processes, get_context("spawn")) as pool:
        waiting = [pool.submit(_one, folder, settings.out / folder.name) for folder in todo]
        for done, future in enumerate(as_completed(waiting), 1):
            spent = time.monotonic() - begun
            print(f"{done}/{len(todo)}, {spent:.0f} s: {future.result()}", flush=True)


def _one(case: Path, out: Path) -> str:
    """Diagnose one case; return a line with its verdict."""
    exclude = json.loads((case / "case.json").read_text(encoding="utf-8"))["exclude"]
    train, held_out = _recordings(case, "train"), _recordings(case, "held_out")
    out.mkdir(parents=True, exist_ok=True)
    simulator = partial(Simulator, threads=1)
    begun, error, summary = time.monotonic(), "", "failed"
    try:
        result = diagnose(train, held_out, simulator, exclude=exclude).result()
        summary = f"{result['verdict']} {', '.join(result['effects'])}"
        text = json.dumps(result, indent=1, allow_nan=False) + "\n"
        (out / "result.json").write_text(text, encoding="utf-8")
    except TendonError as failure:
        error = summary = str(failure)
    about = {"seconds": time.monotonic() - begun, "error": error}
    (out / "run.json").write_text(json.dumps(about) + "\n", encoding="utf-8")
    return f"{case.name} {summary}"


def _recordings(case: Path, kind: str) -> list[Recording]:
    return [read_recording(path) for path in sorted(case.glob(f"{kind}_*.csv"))]


if __name__ == "__main__":
    diagnose_suite(tyro.cli(SuiteDiagnosis))
