"""The benchmark study: scaling of a sheath's cost, threads, and the alternatives."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike

from experiments.benchmarks.callback import CallbackCost, callback_cost
from experiments.benchmarks.frictionloss import Frictionloss, compare_frictionloss
from experiments.benchmarks.scaling import (
    FAST,
    GUIDES,
    SHEATHS,
    SLOW,
    CostParts,
    GuideScaling,
    Scaling,
    cost_parts,
    guide_scaling,
    sheath_scaling,
)
from experiments.benchmarks.threads import thread_speedups
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.step_cost import Quartiles
from tendon_mj.models import Bench
from tendon_mj.show import bars_figure
from tendon_mj.show.style import GREY, SERIES, new_figure, print_style

PARTS = {
    "empty_plugin": "floor: an empty plugin",
    "idle_instance": "+ an idle instance of this one",
    "first_guide": "+ a sheath of one guide, at rest",
    "more_guides": "+ the other guides, at rest",
    "sliding": "+ sliding to and fro",
    "sensors": "+ three sensors",
}
_TWO = 2  # threads whose speedup is the figure; more where the machine has the cores


@dataclass(frozen=True)
class Benchmark:
    """Results of `run_benchmark`.

    Attributes:
        guides, sheaths: scaling of the added cost.
        threads: number → speedup of rollouts over one thread.
        parts: of the cost that a sheath adds on the bench.
        callback: the plugin beside a NumPy `mjcb_passive`.
        frictionloss: the plugin beside MuJoCo's own.
    """

    guides: GuideScaling
    sheaths: Scaling
    threads: dict[int, Quartiles]
    parts: CostParts
    callback: CallbackCost
    frictionloss: Frictionloss

    @property
    def part_costs(self) -> dict[str, Quartiles]:
        """Label → added cost [s]; without the floor where MuJoCo has no empty plugin."""
        spreads = {label: getattr(self.parts, name) for name, label in PARTS.items()}
        return {label: spread for label, spread in spreads.items() if spread is not None}

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "guide_scaling_exponent": self.guides.slow.exponent,
            "sheath_scaling_exponent": self.sheaths.exponent,
            "thread_speedup": self.threads[_TWO].median,
            "callback_ratio": self.callback.ratio.median,
            "guide_scaling": self.guides.result(),
            "sheath_scaling": self.sheaths.result(),
            "threads": {str(count): speedup.result() for count, speedup in self.threads.items()},
            "cost_parts": self.parts.result(),
            "callback": self.callback.result(),
            "frictionloss": self.frictionloss.result(),
            "cores": os.cpu_count(),
        }

    def figures(self) -> dict[str, Figure]:
        """Pictures: the scaling, and the parts of one sheath's cost."""
        guides = [
            CostSeries(f"reel at {rate:g} Hz", scaling.counts, scaling.added, scaling.exponent)
            for rate, scaling in ((SLOW, self.guides.slow), (FAST, self.guides.fast))
        ]
        sheaths = self.sheaths
        benches = CostSeries("benches", sheaths.counts, sheaths.added, sheaths.exponent)
        bars = {
            label: [1e9 * value for value in (spread.low, spread.median, spread.high)]
            for label, spread in self.part_costs.items()
        }
        parts = bars_figure(
            bars,
            "{:.0f} ns",
            title="parts of one sheath",
            label="added to a step of the bench [ns]",
        )
        return {"scaling": scaling_figure(guides, benches), "parts": parts}


def run_benchmark(
    *,
    rounds: int = 15,
    guides: Sequence[int] = GUIDES,
    sheaths: Sequence[int] = SHEATHS,
    progress: Progress = silent,
) -> Benchmark:
    """Measure the cost of sheaths, each time in turns with the same model without.

    Args:
        rounds: of every measurement, ≥ 1.
        guides, sheaths: numbers over which the cost is measured.
        progress: called with the stage, the number done and the total.

    Raises:
        InvalidValueError: no rounds.
        EngineError: rollouts differ between numbers of threads.
    """
    if rounds < 1:
        raise InvalidValueError(f"rounds = {rounds} must be 1 or more")
    bench = Bench()
    cores = os.cpu_count() or 1
    counts = [_TWO, *(n for n in (4, 8) if n <= cores)]
    return Benchmark(
        guides=guide_scaling(bench, guides, rounds=rounds, progress=progress),
        sheaths=sheath_scaling(bench, sheaths, rounds=rounds, progress=progress),
        threads=thread_speedups(bench, counts, rounds=rounds),
        parts=cost_parts(bench, rounds=rounds),
        callback=callback_cost(bench, rounds=rounds),
        frictionloss=compare_frictionloss(bench, rounds=rounds),
    )


class CostSeries(NamedTuple):
    """Added cost of a step over a count.

    Attributes:
        label: in the legend.
        counts: (k,) how many.
        added: (k, 3) lower quartile, median and upper quartile [s].
        exponent: fitted p of added cost ∝ count^p [-].
    """

    label: str
    counts: ArrayLike
    added: ArrayLike
    exponent: float


def scaling_figure(guides: Sequence[CostSeries], sheaths: CostSeries) -> Figure:
    """Draw the added cost of sheaths over their guides and over their number.

    Args:
        guides: of one sheath, in several motions.
        sheaths: of the bench's guides each.

    Returns:
        A figure of two panels with logarithmic axes.
    """
    with print_style():
        figure = new_figure(8.0, 4.0)
        left, right = figure.subplots(1, 2)
        _draw_series(left, guides, first=0)
        _draw_series(right, [sheaths], first=len(guides))
        left.set(title="one sheath", xlabel="guides $n$ [–]", ylabel="added to a step [µs]")
        right.set(title="several sheaths in one model", xlabel="sheaths $n$ [–]")
        for axes in (left, right):
            axes.legend(loc="upper left")
    return figure


def _draw_series(axes: Axes, series: Sequence[CostSeries], first: int) -> None:
    for k, (label, counts, added, exponent) in enumerate(series):
        colour, _, marker = SERIES[first + k]
        x, costs = np.asarray(counts, float), 1e6 * np.asarray(added, float).T
        low, median, high = np.where(costs > 0.0, costs, np.nan)  # noise may exceed little
        axes.errorbar(
            x,
            median,
            [median - low, high - median],
            color=colour,
            marker=marker,
            capsize=2.0,
            label=f"{label}: $\\propto n^{{{exponent:.2f}}}$",
        )
        if k == 0:
            axes.plot(x, median[-1] * x / x[-1], ":", color=GREY, label="proportional")
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xticks(x, [f"{n:g}" for n in x])
            axes.xaxis.set_minor_locator(NullLocator())
