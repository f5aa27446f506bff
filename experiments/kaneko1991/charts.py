"""Charts of the paper's reproduction: agreement, refinement, stiction and cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.kaneko1991.agreement import (
    LEG,
    SAMPLES,
    STIFF,
    Agreement,
    Refinement,
)
from experiments.kaneko1991.cost import Cost
from experiments.kaneko1991.stiction import Stiction
from experiments.kaneko1991.style import LOOKS, caption_below, legend_above
from tendon_mj.view.figures.style import (
    BLACK,
    BLUE,
    ORANGE,
    SKY,
    VERMILLION,
    new_figure,
    print_style,
)

_MILLI = 1e3


def agreement_figure(found: Agreement) -> Figure:
    """Minor loops by all routes, and what they leave between each other."""
    with print_style():
        figure = new_figure(8.2, 4.4)
        axes = figure.subplots(1, 2)
        exact = found.loops["closed form"].output_tension
        time = LEG / SAMPLES * np.arange(exact.size)
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
            xlabel=f"time [s], {LEG:g} s from one turning point to the next",
            ylabel="T_out less closed form [% of range]",
            title="What is left (band: ±0.5 %)",
        )
        legend_above(figure, axes[0], 5)
        caption_below(
            figure,
            f"{found.rig.caption()}; 64 elements or guides, 256 grid intervals. Largest difference "
            f"between two routes on all histories, {found.histories} random ones among them: T_out "
            f"{found.largest:.2%}, T_in {found.largest_input:.2%} of range.",
        )
    return figure


def refinement_figure(found: Refinement) -> Figure:
    """Error over the number of elements, with a line of order 2."""
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
                label=f"{name} ({_fall(found, name)})",
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
            f"{found.rig.caption()}; outer loop against the closed form. At this EA sheath and "
            "plugin do not shrink to the last: they level off at finite strain, ξ/L and T/EA of "
            f"1e-3, which the closed form neglects. Squares: the same at EA = "
            f"{STIFF * found.rig.axial_stiffness / 1e3:g} kN, T_0 and all tensions kept, where "
            "they shrink. The elements level off at their inertia. The order is that of the "
            "points before a curve levels off. Elements in MuJoCo are left out: their step goes "
            "with 1/n and their inertia would be all that is seen.",
        )
    return figure


def _fall(found: Refinement, name: str) -> str:
    return f"order {found.order[name]:.2f}" if name in found.order else "levels off"


def stiction_figure(found: Stiction) -> Figure:
    """The shift over n without inertia, and over the step with it."""
    with print_style():
        figure = new_figure(8.2, 4.2)
        left, right = figure.subplots(1, 2)
        left.loglog(found.guides, 100 * found.one_guide, ":", color=BLACK, label="one guide at μ_s")
        left.loglog(found.guides, 100 * found.quasi_static, "o-", color=BLUE, label="sheath alone")
        left.set(xlabel="guides n", ylabel="shift [% of range]", title="No inertia")
        left.set_xticks(found.guides, [f"{n:g}" for n in found.guides])
        left.minorticks_off()
        left.legend()
        for shift, (colour, mark) in zip(
            found.shifts,
            ((VERMILLION, "o"), (ORANGE, "s"), (BLUE, "o"), (SKY, "s")),
            strict=True,
        ):
            steps = 1e6 * np.array(shift.tendon.steps)
            mean = 100 * shift.largest.mean(1)
            reach = 100 * np.array([shift.largest.min(1), shift.largest.max(1)])
            right.errorbar(
                steps,
                mean,
                np.abs(reach - mean),
                color=colour,
                marker=mark,
                capsize=3,
                label=f"{shift.tendon.name}, {shift.frequency:g} Hz",
            )
        right.set_xscale("log")
        right.set(xlabel="time step h [µs]", ylabel="shift [% of range]", title="With inertia")
        right.set_ylim(bottom=0.0)
        right.set_xticks([2, 5, 10, 20, 40], ["2", "5", "10", "20", "40"])
        right.minorticks_off()
        right.legend(ncols=2, loc="upper left")
        right.set_ylim(top=1.25 * right.get_ylim()[1])
        caption_below(
            figure,
            "Shift: what μ_s = 0.3 against μ_d = 0.1 adds to T_out, largest in a period, over the "
            "range. Right: three periods each after the start, mean, with bars from least to "
            "most: the heavy tendon at 0.5 Hz does not converge. "
            + "; ".join(
                f"{t.name}: n = {t.elements}, {t.mass:g} kg, {t.damping:g} N s/m"
                for t in (found.shifts[0].tendon, found.shifts[1].tendon)
            )
            + ".",
        )
    return figure


def cost_figure(costs: Sequence[Cost]) -> Figure:
    """Wall time of a simulated second by route."""
    with print_style():
        figure = new_figure(6.4, 3.2)
        axes = figure.subplots()
        names = [c.route for c in costs]
        axes.barh(names, [c.seconds for c in costs], color=[LOOKS[n][0] for n in names], height=0.6)
        for c in costs:
            step = f"h = {1e3 * c.step:.3g} ms" + (f", n = {c.elements}" if c.elements else "")
            axes.annotate(
                f"{c.seconds:.1e} s; {step}; {c.error:.1%}",
                (c.seconds, c.route),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
        axes.set_xscale("log")
        axes.set_xlim(min(c.seconds for c in costs) / 3, 3000 * max(c.seconds for c in costs))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set(xlabel="wall time per simulated second [s]", title="Cost at 1 % of range")
    return figure
