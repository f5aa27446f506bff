"""Figures of the agreement of the routes, and of their refinement towards the closed form."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.kaneko1991.agreement import Agreement
from experiments.kaneko1991.figures.style import LOOKS, caption_below, legend_above
from experiments.kaneko1991.histories import LEG_SAMPLES, LEG_TIME
from experiments.kaneko1991.refinement import STIFFENING, Refinement
from tendon_mj.show import BLACK, SKY, new_figure, print_style

_MILLI = 1e3


def draw_agreement(found: Agreement) -> Figure:
    """Draw minor loops by all routes, and the differences between the routes."""
    with print_style():
        figure = new_figure(8.2, 4.4)
        axes = figure.subplots(1, 2)
        exact = found.loops["closed form"].output_tension
        time = LEG_TIME / LEG_SAMPLES * np.arange(exact.size)
        for name, trace in found.loops.items():
            colour, line, width = LOOKS[name]
            look = {"color": colour, "linestyle": line, "label": name}
            travel = _MILLI * trace.input_displacement
            axes[0].plot(travel, trace.output_tension, linewidth=width, **look)
            error = 100.0 * (trace.output_tension - exact) / np.ptp(exact)
            axes[1].plot(time, error, linewidth=min(width, 1.5), **look)
        axes[0].set(xlabel="ξ_in [mm]", ylabel="T_out [N]", title="Minor loops")
        axes[1].axhspan(-0.5, 0.5, color=SKY, alpha=0.15, lw=0)
        axes[1].set(
            xlabel=f"time [s], {LEG_TIME:g} s from one turning point to the next",
            ylabel="T_out less closed form [% of range]",
            title="Difference (band: ±0.5 %)",
        )
        legend_above(figure, axes[0], 5)
        caption_below(
            figure,
            f"{found.tendon.caption()}; 64 elements or guides, 256 grid intervals. Largest "
            "difference between two routes on all histories, "
            f"{found.histories} random ones among them: T_out {found.largest:.2%}, T_in "
            f"{found.largest_input:.2%} of range.",
        )
    return figure


def draw_refinement(found: Refinement) -> Figure:
    """Draw the error over the number of elements, with a line of order 2."""
    with print_style():
        figure = new_figure(6.0, 4.6)
        axes = figure.subplots()
        for name, error in found.error.items():
            colour, line, width = LOOKS[name.split(",")[0]]
            far = "×" in name
            axes.loglog(
                found.elements,
                error,
                color=colour,
                linestyle="-" if far else line,
                linewidth=1.0 if far else max(width, 1.4),
                marker="s" if far else "o",
                markerfacecolor="white" if far else colour,
                label=f"{name} ({_order_label(found, name)})",
            )
        guide = found.error["continuum"][0] * (found.elements[0] / found.elements) ** 2
        axes.loglog(found.elements, 0.5 * guide, ":", color=BLACK, label="order 2")
        axes.set_xticks(found.elements, [f"{n:g}" for n in found.elements])
        axes.minorticks_off()
        axes.set(xlabel="elements, guides or intervals n", ylabel="rms error of T_out / range")
        axes.set_title("Refinement")
        legend_above(figure, axes, 2)
        caption_below(
            figure,
            f"{found.tendon.caption()}; outer loop against the closed form. At this EA the "
            "errors of sheath and plugin level off at finite strain, ξ/L and T/EA of 1e-3, which "
            "the closed form neglects. Squares: at EA = "
            f"{STIFFENING * found.tendon.axial_stiffness / 1e3:g} kN, T_0 and all tensions kept, "
            "they converge. The error of the elements levels off at their inertia. The order is "
            "that of the points before a curve levels off. Elements in MuJoCo are left out: their "
            "step is proportional to 1/n, and their inertia would dominate.",
        )
    return figure


def _order_label(found: Refinement, name: str) -> str:
    return f"order {found.order[name]:.2f}" if name in found.order else "levels off"
