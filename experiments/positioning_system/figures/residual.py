"""Figure of what remains: simulated less measured, of the found and of the published model."""

from __future__ import annotations

from matplotlib.figure import Figure

from experiments.positioning_system.study import HELD_OUT, Study
from experiments.positioning_system.table import scale, signal
from tendon_mj.view import BLACK, BLUE, GREY, legend_below, new_figure, print_style


def draw_residual(found: Study) -> Figure:
    """Draw the residuals of every description and signal over time."""
    rows = [(n, column) for n, one in found.described.items() for column in one.recording.measured]
    with print_style():
        figure = new_figure(8.0, 1.9 * len(rows))
        panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, column) in zip(panels, rows, strict=True):
            one = found.described[name]
            time = one.recording.time
            for model, colour, label in (
                ("published", BLACK, "published"),
                ("after", BLUE, "found"),
            ):
                series = scale(name, column) * one.residuals[model][column]
                axes.plot(time, series, color=colour, linewidth=0.6, label=label)
            start = time[0] + (1.0 - HELD_OUT) * (time[-1] - time[0])
            axes.axvspan(start, time[-1], color=GREY, alpha=0.15, linewidth=0.0, label="held out")
            axes.set(title=f"driven by {name}", ylabel=signal(name, column))
        panels[-1].set(xlabel="time [s]")
        legend_below(figure, panels[0], columns=3)
    return figure
