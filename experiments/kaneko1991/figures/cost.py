"""Figure of what a simulated second costs by each route."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from experiments.kaneko1991.cost import Cost
from experiments.kaneko1991.figures.style import LOOKS
from tendon_mj.show import new_figure, print_style


def draw_costs(costs: Sequence[Cost]) -> Figure:
    """Draw the wall time of a simulated second by route."""
    with print_style():
        figure = new_figure(6.4, 3.2)
        axes = figure.subplots()
        names = [c.route for c in costs]
        axes.barh(names, [c.seconds for c in costs], color=[LOOKS[n][0] for n in names], height=0.6)
        for c in costs:
            step = f"h = {1e3 * c.step:.3g} ms" + (f", n = {c.elements}" if c.elements else "")
            axes.annotate(
                f"{c.seconds:.1e} s; {step}; error {c.error:.1%}",
                (c.seconds, c.route),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
        axes.set_xscale("log")
        axes.set_xlim(min(c.seconds for c in costs) / 3, 1e5 * max(c.seconds for c in costs))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set(
            xlabel="wall time per simulated second [s]",
            title="Cost of an error of at most 1 % of range",
        )
    return figure
