"""Diagnoses of servos that were simulated independently; `python -m experiments.servos --help`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

from experiments.command import run_experiment
from experiments.servos.suite import run_cases, summary


def diagnose_servos(
    *,
    out: Path = Path("out/servos"),
    cases: int = 60,
    first: int = 0,
    signals: Literal["all", "current", "position"] = "all",
    foretell: bool = False,
) -> None:
    """Make joints with one wrong number or none; diagnose them; print a line for each.

    Args:
        out: folder for a folder per rig: its model, description, recordings, and found.json.
        cases: how many rigs.
        first: seed of the first.
        signals: measured beside the goal: the motor's place and current and the joint's angle;
            the first two; or the motor's place alone.
        foretell: whether `identify` says of each, before, that it can be told.
    """
    found = []
    for case in run_cases(out, range(first, first + cases), signals, foretell=foretell):
        found.append(case)
        print(
            f"{case['folder']}: {case['hidden']} hidden; {case['verdict']}"
            f" {', '.join(case['effects'])}; {case['sentence']}",
            flush=True,
        )
    print(summary(found))


if __name__ == "__main__":
    sys.exit(run_experiment(diagnose_servos, "servos"))
