"""`python -m experiments.next_experiment`: how many ties a suggested experiment settles."""

from __future__ import annotations

import itertools
import json
import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.next_experiment.case import HIDDEN, MOTIONS, RATIOS, SENSORS, Case
from experiments.next_experiment.study import settle_all
from experiments.next_experiment.table import table


def next_experiment(
    out: Path = Path("out/next_experiment"),
    seeds: tuple[int, ...] = (1,),
    hidden: tuple[str, ...] = tuple(HIDDEN),
    motions: tuple[str, ...] = MOTIONS,
    sensors: tuple[str, ...] = tuple(SENSORS),
    ratios: tuple[float, ...] = RATIOS,
    processes: int = 2,
) -> None:
    """Hide effects, record poorly, diagnose; where that ties, run the next experiment.

    Cases that this code has settled are in the folder, and are not settled again. Takes about an
    hour on two cores.

    Args:
        out: folder for a file per case, and the table.
        seeds: of the random draws; every combination is a case of each.
        hidden: effects and parameters.
        motions: of the drive in the first recordings.
        sensors: which tensions are measured: that at the output, or both.
        ratios: of the residual that is hidden to the noise, which decides how many tie.
        processes: number of worker processes.
    """
    cases = [
        Case(hidden=h, motion=m, sensors=s, ratio=r, seed=seed)
        for seed, s, r, m, h in itertools.product(seeds, sensors, ratios, motions, hidden)
    ]
    out.mkdir(parents=True, exist_ok=True)
    settle_all(cases, out, processes)
    outcomes = [json.loads((out / f"{c.name}.json").read_text(encoding="utf-8")) for c in cases]
    text = table(outcomes)
    (out / "table.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    sys.exit(run_experiment(next_experiment, "next_experiment"))
