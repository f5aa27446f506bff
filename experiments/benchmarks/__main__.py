"""`python -m experiments.benchmarks`: cost of sheaths and of the alternatives."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.benchmarks.scaling import FAST, SLOW
from experiments.benchmarks.study import Benchmark, run_benchmark
from experiments.command import run_experiment
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.lab.step_cost import Quartiles


def benchmarks(out: Path = Path("out/benchmarks"), rounds: int = 15) -> None:
    """Measure the cost of sheaths on the bench: over guides, sheaths, threads, and part by part.

    The alternatives are a NumPy `mjcb_passive` and MuJoCo's own frictionloss. `tendon-mj bench`
    measures the step of the package's models and of given ones. Takes half a minute.

    Args:
        out: folder for result.json and the pictures.
        rounds: of every measurement; each round times all that is compared, in turns.
    """
    output = Output(out)
    with progress_bar() as progress:
        study = run_benchmark(rounds=rounds, progress=progress)
    for name, figure in study.figures().items():
        output.figure(name, figure)
    output.result(study.result())
    for line in summary(study):
        console.print(line, soft_wrap=True)
    output.close()


def summary(study: Benchmark) -> list[str]:
    """The study in a few lines."""
    slow, fast, callback, loss = (
        study.guides.slow,
        study.guides.fast,
        study.callback,
        study.frictionloss,
    )
    lines = [
        f"{label}: {spread.median * 1e9:.0f} ns ({_range(spread, 1e9, '.0f')})"
        for label, spread in study.part_costs.items()
    ]
    lines.append(
        f"added cost ∝ guides^{slow.exponent:.2f} with the reel at {SLOW:g} Hz, "
        f"^{fast.exponent:.2f} at {FAST:g} Hz; ∝ sheaths^{study.sheaths.exponent:.2f}"
    )
    lines += [
        f"{count} threads: {_ratio(speedup)}, and the same to the bit"
        for count, speedup in study.threads.items()
    ]
    lines.append(
        f"a NumPy mjcb_passive adds {callback.callback.median * 1e6:.0f} µs: "
        f"{_ratio(callback.ratio)} what the plugin adds, "
        f"tensions alike within {callback.disagreement:.0e}"
    )
    lines.append(
        f"MuJoCo's frictionloss takes {_ratio(loss.over_sheath)} the step of a sheath; T_out is "
        f"off the capstan law by up to {loss.error.largest:.0%} between half and twice the mean "
        f"tension, with the default solver settings by {loss.default_error.largest:.0%}, a "
        f"sheath's by {loss.sheath_error.largest:.2%}"
    )
    return lines


def _ratio(spread: Quartiles) -> str:
    return f"{spread.median:.2f} × ({_range(spread)})"


def _range(spread: Quartiles, scale: float = 1.0, form: str = ".2f") -> str:
    return f"{spread.low * scale:{form}} … {spread.high * scale:{form}}"


if __name__ == "__main__":
    sys.exit(run_experiment(benchmarks, "benchmarks"))
