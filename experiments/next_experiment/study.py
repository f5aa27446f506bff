"""Cases, each in a process of its own, and their outcomes in files."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from experiments.hidden_effects.case_folder import SOURCES
from experiments.next_experiment.case import Case
from experiments.next_experiment.settle import settle
from tendon_mj.lab.workers import Workers, run_tasks, versions
from tendon_mj.whole_file import whole_file


class Settled(NamedTuple):
    """Result of a case, and a summary line."""

    result: dict[str, Any]
    line: str


class SettledCases:
    """Keeps a file per case, and prints the progress.

    Args:
        folder: of the files.
        cases: number of cases.
    """

    def __init__(self, folder: Path, cases: int) -> None:
        self._folder, self._cases = folder, cases
        self._begun, self._written = time.monotonic(), 0

    def done(self) -> set[str]:
        """Names of the cases that have a file which this code wrote."""
        files = {path.stem: path for path in self._folder.glob("*.json")}
        return {
            name
            for name, path in files.items()
            if json.loads(path.read_text(encoding="utf-8")).get("of") == versions(SOURCES)
        }

    def write(self, key: str, result: Settled) -> None:
        """Write the result of a case."""
        about = {**result.result, "of": versions(SOURCES)}
        text = json.dumps(about, indent=1, ensure_ascii=False)
        with whole_file(self._folder / f"{key}.json") as made:
            made.write_text(text + "\n", encoding="utf-8")
        self._written += 1
        spent = time.monotonic() - self._begun
        print(f"{self._written}/{self._cases}, {spent:.0f} s: {result.line}", flush=True)


def settle_all(cases: Sequence[Case], out: Path, processes: int) -> None:
    """Settle the cases that have no file of this code in the folder, and print the progress."""
    named = {case.name: case for case in cases}
    store = SettledCases(out, len(named))
    on = Workers(processes=processes)
    run_tasks(_one, None, list(named), named.__getitem__, store, on=on, sources=SOURCES)


def _one(_: None, case: Case) -> Settled:
    """Settle one case."""
    outcome = settle(case)
    tie = "; ".join(" or ".join(group) for group in outcome.ties)
    settled = outcome.suggested and outcome.suggested.settled
    line = f"{case.name} {outcome.verdict} {tie or '-'} {settled if outcome.tie else ''}"
    return Settled(outcome.result(), line)
