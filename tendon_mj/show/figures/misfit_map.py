"""Location of a misfit: its share beside that of the time, or its size, in every regime."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import Bin, Located
from tendon_mj.show.figures.labels import column_name
from tendon_mj.show.figures.style import (
    BLUE,
    GREY,
    PALE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_COLUMNS = 2

_Series = tuple[str, list[float], str, str]  # label, lengths of the bars, colour, hatch


def misfit_figure(located: Located, remaining: Located | None) -> Figure:
    """Draw the excess of every bin of every regime, before and after, beside the time spent there.

    The excess is the power beyond noise, time × (rms² − 1); what is left after is drawn in shares
    of what there was before, so that its bars shrink as it does.

    Args:
        located, remaining: before and after; None where nothing was changed.

    Returns:
        A figure of two columns of panels, one for each regime.
    """
    left = _rms(remaining)
    whole = sum(_excess(p.time, p.rms) for p in located.bins if p.regime == "signal")
    unit = 100.0 / whole if whole > 0.0 else 0.0

    def series(places: Sequence[Bin]) -> list[_Series]:
        before = [unit * _excess(p.time, p.rms) for p in places]
        drawn = [
            ("time spent there", [100.0 * p.time for p in places], PALE, ""),
            ("misfit beyond noise, before", before, VERMILLION, "////"),
        ]
        if remaining:
            after = [unit * _excess(p.time, left.get((p.regime, p.label), 1.0)) for p in places]
            drawn.append(("misfit beyond noise, after (of that before)", after, BLUE, ""))
        return drawn

    return _by_regime(located, series, located.sentence, "share [%]")


def quadratic_mean(floors: Mapping[str, float]) -> float:
    """Noise and reproducibility together over all signals, from those of each [noise]."""
    return float(np.sqrt(np.mean(np.square(list(floors.values())))))


def proof_figure(before: Located, after: Located, floors: Mapping[str, float]) -> Figure:
    """Draw the rms error in every bin of every regime, before and after, in units of noise.

    Args:
        before, after: misfits of the same data.
        floors: column → noise and reproducibility together [noise]; empty where it is the noise.

    Returns:
        As `misfit_figure`.
    """
    left = _rms(after)

    def series(places: Sequence[Bin]) -> list[_Series]:
        return [
            ("before", [p.rms for p in places], VERMILLION, "////"),
            ("after", [left[p.regime, p.label] for p in places], BLUE, ""),
        ]

    title = "Error on held-out data, before and after; 1 is the noise floor"
    floor = quadratic_mean(floors) if floors else 1.0
    if floors:
        title += f", {floor:.2f} that of noise and reproducibility together (grey line)"
    figure = _by_regime(before, series, title, "rms error [noise]")
    for axes in figure.axes:
        if axes.axison:
            axes.axvline(1.0, color=GREY, linestyle="--", linewidth=0.8)
            if floors:
                axes.axvline(floor, color=GREY, linewidth=1.1)
    return figure


def _by_regime(
    located: Located,
    series: Callable[[Sequence[Bin]], list[_Series]],
    title: str,
    label: str,
) -> Figure:
    """Two columns of panels, one for each regime, with a group of bars for each of its bins."""
    groups: dict[str, list[Bin]] = {}
    for place in located.bins:
        groups.setdefault(place.regime, []).append(place)
    rows = -(-len(groups) // _COLUMNS)
    with print_style():
        bins = [max(len(g) for g in list(groups.values())[k::rows]) for k in range(rows)]
        figure = new_figure(8.0, 1.4 + sum(0.55 + 0.21 * count for count in bins))
        figure.suptitle(textwrap.fill(title, 105), fontsize=9.0)
        grid = figure.subplots(
            rows, _COLUMNS, squeeze=False, sharex=True, height_ratios=[b + 1.5 for b in bins]
        )
        panels = grid.T.ravel()
        for axes, (regime, places) in zip(panels, groups.items(), strict=False):
            _draw(axes, places, series(places))
            axes.set_title(regime, fontsize=9.0)
        for axes in panels[len(groups) :]:
            axes.set_axis_off()
        for axes in (grid[-1][0], panels[len(groups) - 1]):
            axes.set_xlabel(label)
        legend_below(figure, panels[0], columns=3)
    return figure


def _rms(located: Located | None) -> Mapping[tuple[str, str], float]:
    return {(p.regime, p.label): p.rms for p in located.bins} if located else {}


def _excess(time: float, rms: float) -> float:
    return time * (rms**2 - 1.0)


def _draw(axes: Axes, places: Sequence[Bin], series: Sequence[_Series]) -> None:
    rows, bar = np.arange(len(places)), 0.8 / len(series)
    for k, (label, values, colour, hatch) in enumerate(series):
        axes.barh(
            rows + (k - 0.5 * (len(series) - 1)) * bar,
            values,
            bar,
            color=colour,
            edgecolor="white",
            linewidth=0.4,
            hatch=hatch,
            label=label,
        )
    names = [column_name(p.label) if p.regime == "signal" else p.label for p in places]
    axes.set_yticks(rows, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=GREY, linewidth=0.8)
