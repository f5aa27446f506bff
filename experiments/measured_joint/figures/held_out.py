"""Figure of the angle error on held-out bends, candidate by candidate."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from experiments.measured_joint import asked
from experiments.measured_joint.prediction import Error
from experiments.measured_joint.recording import ANGLE
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT
from experiments.measured_joint.study import Study
from tendon_mj.show import BLACK, SERIES, new_figure, print_style

_TITLES = {
    BETWEEN: "bends between the given\n(0, 120, 240°)",
    BEYOND: "bends beyond the given\n(0, 120°)",
    LEFT_OUT: "each bend left out",
}
_ASKED = {BETWEEN: asked.BETWEEN, BEYOND: asked.BEYOND}


def draw_held_out(found: Study) -> Figure:
    """Draw every held-out error of the angle, with what was asked."""
    with print_style():
        names = ["diagnosis", *found.errors]
        figure = new_figure(9.0, 0.36 * len(names) + 1.9)
        panels = figure.subplots(1, len(_TITLES), sharey=True)
        for axes, (split, title) in zip(panels, _TITLES.items(), strict=True):
            rows = {name: found.errors[name][split] for name in found.errors}
            rows["diagnosis"] = found.diagnosed_errors(split)
            bends = sorted({one.bend for errors in rows.values() for one in errors})
            for bend, (colour, _, marker) in zip(bends, SERIES * 2, strict=False):
                points = [
                    (_degrees(one), names.index(name))
                    for name, errors in rows.items()
                    for one in errors
                    if one.bend == bend
                ]
                axes.plot(
                    *np.array(points).T,
                    marker,
                    color=colour,
                    markerfacecolor="none",
                    label=f"{bend}°",
                )
            if split in _ASKED:
                axes.axvline(
                    math.degrees(_ASKED[split]), color=BLACK, linestyle="--", label="asked"
                )
            axes.set(title=title, xlabel="angle error, rms [°]")
            axes.set_xlim(left=0.0)
            axes.legend(loc="upper right", fontsize=7.0)
        panels[0].set_yticks(np.arange(len(names)), names, fontsize=7.5)
        panels[0].invert_yaxis()
    return figure


def _degrees(error: Error) -> float:
    return math.degrees(error.rms[ANGLE])
