"""Outputs of a sweep over its parameters: median and the middle 90 % of all rollouts."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.sweep import bins_of
from tendon_mj.show.figures.style import BLUE, GREY, SKY, legend_below, new_figure, print_style
from tendon_mj.typing import FloatArray

_MIDDLE = (0.05, 0.5, 0.95)
_MOST_POINTS = 2000  # of which single ones can be told apart


def parameter_figure(
    parameters: Mapping[str, FloatArray], outputs: Mapping[str, FloatArray], drawn: Collection[str]
) -> Figure:
    """Draw each output over each parameter, the others varying.

    Args:
        parameters: label → (rollouts,) values; a column each.
        outputs: label → (rollouts,) finite; a row each.
        drawn: labels of the parameters whose values are random.
    """
    rows, columns = len(outputs), len(parameters)
    with print_style():
        figure = new_figure(1.2 + 2.9 * columns, 0.7 + 2.1 * rows)
        grid = figure.subplots(rows, columns, sharex="col", sharey="row", squeeze=False)
        for line, (output, values) in zip(grid, outputs.items(), strict=True):
            for axes, (parameter, given) in zip(line, parameters.items(), strict=True):
                _draw(axes, given, values, parameter in drawn)
                if axes in grid[-1]:
                    axes.set_xlabel(parameter)
            line[0].set_ylabel(output)
        legend_below(figure, grid[0, 0], columns=3)
    return figure


def _draw(axes: Axes, given: FloatArray, values: FloatArray, drawn: bool) -> None:
    place = bins_of(given, drawn)
    numbers = np.unique(place)
    middle = np.array([np.median(given[place == k]) for k in numbers])
    low, median, high = np.array([np.quantile(values[place == k], _MIDDLE) for k in numbers]).T
    if len(values) <= _MOST_POINTS:
        axes.plot(given, values, ".", color=GREY, markersize=2.5, alpha=0.5, label="a rollout")
    if len(values) > len(numbers):  # else each value has one rollout
        axes.fill_between(middle, low, high, color=SKY, alpha=0.35, lw=0, label="middle 90 %")
    axes.plot(middle, median, color=BLUE, label="median")
