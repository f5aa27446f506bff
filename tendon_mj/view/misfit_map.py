"""Where a misfit sits: for every regime, the share of the misfit beside the share of the time."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.diagnosis.locate import Located, Place
from tendon_mj.view.replay import column_label
from tendon_mj.view.style import BLUE, GREY, PALE, VERMILLION, legend_below, new_figure, print_style

_BAR = 0.27
_COLUMNS = 2


def misfit_figure(located: Located, remaining: Located | None) -> Figure:
    """Draw the excess of every bin of every regime, before and after, beside the time spent there.

    The excess is the power beyond noise, time × (rms² − 1); what is left after is drawn in shares
    of what there was before, so that its bars shrink as it does.

    Args:
        located, remaining: before and after; None where nothing was changed.

    Returns:
        A figure of two columns of panels, one for each regime.
    """
    groups: dict[str, list[Place]] = {}
    for place in located.places:
        groups.setdefault(place.regime, []).append(place)
    left = {(p.regime, p.label): p for p in remaining.places} if remaining else {}
    whole = sum(_excess(place) for place in groups.get("signal", ()))
    rows = -(-len(groups) // _COLUMNS)
    with print_style():
        bins = [max(len(g) for g in list(groups.values())[k::rows]) for k in range(rows)]
        figure = new_figure(8.0, 1.4 + sum(0.55 + 0.21 * count for count in bins))
        figure.suptitle(textwrap.fill(located.sentence, 105), fontsize=9.0)
        grid = figure.subplots(
            rows, _COLUMNS, squeeze=False, sharex=True, height_ratios=[b + 1.5 for b in bins]
        )
        panels = grid.T.ravel()
        for axes, (regime, places) in zip(panels, groups.items(), strict=False):
            _draw(axes, places, [left.get((regime, p.label)) for p in places], whole)
            axes.set_title(regime, fontsize=9.0)
        for axes in panels[len(groups) :]:
            axes.set_axis_off()
        for axes in (grid[-1][0], panels[len(groups) - 1]):
            axes.set_xlabel("share [%]")
        legend_below(figure, panels[0], columns=3)
    return figure


def _excess(place: Place) -> float:
    return place.time * (place.rms**2 - 1.0)


def _draw(axes: Axes, places: list[Place], left: list[Place | None], whole: float) -> None:
    rows = np.arange(len(places))
    unit = 100.0 / whole if whole > 0.0 else 0.0
    series = [
        ("time spent there", [100.0 * p.time for p in places], PALE, ""),
        ("misfit beyond noise, before", [unit * _excess(p) for p in places], VERMILLION, "////"),
    ]
    if any(left):
        after = [unit * _excess(p) if p else 0.0 for p in left]
        series.append(("misfit beyond noise, after (of that before)", after, BLUE, ""))
    for k, (label, values, colour, hatch) in enumerate(series):
        axes.barh(
            rows + (k - 1) * _BAR,
            values,
            _BAR,
            color=colour,
            edgecolor="white",
            linewidth=0.4,
            hatch=hatch,
            label=label,
        )
    names = [
        column_label(p.label).partition(" [")[0] if p.regime == "signal" else p.label
        for p in places
    ]
    axes.set_yticks(rows, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=GREY, linewidth=0.8)
