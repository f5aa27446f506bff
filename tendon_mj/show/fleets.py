"""A fleet as a page, a table and two pictures: changes day by day, and differences of the rigs."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import matplotlib.dates as mdates
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import Provenance
from tendon_mj.lab.fleet import FleetResult, RigResult
from tendon_mj.lab.units import EngineeringUnit, engineering_unit, plain, quantity
from tendon_mj.show import style
from tendon_mj.show.report.page import page_templates
from tendon_mj.whole_file import whole_file

CHANGES, SPREAD = "changes", "spread"  # names of the pictures
_CAPTIONS = {
    CHANGES: "Changes day by day: the changed parameter is fitted to each recording, all others to"
    " all recordings of the rig. Bars are standard errors from noise.",
    SPREAD: "Fitted parameters of each rig, with the median and the spread between rigs.",
}
_PANEL_COLUMNS = 3
_LABELS = 12  # names of rigs along an axis
_MOST_PANELS = 12  # panels; the table has all
_MARKS = {
    "consistent with the fleet": (style.GREY, "o", 14),
    "unchanged": (style.GREY, "o", 14),
    "not judged": (style.PALE, "o", 14),
    "differs": (style.ORANGE, "D", 34),
    "changed": (style.VERMILLION, "s", 30),
}


def fleet_page(
    fleet: FleetResult, pictures: Mapping[str, bytes], provenance: Provenance, folder: str
) -> str:
    """The page of a folder's fleet as HTML, with its PNGs `changes` and `spread` where they are.

    Every text that comes from a file is escaped.
    """
    spreads = [
        (name, quantity(s.median, fleet.units[name]), quantity(s.between, fleet.units[name]))
        for name, s in fleet.spreads.items()
    ]
    shown = [
        (name, base64.b64encode(pictures[name]).decode("ascii"), caption)
        for name, caption in _CAPTIONS.items()
        if name in pictures
    ]
    template = page_templates().get_template("fleet.html")
    return template.render(
        fleet=fleet,
        folder=folder,
        telling=[rig.sentence(fleet.units) for rig in fleet.with_findings],
        spreads=spreads,
        heads=[f"{name} [{_unit(fleet, name).symbol or '-'}]" for name in fleet.units],
        rows=[_rig_cells(fleet, rig) for rig in fleet.rigs],
        pictures=shown,
        provenance=provenance,
    )


def _unit(fleet: FleetResult, name: str) -> EngineeringUnit:
    return engineering_unit(fleet.units[name], [fleet.spreads[name].median])


def _rig_cells(fleet: FleetResult, rig: RigResult) -> Sequence[str]:
    numbers = [
        plain(rig.values[name] * _unit(fleet, name).factor) if name in rig.values else "–"
        for name in fleet.units
    ]
    days = f"{rig.dates[0]:%Y-%m-%d} … {rig.dates[-1]:%Y-%m-%d}" if rig.dates else "–"
    misfits = (plain(v, 2) if v == v else "–" for v in (rig.misfit, rig.left))
    return [rig.name, rig.verdict, str(len(rig.dates)), days, *numbers, *misfits]


def write_table(fleet: FleetResult, path: Path) -> Path:
    """Write a CSV with a row for each rig, in SI units, and return its path."""
    with whole_file(path) as made:
        fleet.to_dataframe().to_csv(made, index=False)
    return path


def changes_figure(fleet: FleetResult) -> Figure | None:
    """Draw the numbers that changed day by day; None if nothing changed."""
    changed = fleet.of("changed")[:_MOST_PANELS]
    if not changed:
        return None
    columns = min(_PANEL_COLUMNS, len(changed))
    rows = -(-len(changed) // columns)
    with style.print_style():
        figure = style.new_figure(0.4 + 3.3 * columns, 0.6 + 2.5 * rows)
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes in grid.flat[len(changed) :]:
            axes.set_visible(False)
        for axes, rig in zip(grid.flat, changed, strict=False):
            _day_by_day(axes, rig)
        style.legend_below(figure, grid[0, 0], columns=columns)  # as wide as the panels
    return figure


def spread_figure(fleet: FleetResult) -> Figure | None:
    """Draw each fitted parameter of every rig; None if nothing was fitted."""
    rigs = [rig for rig in fleet.rigs if not rig.error]
    names = [name for name in fleet.units if any(name in rig.values for rig in rigs)]
    if not names:
        return None
    with style.print_style():
        figure = style.new_figure(7.4, 0.9 + 1.7 * len(names))
        grid = figure.subplots(len(names), 1, sharex=True, squeeze=False)
        for axes, name in zip(grid[:, 0], names, strict=True):
            _all_rigs(axes, fleet, rigs, name)
        places = range(0, len(rigs), -(-len(rigs) // _LABELS))
        grid[-1, 0].set_xticks(
            list(places), [rigs[k].name for k in places], rotation=30, ha="right"
        )
        style.legend_below(figure, grid[0, 0], columns=4)
    return figure


def _day_by_day(axes: Axes, rig: RigResult) -> None:
    change, series = rig.change, rig.series
    if change is None or series is None:
        return
    unit = engineering_unit(series.unit, [change.before, change.after])
    values, errors = series.values * unit.factor, series.errors * unit.factor
    begins: Any = change.last_same, change.since
    axes.axvspan(*begins, color=style.PALE, alpha=0.5, lw=0, label="the change begins")
    errors = np.minimum(errors, np.ptp(values) or 1.0)
    look: dict[str, Any] = {"color": style.BLUE, "markersize": 4, "elinewidth": 1.0}
    label = "fitted to each recording"
    axes.errorbar(rig.dates, values, errors, fmt="o", label=label, **look)  # type: ignore[arg-type]
    days, course = _course_line(rig)
    line = np.array(course) * unit.factor
    axes.plot(days, line, "--", color=style.VERMILLION, label="change")  # type: ignore[arg-type]
    locator: Any = mdates.AutoDateLocator(minticks=3, maxticks=6)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(mdates.ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]
    axes.set_title(f"{rig.name}\n{series.parameter}", fontsize=8.5)
    axes.set_ylabel(f"{series.parameter.rpartition('.')[2]} [{unit.symbol or '-'}]")


def _course_line(rig: RigResult) -> tuple[list[datetime], list[float]]:
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


def _all_rigs(axes: Axes, fleet: FleetResult, rigs: Sequence[RigResult], name: str) -> None:
    spread, unit = fleet.spreads[name], _unit(fleet, name)
    low, high = ((spread.median + sign * spread.between) * unit.factor for sign in (-1.0, 1.0))
    label = "median ± spread between rigs"
    axes.axhspan(low, high, color=style.PALE, alpha=0.5, lw=0, label=label)
    for verdict, (colour, marker, size) in _MARKS.items():
        chosen = [
            (k, rig.values[name] * unit.factor)
            for k, rig in enumerate(rigs)
            if rig.verdict == verdict and name in rig.values
        ]
        if chosen:
            label = f"{verdict} (before that)" if verdict == "changed" else verdict
            x, y = zip(*chosen, strict=True)
            axes.scatter(x, y, color=colour, marker=marker, s=size, label=label, zorder=3)
    axes.set_title(name, fontsize=9)
    axes.set_ylabel(f"[{unit.symbol or '-'}]")
