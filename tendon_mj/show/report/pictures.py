"""Pictures of a diagnosis: errors, misfit, proof, signals, whiteness and correlations."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import (
    Autocorrelation,
    BeforeAfter,
    Bin,
    Correlations,
    Diagnosis,
    Located,
)
from tendon_mj.lab.units import EngineeringUnit, column_name, column_unit, engineering_unit, plain
from tendon_mj.show import style
from tendon_mj.show.figures.simulations import before_after_figure

TIME_SPENT, BEFORE, SYSID, AFTER = "time spent there", "before", "mujoco.sysid alone", "after"
FLOOR = "noise and reproducibility"
_BAR_COLOURS = {
    TIME_SPENT: style.PALE,
    BEFORE: style.VERMILLION,
    SYSID: style.PURPLE,
    AFTER: style.BLUE,
}
_HATCHES = {BEFORE: "////", SYSID: "...."}  # apart in grey too
_AXIS_SPAN = 1.5  # over the longest bar, for the label behind it
_ACROSS = 2
_OF_SIGN = LinearSegmentedColormap.from_list("sign", [style.BLUE, "#F7F7F7", style.VERMILLION])


class _Bars(NamedTuple):
    """Bars of one kind: their name in the legend, and the length of that of a bin."""

    kind: str
    label: str
    length: Callable[[Bin], float]


def diagnosis_figures(
    diagnosis: Diagnosis, shown: BeforeAfter, sysid: Mapping[str, float] | None = None
) -> dict[str, Figure]:
    """Figures of a diagnosis by name, with a recording before and after.

    ``sysid``: column → held-out rms error of `mujoco.sysid` alone [the column's unit].
    """
    changed = diagnosis.changed
    figures = {}
    if diagnosis.verdict != "nothing missing":
        remaining = diagnosis.remaining if changed else None
        figures["misfit"] = misfit_figure(diagnosis.located, remaining)
    figures["gap"] = _errors_figure(diagnosis, sysid)
    if changed:
        figures["proof"] = _proof_figure(*diagnosis.proof, diagnosis.bars)
    figures["before_after"] = _signals(shown, changed)
    return figures


def signal_figure(shown: BeforeAfter, column: str, *, changed: bool) -> Figure:
    """A single signal of a recording with its simulations."""
    measured = replace(shown.measured, measured={column: shown.measured.measured[column]})
    return _signals(shown._replace(measured=measured), changed)


def _signals(shown: BeforeAfter, changed: bool) -> Figure:
    return before_after_figure(shown.measured, shown.before, shown.after if changed else None)


def whiteness_figure(
    white: Mapping[str, tuple[Autocorrelation, Autocorrelation]], *, changed: bool
) -> Figure:
    """Autocorrelation of each signal's residual before and after, and the band of white noise."""
    rows = -(-len(white) // _ACROSS)
    with style.print_style():
        figure = style.new_figure(8.0, 0.6 + 1.8 * rows)
        panels = figure.subplots(rows, _ACROSS, squeeze=False, sharey=True).ravel()
        for axes, (column, (before, after)) in zip(panels, white.items(), strict=False):
            unit = engineering_unit("s", after.lags)
            drawn = {BEFORE: before, AFTER: after} if changed else {"residual": before}
            for colour, (label, shown) in zip(
                (style.VERMILLION, style.BLUE), drawn.items(), strict=False
            ):
                lags = unit.factor * shown.lags
                axes.plot(lags, shown.values, ".-", color=colour, linewidth=1.1, label=label)
            axes.axhspan(-before.band, before.band, color=style.PALE, alpha=0.5, linewidth=0.0)
            axes.set(title=column_name(column), xlabel=f"lag [{unit.symbol}]", ylim=(-1.05, 1.05))
            axes.set_xlim(left=0.0)
        for axes in panels[len(white) :]:
            axes.set_axis_off()
        panels[0].set_ylabel("autocorrelation [–]")
        style.legend_below(figure, panels[0], columns=2)
    return figure


def correlation_figure(correlations: Correlations) -> Figure:
    """Correlation coefficients as cells from −1 to 1, each with its number."""
    names, matrix = correlations.names, np.array(correlations.matrix)
    with style.print_style():
        figure = style.new_figure(8.0, 1.2 + 0.4 * len(names))
        axes = figure.subplots()
        axes.imshow(matrix, cmap=_OF_SIGN, vmin=-1.0, vmax=1.0, aspect="auto")
        for (row, column), value in np.ndenumerate(matrix):
            ink = "white" if abs(value) > 0.7 else "black"
            number = f"{value:.2f}".replace("-", "−")
            axes.text(column, row, number, ha="center", va="center", color=ink)
        axes.set_xticks(range(len(names)), names, rotation=35, ha="right", parse_math=False)
        axes.set_yticks(range(len(names)), names, parse_math=False)
        axes.grid(visible=False)
    return figure


def _errors_figure(diagnosis: Diagnosis, sysid: Mapping[str, float] | None) -> Figure:
    """Rms errors in units of the noise, labelled in the signal's unit, a row for each signal."""
    changed, train, held_out = diagnosis.changed, diagnosis.train, diagnosis.held_out
    with style.print_style():
        figure = style.new_figure(8.0, 1.0 + 1.15 * len(held_out.signals))
        grid = figure.subplots(len(held_out.signals), 2, squeeze=False, sharex=True)
        longest = 1.0
        for row, column in zip(grid, held_out.signals, strict=True):
            shown = [*held_out.signals[column][:2], *train.signals.get(column, ())[:2]]
            unit = engineering_unit(column_unit(column), shown)
            rival = (sysid or {}).get(column)
            for axes, errors, other in zip(row, (train, held_out), (None, rival), strict=True):
                before, after, noise = errors.signals.get(column, (0.0, 0.0, 1.0))
                every = {BEFORE: before, SYSID: other, AFTER: after if changed else None}
                bars = {kind: error for kind, error in every.items() if error is not None}
                _draw_errors(axes, bars, noise, unit, changed)
                if diagnosis.bars and errors is held_out:
                    axes.axvline(
                        diagnosis.bars[column], color=style.GREY, linewidth=1.3, label=FLOOR
                    )
                longest = max(longest, *(value / noise for value in bars.values()))
            row[0].set_ylabel(column_name(column))
        grid[0][0].set_xlim(0.0, _AXIS_SPAN * longest)
        grid[0][0].set_title("training data: selection and fit")
        grid[0][1].set_title("held-out data")
        for axes in grid[-1]:
            axes.set_xlabel("rms error [× noise]")
        style.legend_below(figure, grid[0][1], columns=5)
    return figure


def _draw_errors(
    axes: Axes, bars: Mapping[str, float], noise: float, unit: EngineeringUnit, changed: bool
) -> None:
    for k, (label, value) in enumerate(bars.items()):
        bar = axes.barh(
            k,
            value / noise,
            0.75,
            color=_BAR_COLOURS[label],
            hatch=_HATCHES.get(label, ""),
            edgecolor="white",
            label=label if changed or label != BEFORE else "calibrated, nothing added",
        )
        text = f"{value / noise:.2f} × ({unit.write(value)})"
        axes.bar_label(bar, [text], padding=4, fontsize=8.0)
    axes.axvline(1.0, color=style.BLACK, linestyle=":", linewidth=1.3, label="noise floor")
    axes.set_yticks([])
    axes.set_ylim(len(bars) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def misfit_figure(located: Located, remaining: Located | None) -> Figure:
    """Share [%] of the misfit in every bin of every regime, before and after, and of the time.

    The misfit is the power beyond noise, time × (rms² − 1); that after is in shares of that before.
    """
    whole = sum(b.time * (b.rms**2 - 1.0) for b in located.bins if b.regime == "signal")
    unit = 100.0 / whole if whole > 0.0 else 0.0
    bars = [
        _Bars(TIME_SPENT, TIME_SPENT, lambda b: 100.0 * b.time),
        _Bars(BEFORE, "misfit beyond noise, before", lambda b: unit * b.time * (b.rms**2 - 1.0)),
    ]
    if remaining:
        left = _by_bin(remaining)

        def after(b: Bin) -> float:
            return unit * b.time * (left.get((b.regime, b.label), 1.0) ** 2 - 1.0)

        kept = max(0.0, sum(after(b) for b in located.bins if b.regime == "signal"))
        label = f"misfit beyond noise, after ({plain(kept, 2)} % of that before)"
        bars.append(_Bars(AFTER, label, after))
    return _by_regime(located, bars, located.sentence, "share [%]")


def _proof_figure(before: Located, after: Located, floors: Mapping[str, float]) -> Figure:
    """Rms error in every bin of every regime, before and after, in units of noise."""
    title = "Error on held-out data, before and after; 1 is the noise floor"
    floor = float(np.sqrt(np.mean(np.square([*floors.values()])))) if floors else 1.0
    if floors:
        title += f", {floor:.2f} that of {FLOOR} together (grey line)"
    rms = _by_bin(after)
    bars = [
        _Bars(BEFORE, BEFORE, lambda b: b.rms),
        _Bars(AFTER, AFTER, lambda b: rms.get((b.regime, b.label), b.rms)),
    ]
    figure = _by_regime(before, bars, title, "rms error [noise]")
    for axes in figure.axes:
        if axes.axison:
            axes.axvline(1.0, color=style.GREY, linestyle="--", linewidth=0.8)
            if floors:
                axes.axvline(floor, color=style.GREY, linewidth=1.1)
    return figure


def _by_bin(located: Located) -> Mapping[tuple[str, str], float]:
    return {(b.regime, b.label): b.rms for b in located.bins}


def _row_name(shown: Bin) -> str:
    """Label of a row, in which numbers have minus signs."""
    if shown.regime == "signal":
        return column_name(shown.label)
    return shown.label.replace("-", "−")


def _by_regime(located: Located, bars: Sequence[_Bars], title: str, label: str) -> Figure:
    """Two columns of panels, one for each regime, with a group of bars for each of its bins."""
    regimes: dict[str, list[Bin]] = {}
    for b in located.bins:
        regimes.setdefault(b.regime, []).append(b)
    rows = -(-len(regimes) // _ACROSS)
    with style.print_style():
        counts = [len(bins) for bins in regimes.values()]
        highest = [max(counts[k::rows]) for k in range(rows)]
        figure = style.new_figure(8.0, 1.4 + sum(0.55 + 0.21 * count for count in highest))
        figure.suptitle(textwrap.fill(title, 105), fontsize=9.0)
        grid = figure.subplots(
            rows, _ACROSS, squeeze=False, sharex=True, height_ratios=[n + 1.5 for n in highest]
        )
        panels = grid.T.ravel()
        for axes, (name, bins) in zip(panels, regimes.items(), strict=False):
            _draw_regime(axes, bins, bars)
            axes.set_title(name, fontsize=9.0)
        for axes in panels[len(regimes) :]:
            axes.set_axis_off()
        for axes in (grid[-1][0], panels[len(regimes) - 1]):
            axes.set_xlabel(label)
        style.legend_below(figure, panels[0], columns=3)
    return figure


def _draw_regime(axes: Axes, bins: Sequence[Bin], bars: Sequence[_Bars]) -> None:
    rows, high = np.arange(len(bins)), 0.8 / len(bars)
    for k, one in enumerate(bars):
        axes.barh(
            rows + (k - 0.5 * (len(bars) - 1)) * high,
            [one.length(b) for b in bins],
            high,
            color=_BAR_COLOURS[one.kind],
            edgecolor="white",
            linewidth=0.4,
            hatch=_HATCHES.get(one.kind, ""),
            label=one.label,
        )
    axes.set_yticks(rows, [_row_name(b) for b in bins])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=style.GREY, linewidth=0.8)
