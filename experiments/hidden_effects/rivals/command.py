"""The command line of a rival."""

from __future__ import annotations

from pathlib import Path

from experiments.command import run_experiment
from experiments.hidden_effects.suite.case_folder import Solve, solve_suite


def run_rival(solve: Solve, name: str) -> int:
    """Run a rival as ``python -m experiments.hidden_effects.rivals.<name>``; return its status."""

    def run(
        *, suite: Path, out: Path, cases: int = 0, processes: int = 1, again: bool = False
    ) -> None:
        """Run a rival on a suite of hidden cases.

        Args:
            suite: folder of cases.
            out: folder for a folder per case with result.json and run.json (seconds, error).
            cases: the first so many only; 0 is all.
            processes: number of worker processes.
            again: run also on cases that already have a result.
        """
        solve_suite(solve, suite, out, cases=cases, again=again, processes=processes)

    return run_experiment(run, f"hidden_effects.rivals.{name}")
