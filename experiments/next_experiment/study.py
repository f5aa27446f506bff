"""Cases, each in a process of its own, and their outcomes in files."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from concurrent.futures import as_completed
from pathlib import Path

from experiments.next_experiment.case import Case
from experiments.next_experiment.settle import settle
from experiments.worker_processes import worker_processes


def settle_all(cases: Sequence[Case], out: Path, processes: int) -> None:
    """Settle the cases that have no file in the folder yet, and print the progress."""
    todo = [case for case in cases if not (out / f"{case.name}.json").exists()]
    begun = time.monotonic()
    with worker_processes(processes) as pool:
        waiting = [pool.submit(_one, case, out) for case in todo]
        for done, future in enumerate(as_completed(waiting), 1):
            spent = time.monotonic() - begun
            print(f"{done}/{len(todo)}, {spent:.0f} s: {future.result()}", flush=True)


def _one(case: Case, out: Path) -> str:
    """Settle one case, write what came of it, and say it in a line."""
    outcome = settle(case)
    text = json.dumps(outcome.result(), indent=1, ensure_ascii=False)
    (out / f"{case.name}.json").write_text(text + "\n", encoding="utf-8")
    tie = "; ".join(" or ".join(group) for group in outcome.ties)
    settled = outcome.suggested and outcome.suggested.settled
    return f"{case.name} {outcome.verdict} {tie or '-'} {settled if outcome.tie else ''}"
