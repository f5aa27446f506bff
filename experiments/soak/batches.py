"""Trials in batches, each in a process of its own, so that a crash is seen and ends one batch."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from experiments.soak.own_memory import own_memory
from tendon_mj.lab.progress import Progress, silent

_LONGEST = 900.0  # [s] that a batch may take


@dataclass
class Outcomes:
    """Results of trials.

    Attributes:
        counts: number of trials by outcome.
        violations: descriptions of trials that broke a promise.
        crashes: descriptions of batches whose process died or did not end.
        most_memory: largest resident memory of a batch [MiB].
        most_growth: of a batch's own memory over its second half [MiB].
    """

    counts: Counter[str] = field(default_factory=Counter)
    violations: list[str] = field(default_factory=list)
    crashes: list[str] = field(default_factory=list)
    most_memory: float = 0.0
    most_growth: float = 0.0

    @property
    def trials(self) -> int:
        """Number of all trials that ended."""
        return sum(self.counts.values())

    def result(self) -> dict[str, object]:
        """Plain numbers and texts, for JSON."""
        return {"trials": self.trials, **vars(self), "counts": dict(self.counts)}


def run_batches(
    module: str, trials: int, seed: int = 0, size: int = 500, progress: Progress = silent
) -> Outcomes:
    """Run ``python -m <module>`` for batches of trials, and add up its reports.

    Args:
        module: that calls `report_batch`.
        trials: in all.
        seed: of the first batch; each has a seed of its own.
        size: of a batch.
        progress: is told of every batch.
    """
    outcomes = Outcomes()
    starts = range(0, trials, size)
    for k, start in enumerate(starts):
        count = min(size, trials - start)
        _run_batch(module, seed + k, count, outcomes)
        progress(module.rpartition(".")[2], start + count, trials)
    return outcomes


def _run_batch(module: str, seed: int, count: int, outcomes: Outcomes) -> None:
    command = [sys.executable, "-X", "faulthandler", "-m", module, str(seed), str(count)]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        try:
            done = subprocess.run(
                [*command, str(report)], capture_output=True, text=True, timeout=_LONGEST
            )
        except subprocess.TimeoutExpired:
            outcomes.crashes.append(f"{module} {seed} {count}: not ended after {_LONGEST:.0f} s")
            return
        if done.returncode != 0 or not report.exists():
            last = done.stderr.strip().splitlines()[-12:]
            outcomes.crashes.append(
                f"{module} {seed} {count}: status {done.returncode}: {' | '.join(last)}"
            )
            return
        told = json.loads(report.read_text("utf-8"))
    outcomes.counts.update(told["counts"])
    outcomes.violations.extend(told["violations"])
    outcomes.most_memory = max(outcomes.most_memory, told["memory"])
    outcomes.most_growth = max(outcomes.most_growth, told["growth"])


def report_batch(trials: Callable[[int, int], Iterator[tuple[str, str]]]) -> None:
    """Run one batch in this process, as the command line says: seed, number, file of the report.

    Args:
        trials: of a seed and a number, yields an outcome and, for a broken promise, what it was.
    """
    import resource  # not on Windows, where this part is not run

    seed, count, path = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    counts: Counter[str] = Counter()
    violations = []
    halfway = 0
    for outcome, violation in trials(seed, count):
        counts[outcome] += 1
        if violation:
            violations.append(f"seed {seed}, trial {sum(counts.values())}: {violation}")
        if sum(counts.values()) == count // 2:
            halfway = own_memory()
    growth = (own_memory() - halfway) / 2**20 if halfway else 0.0
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    told = {"counts": counts, "violations": violations, "memory": memory, "growth": growth}
    path.write_text(json.dumps(told), encoding="utf-8")
