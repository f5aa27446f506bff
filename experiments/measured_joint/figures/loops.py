"""Figures of held-out recordings over the command: measured, and simulated before and after."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from experiments.measured_joint.recording import ANGLE, COMMAND, TENSIONS
from experiments.measured_joint.splits import BETWEEN, BEYOND
from experiments.measured_joint.study import Shown, Study
from tendon_mj.view import (
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
    panels = _panels(found)
    with print_style():
        figure = new_figure(8.0, 2.9 * math.ceil(len(panels) / 2) + 0.6)
        grid = figure.subplots(math.ceil(len(panels) / 2), 2, sharex=True, squeeze=False)
        for axes, (given, one) in zip(grid.flat, panels, strict=False):
            command = _degrees(one, COMMAND)
            before, after = one.errors
            for recording, colour, style, width, label in (
                (one.measured, GREY, "-", 2.6, "measured"),
                (one.before, ORANGE, "-.", 1.2, "simulated before (no friction in the sheath)"),
                (one.after, BLUE, "--", 1.4, "simulated after"),
            ):
                angle = [math.degrees(value) for value in recording.columns[ANGLE]]
                axes.plot(command, angle, style, color=colour, linewidth=width, label=label)
            axes.set(
                title=f"{after.bend}° ({given}): {math.degrees(before.rms[ANGLE]):.1f} →"
                f" {math.degrees(after.rms[ANGLE]):.1f}° rms",
                ylabel="joint angle [°]",
            )
        _label(grid)
        legend_below(figure, grid[0, 0], columns=3)
    return figure


def draw_tensions(found: Study) -> Figure:
    """Draw the tensions over the command; what they were before is left out."""
    panels = _panels(found)
    with print_style():
        figure = new_figure(8.0, 2.9 * math.ceil(len(panels) / 2) + 0.6)
        grid = figure.subplots(math.ceil(len(panels) / 2), 2, sharex=True, squeeze=False)
        for axes, (given, one) in zip(grid.flat, panels, strict=False):
            command = _degrees(one, COMMAND)
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
        _label(grid)
        legend_below(figure, grid[0, 0], columns=2)
    return figure


def _panels(found: Study) -> list[tuple[str, Shown]]:
    return [(_SPLITS[split], one) for split in _SPLITS for one in found.diagnoses[split][0].shown]


def _degrees(one: Shown, column: str) -> list[float]:
    return [math.degrees(value) for value in one.measured.columns[column]]


def _label(grid: object) -> None:
    for axes in grid[-1]:  # type: ignore[index]
        axes.set_xlabel("command [°]")
