"""Cost of steps: over guides and sheaths, of each part of a sheath, and of several models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike

from tendon_mj.show import BLACK, BLUE, GREY, SERIES, legend_below, new_figure, print_style


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
    """Draw what sheaths add to a step over their guides and over their number.

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


def cost_figure(
    ratios: Mapping[str, Sequence[float]], parts: Mapping[str, Sequence[float]]
) -> Figure:
    """Draw the step cost ratio of each model, and the parts of a sheath's cost.

    Args:
        ratios: model → lower quartile, median and upper quartile of its step cost ratio [-].
        parts: part → the same of what it adds to a step [s].

    Returns:
        A figure of two panels, a row for each.
    """
    with print_style():
        figure = new_figure(8.0, 1.2 + 0.34 * max(len(ratios), len(parts)))
        left, right = figure.subplots(1, 2)
        _draw_bars(left, ratios, "{:.2f} ×")
        left.axvline(1.0, color=BLACK, linestyle=":", linewidth=1.3, label="without sheaths")
        left.set(title="a step of each model", xlabel="cost with sheaths over cost without [–]")
        nanoseconds = {part: [1e9 * value for value in spread] for part, spread in parts.items()}
        _draw_bars(right, nanoseconds, "{:.0f} ns")
        right.set(title="parts of one sheath", xlabel="added to a step of the bench [ns]")
        legend_below(figure, left, columns=1)
    return figure


def _draw_bars(axes: Axes, spreads: Mapping[str, Sequence[float]], text: str) -> None:
    low, median, high = np.array([list(spread) for spread in spreads.values()]).T
    rows = np.arange(len(spreads))
    axes.barh(rows, median, 0.7, color=BLUE)
    axes.errorbar(
        median,
        rows,
        xerr=[median - low, high - median],
        linestyle="none",
        color=BLACK,
        elinewidth=1.0,
        capsize=2.0,
    )
    for row, value, end in zip(rows, median, high, strict=True):
        place = (max(end, 0.0), row)
        axes.annotate(
            text.format(value), place, (5, 0), textcoords="offset points", va="center", fontsize=8.0
        )
    axes.set_xlim(min(0.0, 1.1 * float(low.min())), 1.3 * float(high.max()))
    axes.set_yticks(rows, list(spreads))
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
