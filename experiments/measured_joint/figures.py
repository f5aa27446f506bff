"""Pictures of the study: data in, figures out."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.measured_joint.prediction import Error
from experiments.measured_joint.recording import ANGLE, COMMAND, TENSIONS
from experiments.measured_joint.report import BETWEEN_LIMIT, BEYOND_LIMIT
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT
from experiments.measured_joint.study import Shown, Study
from tendon_mj.lab.recordings import Recording
from tendon_mj.show.style import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    SERIES,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_SPLITS = {BETWEEN: "0, 120, 240° given", BEYOND: "0, 120° given"}
_TITLES = {
    BETWEEN: "bends between the given\n(0, 120, 240°)",
    BEYOND: "bends beyond the given\n(0, 120°)",
    LEFT_OUT: "each bend left out",
}
_ASKED = {BETWEEN: BETWEEN_LIMIT, BEYOND: BEYOND_LIMIT}


def draw_angles(study: Study) -> Figure:
    """Draw the joint's angle over the command."""
    with print_style():
        figure, panels = _panels(study)
        for axes, given, one in panels:
            command = _degrees(one.measured, COMMAND)
            before, after = one.errors
            for recording, colour, style, width, label in (
                (one.measured, GREY, "-", 2.6, "measured"),
                (one.before, ORANGE, "-.", 1.2, "simulated before (no friction in the sheath)"),
                (one.after, BLUE, "--", 1.4, "simulated after"),
            ):
                angle = _degrees(recording, ANGLE)
                axes.plot(command, angle, style, color=colour, linewidth=width, label=label)
            axes.set(
                title=f"{after.bend}° ({given}): {math.degrees(before.rms[ANGLE]):.1f} →"
                f" {math.degrees(after.rms[ANGLE]):.1f}° rms",
                ylabel="joint angle [°]",
            )
        legend_below(figure, panels[0][0], columns=3)
    return figure


def draw_tensions(study: Study) -> Figure:
    """Draw the tensions over the command, without the start."""
    with print_style():
        figure, panels = _panels(study)
        for axes, given, one in panels:
            command = _degrees(one.measured, COMMAND)
            _, after = one.errors
            for k, column in enumerate(TENSIONS):
                axes.plot(
                    command,
                    one.measured.columns[column],
                    color=(GREY, BLACK)[k],
                    linewidth=(2.6, 1.0)[k],
                    label=f"tension {k + 1}, measured",
                )
                axes.plot(
                    command,
                    one.after.columns[column],
                    ("--", ":")[k],
                    color=(BLUE, VERMILLION)[k],
                    linewidth=1.4,
                    label=f"tension {k + 1}, simulated after",
                )
            errors = ", ".join(f"{after.rms[column]:.2f}" for column in TENSIONS)
            axes.set(title=f"{after.bend}° ({given}): {errors} N rms", ylabel="tension [N]")
        legend_below(figure, panels[0][0], columns=2)
    return figure


def _panels(study: Study) -> tuple[Figure, list[tuple[Axes, str, Shown]]]:
    """A figure with axes for each held-out bend, over the command."""
    shown = [(_SPLITS[split], one) for split in _SPLITS for one in study.diagnoses[split][0].shown]
    rows = math.ceil(len(shown) / 2)
    figure = new_figure(8.0, 2.9 * rows + 0.6)
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for axes in grid[-1]:
        axes.set_xlabel("command [°]")
    return figure, [(axes, *panel) for axes, panel in zip(grid.flat, shown, strict=False)]


def _degrees(recording: Recording, column: str) -> list[float]:
    return [math.degrees(value) for value in recording.columns[column]]


def draw_held_out(study: Study) -> Figure:
    """Draw every held-out error of the angle, with the limit."""
    with print_style():
        names = ["diagnosis", *study.errors]
        figure = new_figure(9.0, 0.36 * len(names) + 1.9)
        panels = figure.subplots(1, len(_TITLES), sharey=True)
        for axes, (split, title) in zip(panels, _TITLES.items(), strict=True):
            rows = {name: study.errors[name][split] for name in study.errors}
            rows["diagnosis"] = study.diagnosed_errors(split)
            bends = sorted({one.bend for errors in rows.values() for one in errors})
            for bend, (colour, _, marker) in zip(bends, SERIES * 2, strict=False):
                points = [
                    (_error_degrees(one), names.index(name))
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


def _error_degrees(error: Error) -> float:
    return math.degrees(error.rms[ANGLE])


def draw_figures(study: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "angle", draw_angles(study)
    yield "tension", draw_tensions(study)
    yield "held_out", draw_held_out(study)
