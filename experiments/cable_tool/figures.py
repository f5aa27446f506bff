"""Pictures of the study: data in, figures out."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from experiments.cable_tool.candidates import CHOSEN
from experiments.cable_tool.cross_validation import LEFT_OUT
from experiments.cable_tool.fit import fit_tool
from experiments.cable_tool.recording import MID_STROKE
from experiments.cable_tool.report import TORQUE_ASKED, TORQUE_PUBLISHED
from experiments.cable_tool.study import Study
from tendon_mj.show.style import (
    BLACK,
    BLUE,
    GREY,
    SERIES,
    SKY,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_MARKERS = {"straight": "o", "pitch": "s", "roll": "^"}
_SHOWN = 10.5  # [s]
_COMPARED = (CHOSEN, "steady load", "regression by direction")
_THIN = 4  # every so many samples are drawn


def draw_sheath_friction(study: Study) -> Figure:
    """Draw T_in over load of every recording, and the lines of a capstan with constant friction."""
    with print_style():
        figure = new_figure(6.4, 4.6)
        axes = figure.subplots()
        drawn = set()
        for recording in study.recordings:
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
        tool = study.tool
        opening = float(np.median([tool.opening(r) for r in study.recordings]))
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


def draw_prediction(study: Study) -> Figure:
    """Draw one recording of each group: its wrist pose, or load, left out of the fit.

    Of each group the one of median error is shown.
    """
    with print_style():
        figure = new_figure(7.4, 7.0)
        groups = [g for g in ("straight", "pitch", "roll") if study.chosen("pose", g)]
        panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
        for axes, group in zip(panels, groups, strict=True):
            kind = "load" if group == "straight" else "pose"
            value = LEFT_OUT[kind]
            errors = sorted(study.chosen(kind, group), key=lambda one: one.torque)
            one = errors[len(errors) // 2]
            recording = next(r for r in study.recordings if r.name == one.name)
            tool = fit_tool([r for r in study.recordings if value(r) != value(recording)])
            shown = recording.time <= _SHOWN
            time = recording.time[shown]
            axes.plot(
                time,
                1e3 * recording.input_torque[shown],
                color=SKY,
                linewidth=1.0,
                label="input torque",
            )
            axes.plot(
                time, 1e3 * recording.load[shown], color=GREY, linewidth=2.6, label="measured load"
            )
            axes.plot(
                time,
                1e3 * tool.load(recording)[shown],
                "--",
                color=VERMILLION,
                label="predicted load",
            )
            axes.axhline(0.0, color=BLUE, linewidth=0.5)
            axes.set(
                ylabel="torque [mN m]",
                title=f"{recording.name.replace('_', ' ')}, its {kind} left out: "
                f"{1e3 * one.torque:.1f} mN m rms",
            )
        panels[-1].set_xlabel("time [s]")
        legend_below(figure, panels[0], columns=3)
    return figure


def draw_held_out(study: Study) -> Figure:
    """Draw the error where the output slides, of every recording, its load or its pose left out."""
    with print_style():
        figure = new_figure(8.0, 5.4)
        panels = figure.subplots(1, 2, sharey=True)
        names = [r.name for r in study.recordings]
        labels = [name.replace("_yaw0", "").replace("_", " ") for name in names]
        for axes, left_out in zip(panels, ("load", "pose"), strict=True):
            for candidate, (colour, _, marker) in zip(_COMPARED, SERIES, strict=False):
                errors = {one.name: one for one in study.errors(candidate, left_out)}
                axes.plot(
                    [1e3 * errors[name].torque_sliding for name in names],
                    np.arange(len(names)),
                    marker,
                    color=colour,
                    markerfacecolor=colour if candidate == CHOSEN else "none",
                    label=candidate,
                )
            axes.axvline(1e3 * TORQUE_ASKED, color=BLACK, linestyle="--", label="asked")
            axes.axvline(
                1e3 * TORQUE_PUBLISHED,
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


def draw_residual(study: Study) -> Figure:
    """Draw predicted less measured load; the fit has seen these recordings."""
    with print_style():
        poses = sorted({r.pose for r in study.recordings})
        figure = new_figure(8.4, 2.2 * len(poses) * 0.72 + 1.2)
        panels = figure.subplots(len(poses), 2, sharex=True, sharey=True, squeeze=False)
        loads = sorted({_load_class(r.load_share) for r in study.recordings})
        for row, pose in zip(panels, poses, strict=True):
            for axes, sense, name in zip(row, (-1.0, 1.0), ("closing", "opening"), strict=True):
                for recording in (r for r in study.recordings if r.pose == pose):
                    strokes = recording.strokes
                    error = study.tool.load(recording) - recording.load
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


def draw_figures(study: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "sheath_friction", draw_sheath_friction(study)
    yield "prediction", draw_prediction(study)
    yield "held_out", draw_held_out(study)
    yield "residual", draw_residual(study)
