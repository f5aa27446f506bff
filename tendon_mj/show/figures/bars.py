"""Bars of measured values, with their quartiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from tendon_mj.show.figures.style import BLACK, BLUE, legend_below, new_figure, print_style


def bars_figure(
    spreads: Mapping[str, Sequence[float]],
    text: str,
    *,
    title: str,
    label: str,
    reference: tuple[float, str] | None = None,
) -> Figure:
    """Draw a horizontal bar for each median, with its quartiles and its value.

    Args:
        spreads: name → lower quartile, median and upper quartile.
        text: format of a value, e.g. "{:.2f} ×".
        title: of the picture.
        label: of the axis, with the unit.
        reference: a value to mark by a line, and its name.
    """
    low, median, high = np.array([list(spread) for spread in spreads.values()]).T
    rows = np.arange(len(spreads))
    with print_style():
        figure = new_figure(5.2, 1.4 + 0.34 * len(spreads))
        axes = figure.subplots()
        axes.barh(rows, median, 0.7, color=BLUE)
        errors = [median - low, high - median]
        axes.errorbar(
            median, rows, xerr=errors, linestyle="none", color=BLACK, elinewidth=1.0, capsize=2.0
        )
        for row, value, end in zip(rows, median, high, strict=True):
            axes.annotate(
                text.format(value),
                (max(end, 0.0), row),
                (5, 0),
                textcoords="offset points",
                va="center",
                fontsize=8.0,
            )
        axes.set_xlim(min(0.0, 1.1 * float(low.min())), 1.3 * float(high.max()))
        axes.set_yticks(rows, list(spreads))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set(title=title, xlabel=label)
        if reference:
            value, name = reference
            axes.axvline(value, color=BLACK, linestyle=":", linewidth=1.3, label=name)
            legend_below(figure, axes, columns=1)
    return figure
