"""`python -m experiments.force_servo`: the force servo of Kaneko and others (1991), section 3."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.force_servo.figures import draw_figures
from experiments.force_servo.report import result, summary
from experiments.force_servo.study import run_study
from tendon_mj.cli import Output, console, progress_bar


def force_servo(out: Path = Path("out/force_servo")) -> None:
    """Study the force servo of Kaneko and others (1991) on a sheath of λ = 1.5.

    Steps in both directions, phase plane, limit cycle, and what scheduled gains and feed-forward
    change. Takes about 40 s on two cores.

    Args:
        out: folder for result.json and the pictures.
    """
    output = Output(out)
    with progress_bar() as progress:
        study = run_study(progress=progress)
    for name, figure in draw_figures(study):
        output.figure(name, figure)
    output.result(result(study))
    for line in summary(study):
        console.print(line, soft_wrap=True)
    output.close()


if __name__ == "__main__":
    sys.exit(run_experiment(force_servo, "force_servo"))
