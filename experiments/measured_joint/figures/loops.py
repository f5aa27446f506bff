"""Figures of held-out recordings over the command: measured, and simulated before and after."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.measured_joint.recording import ANGLE, COMMAND, TENSIONS
from experiments.measured_joint.splits import BETWEEN, BEYOND
from experiments.measured_joint.study import Shown, Study
from tendon_mj.lab.recordings import Recording
from tendon_mj.show import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_SPLITS = {BETWEEN: "0, 120, 240° given", BEYOND: "0, 120° given"}


def draw_angles(found: Study) -> Figure:
    """Draw the joint's angle over the command."""
    with print_style():
        figure, panels = _panels(found)
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


def draw_tensions(found: Study) -> Figure:
    """Draw the tensions over the command; what they were before is left out."""
    with print_style():
        figure, panels = _panels(found)
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


def _panels(found: Study) -> tuple[Figure, list[tuple[Axes, str, Shown]]]:
    """A figure with axes for each held-out bend, over the command."""
    shown = [(_SPLITS[split], one) for split in _SPLITS for one in found.diagnoses[split][0].shown]
    rows = math.ceil(len(shown) / 2)
    figure = new_figure(8.0, 2.9 * rows + 0.6)
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for axes in grid[-1]:
        axes.set_xlabel("command [°]")
    return figure, [(axes, *panel) for axes, panel in zip(grid.flat, shown, strict=False)]


def _degrees(recording: Recording, column: str) -> list[float]:
    return [math.degrees(value) for value in recording.columns[column]]
