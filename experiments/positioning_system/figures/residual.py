"""Figure of what remains: simulated less measured, of the found and of the published model."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.positioning_system.study import HELD_OUT, Study
from experiments.positioning_system.table import scale, signal
from tendon_mj.show import BLUE, GREY, ORANGE, legend_below, new_figure, print_style

_START = 0.2  # [s] in which the carriage, at rest in the replay, catches up with the measured one


def draw_residual(found: Study) -> Figure:
    """Draw the residuals of every description and signal over time; the start is cut off."""
    rows = [(n, column) for n, one in found.described.items() for column in one.recording.measured]
    with print_style():
        figure = new_figure(8.0, 1.9 * len(rows))
        panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, column) in zip(panels, rows, strict=True):
            one = found.described[name]
            time = one.recording.time
            largest = 0.0
            for model, colour, width, label in (
                ("published", ORANGE, 1.4, "published"),
                ("after", BLUE, 0.5, "found"),
            ):
                series = scale(name, column) * one.residuals[model][column]
                axes.plot(time, series, color=colour, linewidth=width, label=label)
                largest = max(largest, float(np.abs(series[time > time[0] + _START]).max()))
            axes.set_ylim(-1.1 * largest, 1.1 * largest)
            start = time[0] + (1.0 - HELD_OUT) * (time[-1] - time[0])
            axes.axvspan(start, time[-1], color=GREY, alpha=0.15, linewidth=0.0, label="held out")
            axes.set(title=f"driven by {name}", ylabel=signal(name, column))
        panels[-1].set(xlabel="time [s]")
        legend_below(figure, panels[0], columns=3)
    return figure
