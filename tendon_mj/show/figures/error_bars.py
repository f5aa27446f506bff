"""Rms error of every signal, before and after, as bars in units of the noise."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import ErrorReduction
from tendon_mj.lab.replay import EngineeringUnit, column_unit, engineering_unit, plain, with_unit
from tendon_mj.show.figures.labels import column_name
from tendon_mj.show.figures.style import (
    BLACK,
    BLUE,
    GREY,
    PURPLE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_BEFORE, _SYSID, _AFTER = "before", "mujoco.sysid alone", "after"
_CALIBRATED, _FLOOR = "calibrated, nothing added", "noise and reproducibility"
_HATCHED = (VERMILLION, "////")
_COLOURS = {_CALIBRATED: _HATCHED, _BEFORE: _HATCHED, _SYSID: (PURPLE, "...."), _AFTER: (BLUE, "")}
_AXIS_SPAN = 1.5  # over the longest bar, for the label behind it


def error_bars_figure(
    train: ErrorReduction,
    held_out: ErrorReduction,
    sysid: Mapping[str, float] | None = None,
    *,
    changed: bool = True,
    floors: Mapping[str, float] | None = None,
) -> Figure:
    """Draw rms errors before and after, in units of the noise, labelled in the signal's unit.

    Args:
        train, held_out: errors on training data and on held-out data.
        sysid: column → held-out rms error of `mujoco.sysid` alone [the column's unit].
        changed: whether the model was changed, so that there is an after.
        floors: column → noise and reproducibility together on held-out data [noise], where
            sessions of the rig differ.

    Returns:
        A figure with a row for each signal, and a panel each for training and held-out data.
    """
    columns = list(held_out.signals)
    with print_style():
        figure = new_figure(8.0, 1.0 + 1.15 * len(columns))
        grid = figure.subplots(len(columns), 2, squeeze=False, sharex=True)
        longest = 1.0
        for row, column in zip(grid, columns, strict=True):
            shown = [*held_out.signals[column][:2], *train.signals.get(column, ())[:2]]
            unit = engineering_unit(column_unit(column), shown)
            for axes, errors, extra in zip(row, (train, held_out), (None, sysid), strict=True):
                before, after, noise = errors.signals.get(column, (0.0, 0.0, 1.0))
                bars = {_BEFORE if changed else _CALIBRATED: before}
                if extra and column in extra:
                    bars[_SYSID] = extra[column]
                if changed:
                    bars[_AFTER] = after
                _draw(axes, bars, noise, unit)
                if floors and errors is held_out:
                    axes.axvline(floors[column], color=GREY, linewidth=1.3, label=_FLOOR)
                longest = max(longest, *(value / noise for value in bars.values()))
            row[0].set_ylabel(column_name(column))
        grid[0][0].set_xlim(0.0, _AXIS_SPAN * longest)
        grid[0][0].set_title("training data: selection and fit")
        grid[0][1].set_title("held-out data")
        for axes in grid[-1]:
            axes.set_xlabel("rms error [× noise]")
        legend_below(figure, grid[0][1], columns=5)
    return figure


def _draw(axes: Axes, bars: Mapping[str, float], noise: float, unit: EngineeringUnit) -> None:
    for k, (label, value) in enumerate(bars.items()):
        colour, hatch = _COLOURS[label]
        axes.barh(k, value / noise, 0.75, color=colour, hatch=hatch, edgecolor="white", label=label)
        axes.annotate(
            f"{value / noise:.2f} × ({with_unit(plain(unit.factor * value), unit)})",
            (value / noise, k),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=8.0,
        )
    axes.axvline(1.0, color=BLACK, linestyle=":", linewidth=1.3, label="noise floor")
    axes.set_yticks([])
    axes.set_ylim(len(bars) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
