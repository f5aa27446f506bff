"""The finger along a trajectory, with friction and without: joints, tensions, tip force."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.recordings import Recording
from tendon_mj.models import JOINTS, TENDON_COLOUR, TENDONS
from tendon_mj.show.figures.style import (
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    legend_below,
    new_figure,
    print_style,
)

_JOINT_COLOURS = dict(zip(JOINTS, (GREEN, PURPLE, ORANGE), strict=True))
_LINES = ("-", (0, (4, 1.5)), (0, (1, 1)))
_SHADES = ("black", GREY, GREY)


def finger_figure(answers: Mapping[str, Recording]) -> Figure:
    """Draw motions of the finger: over time on the left, over the input tension on the right.

    Args:
        answers: label → recording from `simulate_finger`, all of one trajectory.

    Returns:
        A figure. Colours tell joints or tendons apart, line styles the labels.
    """
    one = next(iter(answers.values()))
    tendons = [t for t in TENDONS if f"{t}_input_tension_N" in one.columns]
    with print_style():
        pressing = any(answer.columns["tip_force_N"].any() for answer in answers.values())
        rows = 3 if pressing else 2
        figure = new_figure(10.0, 0.8 + 2.2 * rows)
        figure.suptitle(f"{one.name} on model {one.model}", fontweight="bold")
        grid = figure.subplots(rows, 2, sharex="col", width_ratios=(1.5, 1.0))
        _draw_joints(grid[0, 0], answers)
        _draw_tensions(grid[1, 0], answers, tendons)
        _draw_loop(grid[0, 1], answers, "mcp_angle_rad", "MCP angle [deg]", np.degrees)
        _draw_loop(grid[1, 1], answers, "flexor_output_tension_N", "flexor, output [N]")
        if pressing:
            _draw_force(grid[2, 0], answers)
            _draw_loop(grid[2, 1], answers, "tip_force_N", "tip force [N]")
        grid[-1, 0].set_xlabel("time [s]")
        grid[-1, 1].set_xlabel("flexor, input tension [N]")
        for k, label in enumerate(answers):
            grid[-1, 1].plot([], [], color=_SHADES[k % 3], linestyle=_LINES[k % 3], label=label)
        legend_below(figure, grid[-1, 1], len(answers))
    return figure


def _draw_joints(axes: Axes, answers: Mapping[str, Recording]) -> None:
    for k, answer in enumerate(answers.values()):
        for joint, colour in _JOINT_COLOURS.items():
            angle = np.degrees(answer.columns[f"{joint}_angle_rad"])
            axes.plot(answer.time, angle, color=colour, linestyle=_LINES[k % 3])
            if k == 0:
                axes.plot([], [], color=colour, label=joint.upper())
        asked = [c for c in answer.columns if c.startswith("asked_") and c.endswith("_rad")]
        for column in asked if k == 0 else []:
            values = np.degrees(answer.columns[column])
            axes.plot(answer.time, values, color=GREY, linewidth=0.7, zorder=0)
        if asked and k == 0:
            axes.plot([], [], color=GREY, linewidth=0.7, label="asked for")
    axes.set_ylabel("joint angle [deg]")
    _key(axes)


def _draw_tensions(axes: Axes, answers: Mapping[str, Recording], tendons: list[str]) -> None:
    """Input ends strong, output ends pale."""
    for k, answer in enumerate(answers.values()):
        for tendon in tendons:
            colour = TENDON_COLOUR[tendon]
            for end, alpha in (("input", 1.0), ("output", 0.4)):
                values = answer.columns[f"{tendon}_{end}_tension_N"]
                name = f"{tendon}, {end}" if k == 0 else None
                axes.plot(answer.time, values, color=colour, alpha=alpha, linestyle=_LINES[k % 3])
                if name:
                    axes.plot([], [], color=colour, alpha=alpha, label=name)
    axes.set_ylabel("tension [N]")
    _key(axes)


def _draw_force(axes: Axes, answers: Mapping[str, Recording]) -> None:
    for k, answer in enumerate(answers.values()):
        force = answer.columns["tip_force_N"]
        axes.plot(answer.time, force, color=_SHADES[k % 3], linestyle=_LINES[k % 3])
    axes.set_ylabel("tip force [N]")


def _draw_loop(
    axes: Axes,
    answers: Mapping[str, Recording],
    column: str,
    label: str,
    convert: np.ufunc = np.positive,
) -> None:
    for k, answer in enumerate(answers.values()):
        tension = answer.columns["flexor_input_tension_N"]
        values = convert(answer.columns[column])
        axes.plot(tension, values, color=_SHADES[k % 3], linewidth=1.1, linestyle=_LINES[k % 3])
    axes.set_ylabel(label)


def _key(axes: Axes) -> None:
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.0)
