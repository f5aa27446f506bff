"""`python -m experiments.cable_tool`: which friction of a driven grasper grows with its load."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.cable_tool.figures import draw_figures
from experiments.cable_tool.recording import read_folder
from experiments.cable_tool.report import result, summary, table
from experiments.cable_tool.study import run_study
from experiments.command import measured_data, run_experiment, write_study
from tendon_mj.cli import Output, progress_bar


def cable_tool(
    data: Path | None = None, out: Path = Path("out/cable_tool"), resamples: int = 100
) -> None:
    """Predict load and output angle of a driven surgical grasper from its input side.

    Fits eight numbers, leaves loads, wrist poses and the faster sine out in turn, and compares with
    models without sheath friction. Takes about 4 min on one core.

    Args:
        data: folder of the recordings; by default `cable_tool` in the folder that TENDON_MJ_DATA
            names.
        out: folder for result.json, the table and the pictures.
        resamples: fits from which the intervals come.
    """
    recordings = read_folder(data or measured_data("cable_tool"))
    output = Output(out)
    with progress_bar() as progress:
        study = run_study(recordings, resamples, progress)
    write_study(output, draw_figures(study), result(study), table(study), summary(study))


if __name__ == "__main__":
    sys.exit(run_experiment(cable_tool, "cable_tool"))
