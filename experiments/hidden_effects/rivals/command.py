"""Settings of a rival's command."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from experiments.hidden_effects.suite.case_folder import Solve, solve_suite


@dataclass(frozen=True, kw_only=True)
class RivalRun:
    """Run of a rival on a suite of hidden cases.

    Attributes:
        suite: folder of cases.
        out: folder for a folder per case with result.json and run.json (seconds, error).
        cases: the first so many only; 0 is all.
        processes: number of worker processes.
        again: run also on cases that already have a result.
    """

    suite: Path
    out: Path
    cases: int = 0
    processes: int = 1
    again: bool = False


def run_rival(solve: Solve, name: str) -> None:
    """Run a rival as ``python -m experiments.hidden_effects.rivals.<name>``."""
    program = f"python -m experiments.hidden_effects.rivals.{name}"
    solve_suite(solve, **vars(tyro.cli(RivalRun, prog=program)))
