"""Measurement against the simulations before and after, and their residuals."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording, noise_levels
from tendon_mj.lab.replay import column_unit, engineering_unit, plain, replay_error, with_unit
from tendon_mj.show.figures.labels import column_label, column_name, drawn_unit
from tendon_mj.show.figures.style import (
    BLUE,
    PALE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)
from tendon_mj.typing import FloatArray

BEFORE, AFTER = (VERMILLION, "-"), (BLUE, "--")  # where they agree, both are seen
_BAND = 2.0  # half width of the noise band over the noise [-]


def before_after_figure(
    measured: Recording, before: Recording, after: Recording | None = None
) -> Figure:
    """Draw every measured column over the driven one and over time, and below it the residual.

    Args:
        measured: with at least one driven and one measured column.
        before, after: the same columns, simulated; without ``after``, where nothing was changed.

    Returns:
        A figure with two rows of two panels for every measured column.

    Raises:
        RecordingError: nothing was measured or driven, or a simulation has other times or columns.
    """
    if not measured.measured or not measured.drive:
        raise RecordingError(f"recording {measured.name!r}: nothing in [drive] or in [measured]")
    answers = {"simulated": (before, *BEFORE)}
    if after:
        answers = {"before": (before, *BEFORE), "after": (after, *AFTER)}
    errors = {label: replay_error(measured, answer) for label, (answer, *_) in answers.items()}
    noise = noise_levels(measured)
    drive = next(iter(measured.drive))
    across = drawn_unit(drive, measured.columns[drive])
    driven = across.factor * measured.columns[drive]
    rows = len(measured.measured)
    with print_style():
        figure = new_figure(8.0, 0.9 + 3.1 * rows)
        source = textwrap.fill(f"{measured.name} on model {measured.model}: {measured.source}", 105)
        figure.suptitle(source, fontsize=9.0, parse_math=False)
        grid = figure.subplots(
            2 * rows, 2, squeeze=False, sharex="col", sharey="row", height_ratios=(1.7, 1.0) * rows
        )
        for k, column in enumerate(measured.measured):
            unit = drawn_unit(column, measured.columns[column])
            true, band = unit.factor * measured.columns[column], unit.factor * noise[column]
            for axes, left, x in zip(
                grid[2 * k], grid[2 * k + 1], (driven, measured.time), strict=True
            ):
                axes.plot(x, true, color=PALE, linewidth=3.0, label="measured")
                left.axhspan(
                    -_BAND * band,
                    _BAND * band,
                    color=PALE,
                    alpha=0.5,
                    linewidth=0.0,
                    label=f"±{_BAND:g} × noise",
                )
                for named, (answer, colour, style) in answers.items():
                    series = unit.factor * answer.columns[column]
                    _draw(axes, x, series, colour, style, named)
                    _draw(left, x, series - true, colour, style, "_residual")
            grid[2 * k][0].set_ylabel(column_label(column, unit))
            grid[2 * k + 1][0].set_ylabel(f"simulated −\nmeasured [{unit.symbol}]")
            rms = {named: found[column].rmse for named, found in errors.items()}
            grid[2 * k][0].set_title(_title(column, rms, noise[column]), fontsize=9.0)
        grid[-1][0].set_xlabel(column_label(drive, across))
        grid[-1][0].locator_params(axis="x", nbins=5)
        grid[-1][1].set_xlabel("time [s]")
        _gather_labels(grid[0][0], grid[1][0])
        legend_below(figure, grid[0][0], columns=4)
    return figure


def _title(column: str, rms: Mapping[str, float], noise: float) -> str:
    """A signal's errors and its noise, in one unit."""
    unit = engineering_unit(column_unit(column), [*rms.values(), noise])
    said = [f"{with_unit(plain(unit.factor * e), unit)} {named}" for named, e in rms.items()]
    level = with_unit(plain(unit.factor * noise, 2), unit)
    return f"{column_name(column)}: rms error {', '.join(said)}; noise {level}"


def _draw(axes: Axes, x: FloatArray, y: FloatArray, colour: str, style: str, label: str) -> None:
    axes.plot(x, y, color=colour, linestyle=style, linewidth=1.1, label=label)


def _gather_labels(axes: Axes, other: Axes) -> None:
    """Let the legend of one panel name the band of the other too."""
    band = other.patches[0]
    axes.fill_between([], [], [], color=PALE, alpha=0.5, linewidth=0.0, label=band.get_label())
