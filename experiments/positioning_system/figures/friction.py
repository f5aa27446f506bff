"""Figure of friction over speed: the motor's force less inertia, and what was found."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import savgol_filter

from experiments.positioning_system import published
from experiments.positioning_system.study import Study
from experiments.positioning_system.table import offset
from tendon_mj.show import BLACK, GREY, SERIES, legend_below, new_figure, print_style

_WINDOW = 41  # samples of the filter that differentiates the position


def draw_friction(found: Study) -> Figure:
    """Draw the force that is left beside the published mass, over speed, and friction as found."""
    measurement = found.measurement
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
        for (name, one), (colour, style, _) in zip(found.described.items(), SERIES, strict=False):
            model = one.diagnosis.model
            friction = model["screw.damping"] * speeds
            friction += model["screw.frictionloss"] * np.sign(speeds) + offset(model)
            axes.plot(1e3 * speeds, friction, color=colour, linestyle=style, label=f"found: {name}")
        axes.set(xlabel="speed [mm/s]", ylabel="force − mass × acceleration [N]")
        legend_below(figure, axes, columns=3)
    return figure
