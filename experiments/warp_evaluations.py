"""`python -m experiments.warp_evaluations [MODEL…]`: how often a solve evaluates a segment's law.

A kernel lasts as long as its slowest thread, so the most evaluations count as well as their mean.
Each world has controls of its own, new ones in each round.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import mujoco_warp as mjw
import numpy as np
import tyro
import warp as wp
from rich.table import Table

from experiments.command import run_experiment
from experiments.warp_comparison import Pair, pairs_of
from tendon_mj import warp as sheathed_warp
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.lab.step_cost import smooth_controls
from tendon_mj.typing import IntArray
from tendon_mj.warp import breakpoints, solver
from tendon_mj.warp.tendons import Sheath, Tendons, held


@wp.func
def _counted(
    t: Tendons, s: Sheath, j: int, tau: wp.float64
) -> tuple[wp.float64, wp.float64, wp.float64]:
    """Law of a segment; the evaluation is counted in the place of one without a solution."""
    t.unsolved[s.world, s.index] += 1
    holds, slope, inverse = held(t, s, j, tau)
    return holds, slope, inverse


def warp_evaluations(
    models: Annotated[tuple[str, ...], tyro.conf.Positional] = ("bench", "finger"),
    out: Path = Path("out/warp_evaluations"),
    friction: float = 0.15,
    stiffness: float = 1e5,
    worlds: int = 256,
    rounds: int = 5,
    seed: int = 0,
) -> None:
    """Count how often each solve on MuJoCo Warp evaluates the law of a segment.

    Args:
        models: bench, finger, or MJCF files.
        out: folder for result.json.
        friction: mu of every sheath of a given model.
        stiffness: axial stiffness EA in N of these.
        worlds: number of them.
        rounds: of 20 steps with new controls, of which the first is not counted.
        seed: of the controls.
    """
    wp.config.quiet = True
    for module in (breakpoints, solver):
        module.__dict__["held"] = _counted
    output, rows, pairs = Output(out), [], pairs_of(models, friction, (stiffness,))
    table = Table("model", "solves", "mean", "99 %", "most", "most / mean")
    with progress_bar() as progress:
        for number, pair in enumerate(pairs):
            counts = _counts(pair, worlds, rounds, seed)
            mean, most = float(counts.mean()), int(counts.max())
            often = float(np.quantile(counts, 0.99))
            numbers = {"solves": counts.size, "mean": mean, "99 %": often, "most": most}
            rows.append({"model": pair.name} | numbers)
            shown = (f"{counts.size:,}", f"{mean:.1f}", f"{often:.0f}", f"{most}")
            table.add_row(pair.name, *shown, f"{most / mean:.1f}")
            progress("models", number + 1, len(pairs))
    console.print(table)
    output.result({"rows": rows, "worlds": worlds})
    output.close()


def _counts(pair: Pair, worlds: int, rounds: int, seed: int) -> IntArray:
    """Evaluations of each solve in the counted steps; a slack tendon takes none and is left out."""
    model = pair.model
    m, d = sheathed_warp.put_model(model), sheathed_warp.make_data(model, worlds)
    unsolved = sheathed_warp.sheaths_of(d).unsolved
    rng, counts = np.random.default_rng(seed), []
    inputs = smooth_controls(model, rounds * worlds, seed, pair.amplitude).astype(np.float32)
    for counted in range(rounds):
        d.ctrl.assign(rng.permutation(inputs)[:worlds])
        for _ in range(20):
            unsolved.zero_()
            mjw.step(m, d)
            if counted:
                counts.append(unsolved.numpy().copy())
    evaluations = np.array(counts)
    return evaluations[evaluations > 0]


if __name__ == "__main__":
    sys.exit(run_experiment(warp_evaluations, "warp_evaluations"))
