"""Figure of the held-out errors, recording by recording."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.cable_tool import asked
from experiments.cable_tool.candidates import CHOSEN
from experiments.cable_tool.study import Study
from tendon_mj.show import BLACK, GREY, SERIES, legend_below, new_figure, print_style

_SHOWN = (CHOSEN, "steady load", "regression by direction")


def draw_held_out(found: Study) -> Figure:
    """Draw the error where the output slides, of every recording, its load or its pose left out."""
    with print_style():
        figure = new_figure(8.0, 5.4)
        panels = figure.subplots(1, 2, sharey=True)
        names = [r.name for r in found.recordings]
        labels = [name.replace("_yaw0", "").replace("_", " ") for name in names]
        for axes, left_out in zip(panels, ("load", "pose"), strict=True):
            for candidate, (colour, _, marker) in zip(_SHOWN, SERIES, strict=False):
                errors = {one.name: one for one in found.errors(candidate, left_out)}
                axes.plot(
                    [1e3 * errors[name].torque_sliding for name in names],
                    np.arange(len(names)),
                    marker,
                    color=colour,
                    markerfacecolor=colour if candidate == CHOSEN else "none",
                    label=candidate,
                )
            axes.axvline(1e3 * asked.TORQUE_ASKED, color=BLACK, linestyle="--", label="asked")
            axes.axvline(
                1e3 * asked.TORQUE_PUBLISHED,
                color=GREY,
                linestyle=":",
                label="published neural network",
            )
            axes.set(
                title=f"its {left_out} left out",
                xlabel="torque error, sliding, rms [mN m]",
            )
            axes.set_xlim(left=0.0)
        panels[0].set_yticks(np.arange(len(names)), labels, fontsize=7.0)
        panels[0].invert_yaxis()
        legend_below(figure, panels[0], columns=3)
    return figure
