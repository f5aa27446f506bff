"""`python -m experiments.positioning_system`: what a frictionless carriage lacks."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.positioning_system.figures import draw_figures
from experiments.positioning_system.measurement import read_measurement
from experiments.positioning_system.result import result
from experiments.positioning_system.study import run_study
from experiments.positioning_system.summary import summary
from experiments.positioning_system.table import table
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.errors import RecordingError


def positioning_system(
    data: Path | None = None, out: Path = Path("out/positioning_system")
) -> None:
    """Find what a carriage without friction lacks, from three descriptions of one file.

    The force drives it; the reference drives it through the servo; the measured motion drives it.
    Beside each: the published model, and mujoco.sysid. Takes about 10 min on two cores.

    Args:
        data: the file; by default `positioning_system/emps.csv` in the folder that
            TENDON_MJ_DATA names.
        out: folder for result.json, the table and the pictures.
    """
    measurement = read_measurement(data or default_file())
    output = Output(out)
    with progress_bar() as progress:
        found = run_study(measurement, progress)
    for name, figure in draw_figures(found):
        output.figure(name, figure)
    output.result(result(found))
    page = output.add(out / "table.md")
    page.write_text(table(found), encoding="utf-8")
    for line in summary(found):
        console.print(line, soft_wrap=True)
    output.close()


def default_file() -> Path:
    """The file below the folder that TENDON_MJ_DATA names.

    Raises:
        RecordingError: the variable is not set.
    """
    root = os.environ.get("TENDON_MJ_DATA")
    if not root:
        raise RecordingError(
            "give --data, or set TENDON_MJ_DATA to a folder that has positioning_system/emps.csv"
            " (see docs/data.md)"
        )
    return Path(root) / "positioning_system" / "emps.csv"


if __name__ == "__main__":
    sys.exit(run_experiment(positioning_system, "positioning_system"))
