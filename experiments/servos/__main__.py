"""Diagnoses of servos that were simulated independently; `python -m experiments.servos --help`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

from experiments.command import run_experiment
from experiments.rig_cases import print_cases
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
    seeds = range(first, first + cases)
    print(summary(print_cases(run_cases(out, seeds, signals, foretell=foretell))))


if __name__ == "__main__":
    sys.exit(run_experiment(diagnose_servos, "servos"))
