"""A fleet in two pictures: what changed in some rigs day by day, and how all rigs differ."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

import matplotlib.dates as mdates
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.fleet import FleetFound, RigFound
from tendon_mj.lab.replay import engineering_unit
from tendon_mj.show.figures.style import (
    BLUE,
    GREY,
    ORANGE,
    PALE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_COLUMNS = 3
_LABELS = 12  # names of rigs along an axis
_MOST = 12  # panels; the table has all
_MARKS = {
    "consistent with the fleet": (GREY, "o", 14),
    "unchanged": (GREY, "o", 14),
    "not judged": (PALE, "o", 14),
    "differs": (ORANGE, "D", 34),
    "changed": (VERMILLION, "s", 30),
}


def changes_figure(found: FleetFound) -> Figure | None:
    """Draw the numbers that changed day by day; None where nothing changed."""
    changed = found.of("changed")[:_MOST]
    if not changed:
        return None
    columns = min(_COLUMNS, len(changed))
    rows = -(-len(changed) // columns)
    with print_style():
        figure = new_figure(0.4 + 3.3 * columns, 0.6 + 2.5 * rows)
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes in grid.flat[len(changed) :]:
            axes.set_visible(False)
        for axes, rig in zip(grid.flat, changed, strict=False):
            _day_by_day(axes, rig)
        legend_below(figure, grid[0, 0], columns=columns)  # as wide as the panels
    return figure


def spread_figure(found: FleetFound) -> Figure | None:
    """Draw each fitted parameter of every rig; None where nothing was fitted."""
    rigs = [rig for rig in found.rigs if not rig.error]
    names = [name for name in found.units if any(name in rig.values for rig in rigs)]
    if not names:
        return None
    with print_style():
        figure = new_figure(7.4, 0.9 + 1.7 * len(names))
        grid = figure.subplots(len(names), 1, sharex=True, squeeze=False)
        for axes, name in zip(grid[:, 0], names, strict=True):
            _all_rigs(axes, found, rigs, name)
        places = range(0, len(rigs), -(-len(rigs) // _LABELS))
        grid[-1, 0].set_xticks(
            list(places), [rigs[k].name for k in places], rotation=30, ha="right"
        )
        legend_below(figure, grid[0, 0], columns=4)
    return figure


def _day_by_day(axes: Axes, rig: RigFound) -> None:
    change, series = rig.change, rig.series
    if change is None or series is None:
        return
    chosen = engineering_unit(series.unit, [change.before, change.after])
    values, errors = series.values * chosen.factor, series.errors * chosen.factor
    dates = _numbers(rig.dates)
    axes.axvspan(
        float(_numbers([change.last_same])[0]),
        float(_numbers([change.since])[0]),
        color=PALE,
        alpha=0.5,
        lw=0,
        label="the change begins",
    )
    axes.errorbar(
        dates, values, np.minimum(errors, np.ptp(values) or 1.0), fmt="o", color=BLUE, markersize=4,
        elinewidth=1.0, label="fitted to each recording",
    )  # fmt: skip
    told, course = _course(rig)
    axes.plot(
        _numbers(told), np.array(course) * chosen.factor, "--", color=VERMILLION, label="change"
    )
    locator: Any = mdates.AutoDateLocator(minticks=3, maxticks=6)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(mdates.ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]
    axes.set_title(f"{rig.name}\n{series.parameter}", fontsize=8.5)
    axes.set_ylabel(f"{series.parameter.rpartition('.')[2]} [{chosen.symbol or '-'}]")


def _course(rig: RigFound) -> tuple[list[datetime], list[float]]:
    """The line of a course: a step is drawn upright, on the first day with it."""
    change, dates = rig.change, rig.dates
    if change is None or change.course == "varying":
        return [], []
    before, after, first, last = change.before, change.after, dates[0], dates[-1]
    if change.between is not None and change.until is not None:
        back = dates[dates.index(change.until) + 1]
        days = [first, change.since, change.since, back, back, last]
        return days, [before, before, change.between, change.between, after, after]
    if change.course == "step":
        return [first, change.since, change.since, last], [before, before, after, after]
    return [first, change.last_same, last], [before, before, after]


def _all_rigs(axes: Axes, found: FleetFound, rigs: Sequence[RigFound], name: str) -> None:
    spread = found.spreads[name]
    chosen = engineering_unit(found.units[name], [spread.median])
    low, high = (spread.median + sign * spread.between for sign in (-1.0, 1.0))
    axes.axhspan(
        low * chosen.factor, high * chosen.factor, color=PALE, alpha=0.5, lw=0,
        label="median ± spread between rigs",
    )  # fmt: skip
    for verdict, (colour, marker, size) in _MARKS.items():
        own = [(k, rig.values[name]) for k, rig in enumerate(rigs)
               if rig.verdict == verdict and name in rig.values]  # fmt: skip
        if own:
            places, values = zip(*own, strict=True)
            label = f"{verdict} (before that)" if verdict == "changed" else verdict
            axes.scatter(
                places, np.array(values) * chosen.factor, color=colour, marker=marker, s=size,
                label=label, zorder=3,
            )  # fmt: skip
    axes.set_title(name, fontsize=9)
    axes.set_ylabel(f"[{chosen.symbol or '-'}]")


def _numbers(dates: Sequence[datetime]) -> np.ndarray:
    return np.asarray(mdates.date2num(list(dates)), float)  # type: ignore[no-untyped-call]
