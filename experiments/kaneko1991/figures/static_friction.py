"""Figure of the shift of T_out by static friction (Fig. 4 (b), (c))."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.kaneko1991.figure_4bc import Figure4bc
from experiments.kaneko1991.figures.style import caption_below
from tendon_mj.show import BLACK, BLUE, ORANGE, SKY, VERMILLION, new_figure, print_style


def draw_shift(found: Figure4bc) -> Figure:
    """Draw the shift over n without inertia, and over the time step with it."""
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
            steps = 1e6 * np.array(shift.dynamics.steps)
            mean = 100 * shift.largest.mean(1)
            reach = 100 * np.array([shift.largest.min(1), shift.largest.max(1)])
            right.errorbar(
                steps,
                mean,
                np.abs(reach - mean),
                color=colour,
                marker=mark,
                capsize=3,
                label=f"{shift.dynamics.name}, {shift.frequency:g} Hz",
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
            "Shift: T_out with μ_s = 0.3 less T_out with μ_s = μ_d = 0.1, largest in a period, "
            "over the range. Right: mean over three periods after the start, with bars from least "
            "to most; heavy elements at 0.5 Hz do not converge. "
            + "; ".join(
                f"{d.name}: n = {d.elements}, {d.mass:g} kg, {d.damping:g} N s/m"
                for d in (found.shifts[0].dynamics, found.shifts[1].dynamics)
            )
            + ".",
        )
    return figure
