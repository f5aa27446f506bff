"""`python -m experiments.cable_tool`: which friction of a driven grasper grows with its load."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from experiments.cable_tool.figures import draw_figures
from experiments.cable_tool.recording import read_folder
from experiments.cable_tool.result import result
from experiments.cable_tool.study import run_study
from experiments.cable_tool.summary import summary
from experiments.cable_tool.table import table
from experiments.command import run_experiment
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.errors import RecordingError


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
    recordings = read_folder(data or default_folder())
    output = Output(out)
    with progress_bar() as progress:
        found = run_study(recordings, resamples, progress)
    for name, figure in draw_figures(found):
        output.figure(name, figure)
    output.result(result(found))
    page = output.add(out / "table.md")
    page.write_text(table(found), encoding="utf-8")
    for line in summary(found):
        console.print(line, soft_wrap=True)
    output.close()


def default_folder() -> Path:
    """Folder of the recordings below the one that TENDON_MJ_DATA names.

    Raises:
        RecordingError: the variable is not set.
    """
    root = os.environ.get("TENDON_MJ_DATA")
    if not root:
        raise RecordingError(
            "give --data, or set TENDON_MJ_DATA to a folder that has cable_tool (see docs/data.md)"
        )
    return Path(root) / "cable_tool"


if __name__ == "__main__":
    sys.exit(run_experiment(cable_tool, "cable_tool"))
