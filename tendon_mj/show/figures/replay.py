"""Measured and simulated columns, over time and over the drive."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import (
    Misfit,
    column_unit,
    engineering_unit,
    plain,
    replay_error,
    with_unit,
)
from tendon_mj.show.figures.labels import column_label, drawn_unit
from tendon_mj.show.figures.style import PALE, SERIES, new_figure, print_style
from tendon_mj.typing import FloatArray

RECORDED = "recording"  # which may itself be simulated; its source is in the title


def replay_figure(measured: Recording, simulated: Mapping[str, Recording]) -> Figure:
    """Draw every measured column, a row each: over time, and over the first driven column.

    Over the drive a rate-independent response lies on itself cycle for cycle, whatever the clock
    said.

    Args:
        measured: with at least one measured column.
        simulated: label → the same columns, simulated; the legend gives each rms error.

    Returns:
        A figure.

    Raises:
        RecordingError: nothing was measured, or a simulation has other times or columns.
    """
    if not measured.measured:
        raise RecordingError(f"recording {measured.name!r}: no [measured] column to draw")
    errors = {label: replay_error(measured, answer) for label, answer in simulated.items()}
    drive = next(iter(measured.drive), "")
    driven = measured.columns[drive] if drive else measured.time
    across = drawn_unit(drive, driven)
    rows = len(measured.measured)
    with print_style():
        figure = new_figure(9.5 if drive else 6.5, 0.6 + 2.2 * rows)
        source = textwrap.fill(f"recording: {measured.source}", 110)
        figure.suptitle(
            f"{measured.name} on model {measured.model}\n{source}", fontsize=9.0, parse_math=False
        )
        ratios = (1.25, 1.0, 0.5) if drive else (1.25, 0.6)
        grid = figure.subplots(rows, len(ratios), squeeze=False, sharex="col", width_ratios=ratios)
        for (time, *over, key), column in zip(grid, measured.measured, strict=True):
            series = {RECORDED: measured.columns[column]}
            series |= {label: answer.columns[column] for label, answer in simulated.items()}
            unit = drawn_unit(column, *series.values())
            series = {label: unit.factor * one for label, one in series.items()}
            _draw(time, measured.time, series)
            time.set_ylabel(column_label(column, unit))
            for axes in over:
                _draw(axes, across.factor * driven, series)
                axes.sharey(time)
                axes.tick_params(labelleft=False)
            _draw_key(key, time, column, {label: e[column] for label, e in errors.items()})
        grid[-1][0].set_xlabel("time [s]")
        if drive:
            grid[-1][1].set_xlabel(column_label(drive, across))
    return figure


def _draw(axes: Axes, x: FloatArray, series: Mapping[str, FloatArray]) -> None:
    axes.plot(x, series[RECORDED], color=PALE, linewidth=2.8, label=RECORDED)
    for k, (label, answer) in enumerate(one for one in series.items() if one[0] != RECORDED):
        colour, style, marker = SERIES[k % len(SERIES)]
        axes.plot(
            x,
            answer,
            color=colour,
            linestyle=style,
            marker=marker,
            markersize=3.5,
            markevery=(0.03 * (k + 1), 0.13),  # shares of the diagonal: some, wherever it goes
            label=label,
        )


def _draw_key(key: Axes, drawn: Axes, column: str, errors: Mapping[str, Misfit]) -> None:
    """The legend of a row, beside it."""
    key.set_axis_off()
    rms = {label: error.rmse for label, error in errors.items()}
    unit = engineering_unit(column_unit(column), rms.values())
    handles, labels = drawn.get_legend_handles_labels()
    said = [
        f"{label}\nrms error {with_unit(plain(unit.factor * rms[label]), unit)}"
        if label in rms
        else label
        for label in labels
    ]
    key.legend(handles, said, loc="center left", borderaxespad=0.0, labelspacing=0.9)
