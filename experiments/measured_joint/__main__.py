"""`python -m experiments.measured_joint`: effects missing in a model of a measured joint."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.command import measured_data, run_experiment, write_study
from experiments.measured_joint.figures import draw_figures
from experiments.measured_joint.recording import read_folder
from experiments.measured_joint.report import result, summary, table
from experiments.measured_joint.splits import BETWEEN, BEYOND
from experiments.measured_joint.study import run_study
from tendon_mj.cli import Output, progress_bar


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
    recordings = read_folder(data or measured_data("tendon_sheath_joint"))
    output = Output(out)
    with progress_bar() as progress:
        study = run_study(recordings, seeds, progress)
    for split in (BETWEEN, BEYOND):
        (diagnosed,) = study.diagnoses[split]
        output.add(diagnosed.found.write_model(out / f"{split}.xml"))
    write_study(output, draw_figures(study), result(study), table(study), summary(study))


if __name__ == "__main__":
    sys.exit(run_experiment(measured_joint, "measured_joint"))
