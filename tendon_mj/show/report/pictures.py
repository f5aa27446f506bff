"""Pictures of a diagnosis, for print and as files: misfit, errors, proof, signals."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import BeforeAfter, Diagnosis, Located
from tendon_mj.lab.replay import EngineeringUnit, column_unit, engineering_unit, plain, with_unit
from tendon_mj.show.figures import style
from tendon_mj.show.figures.simulations import before_after_figure
from tendon_mj.show.report.bars import (
    AFTER,
    BEFORE,
    FLOOR,
    LABEL_COLOURS,
    SYSID,
    Regime,
    error_bars,
    misfit_bars,
    noise_floor,
    proof_bars,
)

_HATCHES = {BEFORE: "////", SYSID: "...."}  # apart in grey too
_AXIS_SPAN = 1.5  # over the longest bar, for the label behind it
_COLUMNS = 2


def diagnosis_figures(
    diagnosis: Diagnosis, shown: BeforeAfter, sysid: Mapping[str, float] | None = None
) -> dict[str, Figure]:
    """Figures of a diagnosis by name.

    Args:
        diagnosis: to draw.
        shown: a recording, and its simulations before and after.
        sysid: column → held-out rms error of `mujoco.sysid` alone [the column's unit].

    Returns:
        "misfit" where there is one, "proof" where something was named, "gap", and
        "before_after".
    """
    changed = diagnosis.changed
    measured, before, after = shown
    figures = {}
    if diagnosis.verdict != "nothing missing":
        remaining = diagnosis.remaining if changed else None
        figures["misfit"] = _misfit(diagnosis.located, remaining)
    figures["gap"] = _errors(diagnosis, sysid)
    if changed:
        figures["proof"] = _proof(*diagnosis.proof, diagnosis.bars)
    figures["before_after"] = before_after_figure(measured, before, after if changed else None)
    return figures


def _errors(diagnosis: Diagnosis, sysid: Mapping[str, float] | None) -> Figure:
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
                signal = errors.signals.get(column, (0.0, 0.0, 1.0))
                bars = error_bars(signal, other, changed=changed)
                _draw_errors(axes, bars, signal[2], unit, changed)
                if diagnosis.bars and errors is held_out:
                    axes.axvline(
                        diagnosis.bars[column], color=style.GREY, linewidth=1.3, label=FLOOR
                    )
                longest = max(longest, *(value / signal[2] for value in bars.values()))
            row[0].set_ylabel(style.column_name(column))
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
        axes.barh(
            k,
            value / noise,
            0.75,
            color=LABEL_COLOURS[label],
            hatch=_HATCHES.get(label, ""),
            edgecolor="white",
            label=label if changed or label != BEFORE else "calibrated, nothing added",
        )
        axes.annotate(
            f"{value / noise:.2f} × ({with_unit(plain(unit.factor * value), unit)})",
            (value / noise, k),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=8.0,
        )
    axes.axvline(1.0, color=style.BLACK, linestyle=":", linewidth=1.3, label="noise floor")
    axes.set_yticks([])
    axes.set_ylim(len(bars) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def _misfit(located: Located, remaining: Located | None) -> Figure:
    """Share of the misfit of every bin of every regime, before and after, and of the time."""
    labels = {
        BEFORE: "misfit beyond noise, before",
        AFTER: "misfit beyond noise, after (of that before)",
    }
    return _by_regime(misfit_bars(located, remaining), labels, located.sentence, "share [%]")


def _proof(before: Located, after: Located, floors: Mapping[str, float]) -> Figure:
    """Rms error in every bin of every regime, before and after, in units of noise."""
    title = "Error on held-out data, before and after; 1 is the noise floor"
    if floors:
        title += f", {noise_floor(floors):.2f} that of {FLOOR} together (grey line)"
    figure = _by_regime(proof_bars(before, after), {}, title, "rms error [noise]")
    for axes in figure.axes:
        if axes.axison:
            axes.axvline(1.0, color=style.GREY, linestyle="--", linewidth=0.8)
            if floors:
                axes.axvline(noise_floor(floors), color=style.GREY, linewidth=1.1)
    return figure


def _by_regime(
    regimes: Mapping[str, Regime], labels: Mapping[str, str], title: str, label: str
) -> Figure:
    """Two columns of panels, one for each regime, with a group of bars for each of its bins."""
    rows = -(-len(regimes) // _COLUMNS)
    with style.print_style():
        counts = [len(regime.bins) for regime in regimes.values()]
        bins = [max(counts[k::rows]) for k in range(rows)]
        figure = style.new_figure(8.0, 1.4 + sum(0.55 + 0.21 * count for count in bins))
        figure.suptitle(textwrap.fill(title, 105), fontsize=9.0)
        grid = figure.subplots(
            rows, _COLUMNS, squeeze=False, sharex=True, height_ratios=[b + 1.5 for b in bins]
        )
        panels = grid.T.ravel()
        for axes, (name, regime) in zip(panels, regimes.items(), strict=False):
            _draw_regime(axes, regime, labels)
            axes.set_title(name, fontsize=9.0)
        for axes in panels[len(regimes) :]:
            axes.set_axis_off()
        for axes in (grid[-1][0], panels[len(regimes) - 1]):
            axes.set_xlabel(label)
        style.legend_below(figure, panels[0], columns=3)
    return figure


def _draw_regime(axes: Axes, regime: Regime, labels: Mapping[str, str]) -> None:
    rows, count = np.arange(len(regime.bins)), len(regime.series)
    bar = 0.8 / count
    for k, (label, values) in enumerate(regime.series.items()):
        axes.barh(
            rows + (k - 0.5 * (count - 1)) * bar,
            values,
            bar,
            color=LABEL_COLOURS[label],
            edgecolor="white",
            linewidth=0.4,
            hatch=_HATCHES.get(label, ""),
            label=labels.get(label, label),
        )
    axes.set_yticks(rows, regime.bins)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=style.GREY, linewidth=0.8)
