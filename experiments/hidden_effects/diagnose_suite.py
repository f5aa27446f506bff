"""Diagnoses every case of a suite; `python -m experiments.hidden_effects.diagnose_suite --help`.

It reads recordings and ``case.json``, never the keys.
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

from experiments.command import run_experiment
from experiments.hidden_effects.case_folder import Case, solve_suite
from tendon_mj.lab.diagnosis import diagnose
from tendon_mj.lab.replay import Simulator


def diagnose_suite(
    *,
    suite: Path,
    out: Path,
    cases: int = 0,
    processes: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    again: bool = False,
) -> None:
    """Write a verdict on every case of a suite, and print the progress.

    Args:
        suite: folder of cases.
        out: folder for a folder per case with result.json and run.json (seconds, error).
        cases: the first so many only; 0 is all.
        processes: of this machine, without Dask; default: as many as it has cores.
        workers: of a Dask cluster that lives as long as the run.
        scheduler: address of a Dask scheduler, such as tcp://10.0.0.1:8786.
        again: diagnose also cases that already have a verdict.

    Raises:
        TendonError: see `solve_suite`.
    """
    solve_suite(
        _diagnose,
        suite,
        out,
        cases=cases,
        again=again,
        processes=processes,
        workers=workers,
        scheduler=scheduler,
    )


def _diagnose(case: Case) -> dict[str, Any]:
    simulator = partial(Simulator, model=case.model, threads=1)
    return diagnose(case.train, case.held_out, simulator, exclude=case.exclude).result()


if __name__ == "__main__":
    sys.exit(run_experiment(diagnose_suite, "hidden_effects.diagnose_suite"))
