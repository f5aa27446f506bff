"""Pictures of the study: data in, figures out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import savgol_filter

from experiments.positioning_system import published
from experiments.positioning_system.report import offset, scale, signal
from experiments.positioning_system.study import HELD_OUT, Study
from tendon_mj.show.style import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    SERIES,
    legend_below,
    new_figure,
    print_style,
)

_WINDOW = 41  # samples of the filter that differentiates the position
_START = 0.2  # [s] in which the carriage, at rest in the replay, catches up with the measured one


def draw_friction(study: Study) -> Figure:
    """Draw the force that is left beside the published mass, over speed, and friction as found."""
    measurement = study.measurement
    step = float(np.median(np.diff(measurement.time)))
    rate, acceleration = (
        savgol_filter(measurement.position, _WINDOW, 4, deriv=order, delta=step) for order in (1, 2)
    )
    left = measurement.force - published.MASS * acceleration
    speeds = np.linspace(1.05 * rate.min(), 1.05 * rate.max(), 400)
    with print_style():
        figure = new_figure(6.5, 4.2)
        axes = figure.subplots()
        axes.plot(1e3 * rate, left, ".", color=GREY, markersize=1.0, label="measured")
        axes.plot(
            1e3 * speeds,
            published.VISCOUS * speeds + published.COULOMB * np.sign(speeds) + published.OFFSET,
            color=BLACK,
            linestyle="--",
            label="published",
        )
        for (name, one), (colour, style, _) in zip(study.described.items(), SERIES, strict=False):
            model = one.diagnosis.model
            friction = model["screw.damping"] * speeds
            friction += model["screw.frictionloss"] * np.sign(speeds) + offset(model)
            axes.plot(1e3 * speeds, friction, color=colour, linestyle=style, label=f"found: {name}")
        axes.set(xlabel="speed [mm/s]", ylabel="force − mass × acceleration [N]")
        legend_below(figure, axes, columns=3)
    return figure


def draw_residual(study: Study) -> Figure:
    """Draw the residuals of every description and signal over time; the start is cut off."""
    rows = [(n, column) for n, one in study.described.items() for column in one.recording.measured]
    with print_style():
        figure = new_figure(8.0, 1.9 * len(rows))
        panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, column) in zip(panels, rows, strict=True):
            one = study.described[name]
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


def draw_figures(study: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "friction", draw_friction(study)
    yield "residual", draw_residual(study)
