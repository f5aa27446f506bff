"""`python -m experiments.measured_joint`: what a frictionless model of a measured joint lacks."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.measured_joint.figures import draw_figures
from experiments.measured_joint.recording import read_folder
from experiments.measured_joint.result import result
from experiments.measured_joint.splits import BETWEEN, BEYOND
from experiments.measured_joint.study import run_study
from experiments.measured_joint.summary import summary
from experiments.measured_joint.table import table
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.errors import RecordingError


def measured_joint(
    data: Path | None = None, out: Path = Path("out/measured_joint"), seeds: int = 3
) -> None:
    """Diagnose a measured joint behind a bent sheath, and predict it at bends not given.

    Diagnoses a model whose sheath has no friction, given some bends, and compares its predictions
    of the others with those of rivals. Takes the better part of an hour on two cores.

    Args:
        data: folder of the recordings; by default `tendon_sheath_joint` in the folder that
            TENDON_MJ_DATA names.
        out: folder for result.json, the tables, the diagnosed models and the pictures.
        seeds: fits of every rival in which something is random, for bends beyond the given.
    """
    recordings = read_folder(data or default_folder())
    output = Output(out)
    with progress_bar() as progress:
        found = run_study(recordings, seeds, progress)
    for name, figure in draw_figures(found):
        output.figure(name, figure)
    for split in (BETWEEN, BEYOND):
        (diagnosed,) = found.diagnoses[split]
        output.add(diagnosed.found.write_model(out / f"{split}.xml"))
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
            "give --data, or set TENDON_MJ_DATA to a folder that has tendon_sheath_joint (see"
            " docs/data.md)"
        )
    return Path(root) / "tendon_sheath_joint"


if __name__ == "__main__":
    sys.exit(run_experiment(measured_joint, "measured_joint"))
