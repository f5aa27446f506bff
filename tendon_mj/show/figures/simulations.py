"""Figures of simulations: next to a recording, before and after a diagnosis, or of a sweep."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.errors import RecordingError
from tendon_mj.lab import replay
from tendon_mj.lab.noise import noise_levels
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.sweep import bins_of
from tendon_mj.lab.units import column_name, column_unit, engineering_unit
from tendon_mj.models import JOINTS, TENDON_COLOUR, TENDONS
from tendon_mj.show import style
from tendon_mj.typing import FloatArray

RECORDED = "recording"  # which may itself be simulated; its source is in the title
_BAND = 2.0  # half width of the noise band over the noise [-]
_JOINT_COLOURS = dict(zip(JOINTS, (style.GREEN, style.PURPLE, style.ORANGE), strict=True))
_LINES = ("-", (0, (4, 1.5)), (0, (1, 1)))
_SHADES = ("black", style.GREY, style.GREY)
_MIDDLE = (0.05, 0.5, 0.95)
_MOST_POINTS = 2000  # beyond which single points merge


def replay_figure(measured: Recording, simulated: Mapping[str, Recording]) -> Figure:
    """Draw every measured column, a row each: over time, and over the first driven column.

    Over the drive the cycles of a rate-independent response coincide. The legend gives each rms
    error of the simulations, by label.
    """
    if not measured.measured:
        raise RecordingError(f"recording {measured.name!r}: no [measured] column to draw")
    errors = {label: replay.replay_error(measured, answer) for label, answer in simulated.items()}
    drive = next(iter(measured.drive), "")
    driven = measured.columns[drive] if drive else measured.time
    across = style.drawn_unit(drive, driven)
    rows = len(measured.measured)
    with style.print_style():
        figure = style.new_figure(9.5 if drive else 6.5, 0.6 + 2.2 * rows)
        source = textwrap.fill(f"recording: {measured.source}", 110)
        figure.suptitle(
            f"{measured.name}, described for model {Path(measured.model).name}\n{source}",
            fontsize=9.0,
            parse_math=False,
        )
        ratios = (1.25, 1.0, 0.5) if drive else (1.25, 0.6)
        grid = figure.subplots(rows, len(ratios), squeeze=False, sharex="col", width_ratios=ratios)
        for (time, *over, key), column in zip(grid, measured.measured, strict=True):
            series = {RECORDED: measured.columns[column]}
            series |= {label: answer.columns[column] for label, answer in simulated.items()}
            unit = style.drawn_unit(column, *series.values())
            series = {label: unit.factor * values for label, values in series.items()}
            _draw_replay(time, measured.time, series)
            time.set_ylabel(style.column_label(column, unit))
            for axes in over:
                _draw_replay(axes, across.factor * driven, series)
                axes.sharey(time)
                axes.tick_params(labelleft=False)
            _draw_key(key, time, column, {label: e[column].rmse for label, e in errors.items()})
        grid[-1][0].set_xlabel("time [s]")
        if drive:
            grid[-1][1].set_xlabel(style.column_label(drive, across))
    return figure


def _draw_replay(axes: Axes, x: FloatArray, series: Mapping[str, FloatArray]) -> None:
    axes.plot(x, series[RECORDED], color=style.PALE, linewidth=2.8, label=RECORDED)
    simulated = [(label, values) for label, values in series.items() if label != RECORDED]
    for k, (label, values) in enumerate(simulated):
        colour, dashes, marker = style.SERIES[k % len(style.SERIES)]
        axes.plot(
            x,
            values,
            color=colour,
            linestyle=dashes,
            marker=marker,
            markersize=3.5,
            markevery=(0.03 * (k + 1), 0.13),  # shares of the diagonal: some, wherever it goes
            label=label,
        )


def _draw_key(key: Axes, drawn: Axes, column: str, rms: Mapping[str, float]) -> None:
    """The legend of a row, next to it."""
    key.set_axis_off()
    unit = engineering_unit(column_unit(column), rms.values())
    handles, labels = drawn.get_legend_handles_labels()
    texts = [
        f"{label}\nrms error {unit.write(rms[label])}" if label in rms else label
        for label in labels
    ]
    key.legend(handles, texts, loc="center left", borderaxespad=0.0, labelspacing=0.9)


def before_after_figure(
    measured: Recording, before: Recording, after: Recording | None = None
) -> Figure:
    """Draw every measured column over the driven one and over time, and below it the residual.

    There is no ``after`` if nothing was changed.
    """
    if not measured.measured or not measured.drive:
        raise RecordingError(f"recording {measured.name!r}: nothing in [drive] or in [measured]")
    simulated = {"before": before, "after": after} if after else {"simulated": before}
    errors = {label: replay.replay_error(measured, answer) for label, answer in simulated.items()}
    drive = next(iter(measured.drive))
    across = style.drawn_unit(drive, measured.columns[drive])
    driven = across.factor * measured.columns[drive]
    rows = len(measured.measured)
    with style.print_style():
        figure = style.new_figure(8.0, 0.9 + 3.1 * rows)
        on = f"{measured.name} on model {Path(measured.model).name}"
        source = textwrap.fill(f"{on}: {measured.source}", 105)
        figure.suptitle(source, fontsize=9.0, parse_math=False)
        grid = figure.subplots(
            2 * rows, 2, squeeze=False, sharex="col", sharey="row", height_ratios=(1.7, 1.0) * rows
        )
        for k, column in enumerate(measured.measured):
            for panels, x in zip(grid[2 * k : 2 * k + 2].T, (driven, measured.time), strict=True):
                _draw_residual(panels, x, measured, column, simulated)
            rms = {label: misfits[column].rmse for label, misfits in errors.items()}
            grid[2 * k][0].set_title(_title(measured, column, rms), fontsize=9.0)
        grid[-1][0].set_xlabel(style.column_label(drive, across))
        grid[-1][0].locator_params(axis="x", nbins=5)
        grid[-1][1].set_xlabel("time [s]")
        band = grid[1][0].patches[0].get_label()  # for the legend of the upper panel
        grid[0][0].fill_between([], [], [], color=style.PALE, alpha=0.5, linewidth=0.0, label=band)
        style.legend_below(figure, grid[0][0], columns=4)
    return figure


def _draw_residual(
    panels: Iterable[Axes],
    x: FloatArray,
    measured: Recording,
    column: str,
    simulated: Mapping[str, Recording],
) -> None:
    """Draw a measured column and its simulations, and below it their residuals."""
    upper, lower = panels
    unit = style.drawn_unit(column, measured.columns[column])
    true = unit.factor * measured.columns[column]
    band = _BAND * (unit.factor * noise_levels(measured)[column])
    upper.plot(x, true, color=style.PALE, linewidth=3.0, label="measured")
    label = f"±{_BAND:g} × noise"
    lower.axhspan(-band, band, color=style.PALE, alpha=0.5, linewidth=0.0, label=label)
    looks = (style.VERMILLION, "-"), (style.BLUE, "--")  # where they agree, both are seen
    for (name, answer), (colour, line) in zip(simulated.items(), looks, strict=False):
        values = unit.factor * answer.columns[column]
        upper.plot(x, values, color=colour, linestyle=line, linewidth=1.1, label=name)
        lower.plot(x, values - true, color=colour, linestyle=line, linewidth=1.1, label="_residual")
    if upper.get_subplotspec().is_first_col():  # type: ignore[union-attr]
        upper.set_ylabel(style.column_label(column, unit))
        lower.set_ylabel(f"simulated −\nmeasured [{unit.symbol}]")


def _title(measured: Recording, column: str, rms: Mapping[str, float]) -> str:
    """A signal's errors and its noise, in one unit."""
    noise = noise_levels(measured)[column]
    unit = engineering_unit(column_unit(column), [*rms.values(), noise])
    errors = ", ".join(f"{unit.write(error)} {name}" for name, error in rms.items())
    return f"{column_name(column)}: rms error {errors}; noise {unit.write(noise, 2)}"


def finger_figure(answers: Mapping[str, Recording]) -> Figure:
    """Draw motions of the finger, label → recording, over time and over the input tension.

    Colours stand for joints or tendons, line styles for the labels.
    """
    first = next(iter(answers.values()))

    def of_all(column: str) -> list[FloatArray]:
        return [answer.columns[column] for answer in answers.values()]

    with style.print_style():
        pressing = any(answer.columns["tip_force_N"].any() for answer in answers.values())
        rows = 3 if pressing else 2
        figure = style.new_figure(10.0, 0.8 + 2.2 * rows)
        figure.suptitle(f"{first.name} on model {first.model}", fontweight="bold")
        grid = figure.subplots(rows, 2, sharex="col", width_ratios=(1.5, 1.0))
        _draw_joints(grid[0, 0], answers)
        _draw_tensions(grid[1, 0], answers)
        flexor, angle = of_all("flexor_input_tension_N"), of_all("mcp_angle_rad")
        output, force = of_all("flexor_output_tension_N"), of_all("tip_force_N")
        _draw_shaded(grid[0, 1], flexor, np.degrees(angle), "MCP angle [deg]")
        _draw_shaded(grid[1, 1], flexor, output, "flexor, output [N]")
        if pressing:
            times = [answer.time for answer in answers.values()]
            _draw_shaded(grid[2, 0], times, force, "tip force [N]", width=1.5)
            _draw_shaded(grid[2, 1], flexor, force, "tip force [N]")
        grid[-1, 0].set_xlabel("time [s]")
        grid[-1, 1].set_xlabel("flexor, input tension [N]")
        for k, label in enumerate(answers):
            grid[-1, 1].plot([], [], color=_SHADES[k % 3], linestyle=_LINES[k % 3], label=label)
        style.legend_below(figure, grid[-1, 1], len(answers))
    return figure


def _draw_joints(axes: Axes, answers: Mapping[str, Recording]) -> None:
    for k, answer in enumerate(answers.values()):
        for joint, colour in _JOINT_COLOURS.items():
            angle = np.degrees(answer.columns[f"{joint}_angle_rad"])
            label, dashes = joint.upper() if k == 0 else "", _LINES[k % 3]
            axes.plot(answer.time, angle, color=colour, linestyle=dashes, label=label)
    first = next(iter(answers.values()))
    targets = [c for c in first.columns if c.startswith("asked_") and c.endswith("_rad")]
    for column in targets:
        angle = np.degrees(first.columns[column])
        axes.plot(first.time, angle, color=style.GREY, linewidth=0.7, zorder=0)
    if targets:
        axes.plot([], [], color=style.GREY, linewidth=0.7, label="asked for")
    axes.set_ylabel("joint angle [deg]")
    _key(axes)


def _draw_tensions(axes: Axes, answers: Mapping[str, Recording]) -> None:
    """Input ends strong, output ends pale."""
    first = next(iter(answers.values()))
    ends = [
        (tendon, end, alpha)
        for tendon in TENDONS
        if f"{tendon}_input_tension_N" in first.columns
        for end, alpha in (("input", 1.0), ("output", 0.4))
    ]
    for k, answer in enumerate(answers.values()):
        for tendon, end, alpha in ends:
            look: dict[str, Any] = {"color": TENDON_COLOUR[tendon], "alpha": alpha}
            values = answer.columns[f"{tendon}_{end}_tension_N"]
            label = f"{tendon}, {end}" if k == 0 else ""
            axes.plot(answer.time, values, linestyle=_LINES[k % 3], label=label, **look)
    axes.set_ylabel("tension [N]")
    _key(axes)


def _draw_shaded(
    axes: Axes, x: Iterable[FloatArray], y: Iterable[FloatArray], label: str, width: float = 1.1
) -> None:
    """Draw a curve for each answer, in its shade."""
    for k, (across, up) in enumerate(zip(x, y, strict=True)):
        axes.plot(across, up, color=_SHADES[k % 3], linestyle=_LINES[k % 3], linewidth=width)
    axes.set_ylabel(label)


def _key(axes: Axes) -> None:
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.0)


def parameter_figure(
    parameters: Mapping[str, FloatArray], outputs: Mapping[str, FloatArray], drawn: Collection[str]
) -> Figure:
    """Draw each output of a sweep over each parameter: median and middle 90 % of all rollouts.

    Both are (rollouts,) by label, a column and a row each; ``drawn``: parameters drawn at random.
    """
    rows, columns = len(outputs), len(parameters)
    with style.print_style():
        figure = style.new_figure(1.2 + 2.9 * columns, 0.7 + 2.1 * rows)
        grid = figure.subplots(rows, columns, sharex="col", sharey="row", squeeze=False)
        for line, (output, values) in zip(grid, outputs.items(), strict=True):
            for axes, (parameter, given) in zip(line, parameters.items(), strict=True):
                _draw_spread(axes, given, values, parameter in drawn)
                if axes in grid[-1]:
                    axes.set_xlabel(parameter)
            line[0].set_ylabel(output)
        style.legend_below(figure, grid[0, 0], columns=3)
    return figure


def _draw_spread(axes: Axes, given: FloatArray, values: FloatArray, drawn: bool) -> None:
    place = bins_of(given, drawn)
    numbers = np.unique(place)
    middle = np.array([np.median(given[place == k]) for k in numbers])
    low, median, high = np.array([np.quantile(values[place == k], _MIDDLE) for k in numbers]).T
    if len(values) <= _MOST_POINTS:
        look: dict[str, Any] = {"color": style.GREY, "markersize": 2.5, "alpha": 0.5}
        axes.plot(given, values, ".", label="a rollout", **look)
    if len(values) > len(numbers):  # else each value has one rollout
        axes.fill_between(middle, low, high, color=style.SKY, alpha=0.35, lw=0, label="middle 90 %")
    axes.plot(middle, median, color=style.BLUE, label="median")
