"""`python -m experiments.positioning_system`: the missing friction of a carriage."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.command import measured_data, run_experiment, write_study
from experiments.positioning_system.figures import draw_figures
from experiments.positioning_system.measurement import read_measurement
from experiments.positioning_system.report import result, summary, table
from experiments.positioning_system.study import run_study
from tendon_mj.cli import Output, progress_bar


def positioning_system(
    data: Path | None = None, out: Path = Path("out/positioning_system")
) -> None:
    """Find the missing friction of a carriage, from three descriptions of one file.

    The force drives it; the reference drives it through the servo; the measured motion drives it.
    Beside each: the published model, and mujoco.sysid. Takes about 10 min on two cores.

    Args:
        data: the file; by default `positioning_system/emps.csv` in the folder that
            TENDON_MJ_DATA names.
        out: folder for result.json, the table and the pictures.
    """
    measurement = read_measurement(data or measured_data("positioning_system/emps.csv"))
    output = Output(out)
    with progress_bar() as progress:
        study = run_study(measurement, progress)
    write_study(output, draw_figures(study), result(study), table(study), summary(study))


if __name__ == "__main__":
    sys.exit(run_experiment(positioning_system, "positioning_system"))
