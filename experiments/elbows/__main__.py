"""Diagnoses of elbows that were simulated independently; `python -m experiments.elbows --help`."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.elbows.suite import HIDDEN, run_cases, summary
from experiments.rig_cases import print_cases


def diagnose_elbows(
    *,
    out: Path = Path("out/elbows"),
    elbows: int = 60,
    without_load_cell: int = 40,
    mounts: int = 20,
    first: int = 0,
) -> None:
    """Make elbows with play, a soft mount at the output or neither; diagnose them; print each.

    Args:
        out: folder for a folder per rig: its model, description, recordings, and found.json.
        elbows: rigs with one or two load cells.
        without_load_cell: rigs of which only the angle is measured, with play at a drum or none.
        mounts: rigs with one or two load cells whose cables are held by soft mounts at the joint.
        first: seed of the first rig of each kind.
    """
    for kind, count in zip(HIDDEN, (elbows, without_load_cell, mounts), strict=True):
        seeds = range(first, first + count)
        if cases := print_cases(run_cases(out, seeds, kind)):
            print(summary(cases))


if __name__ == "__main__":
    sys.exit(run_experiment(diagnose_elbows, "elbows"))
