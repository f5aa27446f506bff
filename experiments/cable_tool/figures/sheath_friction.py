"""Figure of the friction in mid-stroke: input torque over load, in either direction."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.cable_tool.strokes import MID_STROKE
from experiments.cable_tool.study import Study
from tendon_mj.show import BLUE, GREY, VERMILLION, legend_below, new_figure, print_style

_MARKERS = {"straight": "o", "pitch": "s", "roll": "^"}


def draw_sheath_friction(found: Study) -> Figure:
    """Draw T_in over load of every recording, and the lines of a capstan with constant friction."""
    with print_style():
        figure = new_figure(6.4, 4.6)
        axes = figure.subplots()
        drawn = set()
        for recording in found.recordings:
            strokes = recording.strokes
            middle = np.abs(strokes.excursion) < 0.5 * MID_STROKE
            for sense, colour, name in ((-1, BLUE, "closing"), (1, VERMILLION, "opening")):
                chosen = middle & (strokes.direction == sense)
                label = f"{name}, {recording.group}"
                axes.plot(
                    1e3 * np.median(recording.load[chosen]),
                    1e3 * np.median(recording.input_torque[chosen]),
                    _MARKERS[recording.group],
                    color=colour,
                    markerfacecolor=colour if recording.group == "straight" else "none",
                    label="_" if label in drawn else label,
                )
                drawn.add(label)
        tool = found.tool
        opening = float(np.median([tool.opening(r) for r in found.recordings]))
        load = np.array([0.0, 0.125])
        for sense, offset, style in ((1, tool.closing_offset, "--"), (-1, opening, "-.")):
            line = load * np.exp(sense * tool.friction_exponent) + offset
            sign = "+" if sense > 0 else "-"
            axes.plot(
                1e3 * load,
                1e3 * line,
                style,
                color=GREY,
                label=f"$x\\,e^{{{sign}\\lambda}}$ {1e3 * offset:+.0f} mN m, "
                f"$\\lambda$ = {tool.friction_exponent:.2f}",
            )
        axes.set(
            xlabel="load $x$ at the output [mN m]",
            ylabel="input torque $T_\\mathrm{in}$ in mid-stroke [mN m]",
            title="a capstan's ratio either way, and a constant",
        )
        axes.set_xlim(left=0.0)
        legend_below(figure, axes, columns=3)
    return figure
