"""Figure of what remains: error of the load over the input angle, by wrist pose and direction."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from experiments.cable_tool.study import Study
from tendon_mj.show import GREY, SERIES, legend_below, new_figure, print_style

_THIN = 4  # every so many samples are drawn


def draw_residual(found: Study) -> Figure:
    """Draw predicted less measured load; the fit has seen these recordings."""
    with print_style():
        poses = sorted({r.pose for r in found.recordings})
        figure = new_figure(8.4, 2.2 * len(poses) * 0.72 + 1.2)
        panels = figure.subplots(len(poses), 2, sharex=True, sharey=True, squeeze=False)
        loads = sorted({_load_class(r.load_share) for r in found.recordings})
        for row, pose in zip(panels, poses, strict=True):
            for axes, sense, name in zip(row, (-1.0, 1.0), ("closing", "opening"), strict=True):
                for recording in (r for r in found.recordings if r.pose == pose):
                    strokes = recording.strokes
                    error = found.tool.load(recording) - recording.load
                    chosen = np.flatnonzero(strokes.direction == sense)[::_THIN]
                    colour, _, marker = SERIES[loads.index(_load_class(recording.load_share))]
                    axes.plot(
                        np.degrees(strokes.excursion[chosen]),
                        1e3 * error[chosen],
                        marker,
                        color=colour,
                        markersize=1.2,
                        rasterized=True,
                    )
                axes.axhline(0.0, color=GREY, linewidth=0.8)
                axes.set_title(f"{pose}, {name}")
                axes.set_ylim(-32.0, 32.0)
                axes.set_xlim(-32.0, 32.0)
            row[0].set_ylabel("error [mN m]")
        for axes in panels[-1]:
            axes.set_xlabel("input angle from the middle [°]")
        for name, (colour, _, marker) in zip(loads, SERIES, strict=False):
            panels[0, 0].plot([], [], marker, color=colour, label=f"load {name}")
        legend_below(figure, panels[0, 0], columns=4)
    return figure


def _load_class(share: float) -> str:
    """Thirds of full load."""
    return ("0 … 33 %", "34 … 66 %", "67 … 100 %")[min(math.floor(3.0 * share), 2)]
