"""Charts of bars: errors by signal and by regime, and where the misfit lies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tendon_mj.lab.diagnosis import Bin, ErrorReduction, Located
from tendon_mj.lab.replay import column_name, column_unit, quantity
from tendon_mj.show.figures.misfit_map import quadratic_mean
from tendon_mj.show.figures.style import BLACK, BLUE, GREY, PALE, PURPLE, VERMILLION
from tendon_mj.show.report.charts.chart import Chart, numbers, text

_BAR, _AROUND = 15, 92  # height of a bar, and of what is above and below all of them [px]
TIME_SPENT, BEFORE, SYSID, AFTER = "time spent there", "before", "mujoco.sysid alone", "after"
FLOOR = "noise and reproducibility"
COLOURS = {TIME_SPENT: PALE, BEFORE: VERMILLION, SYSID: PURPLE, AFTER: BLUE, FLOOR: GREY}


def errors(
    found: ErrorReduction,
    sysid: Mapping[str, float] | None = None,
    *,
    changed: bool,
    floors: Mapping[str, float],
) -> Chart:
    """Rms error of every signal in units of its noise, labelled in the signal's own unit.

    Args:
        found: errors of a diagnosis.
        sysid: column → error of `mujoco.sysid` alone [the column's unit].
        changed: whether there is an after.
        floors: column → noise and reproducibility together [noise]; empty where it is the noise.
    """
    columns = list(found.signals)
    own = {BEFORE: {c: found.signals[c][0] for c in columns}}
    if sysid:
        own[SYSID] = {c: sysid[c] for c in columns if c in sysid}
    if changed:
        own[AFTER] = {c: found.signals[c][1] for c in columns}
    traces = []
    for name, values in own.items():
        times = [values[c] / found.signals[c][2] for c in values]
        labels = [
            f"{ratio:.3g} ({quantity(values[c], column_unit(c))})"
            for c, ratio in zip(values, times, strict=True)
        ]
        trace = _bars([column_name(c) for c in values], times, name)
        traces.append(trace | {"text": labels, "textposition": "auto", "constraintext": "none"})
    if floors:
        mark = {"symbol": "line-ns-open", "size": 26, "color": GREY, "line": {"width": 2}}
        trace = _bars([column_name(c) for c in columns], [floors[c] for c in columns], FLOOR)
        traces.append(trace | {"type": "scatter", "mode": "markers", "marker": mark})
    layout = _layout("rms error [noise]", len(columns) * len(own), [1.0])
    return {"data": traces, "layout": layout}


def misfit(located: Located, remaining: Located | None) -> dict[str, Chart]:
    """Regime → share of the misfit beyond noise in each of its bins, beside that of the time.

    What remains is in shares of what there was before.

    Args:
        located, remaining: before and after; None where nothing was changed.
    """
    left = _rms(remaining) if remaining else {}
    whole = sum(_excess(b.time, b.rms) for b in located.bins if b.regime == "signal")
    unit = 100.0 / whole if whole > 0.0 else 0.0

    def series(bins: Sequence[Bin]) -> dict[str, list[float]]:
        drawn = {
            TIME_SPENT: [100.0 * b.time for b in bins],
            BEFORE: [unit * _excess(b.time, b.rms) for b in bins],
        }
        if remaining:
            rms = [left.get((b.regime, b.label), 1.0) for b in bins]
            drawn[AFTER] = [unit * _excess(b.time, r) for b, r in zip(bins, rms, strict=True)]
        return drawn

    return _by_regime(located, series, "share [%]", [])


def proof(before: Located, after: Located, floors: Mapping[str, float]) -> dict[str, Chart]:
    """Regime → rms error on held-out data in each of its bins, in units of noise.

    Args:
        before, after: misfits of the same data.
        floors: column → noise and reproducibility together [noise]; empty where it is the noise.
    """
    left = _rms(after)

    def series(bins: Sequence[Bin]) -> dict[str, list[float]]:
        return {
            BEFORE: [b.rms for b in bins],
            AFTER: [left.get((b.regime, b.label), b.rms) for b in bins],
        }

    lines = [1.0, *([quadratic_mean(floors)] if floors else [])]
    return _by_regime(before, series, "rms error [noise]", lines)


def _by_regime(
    located: Located,
    series: Callable[[Sequence[Bin]], dict[str, list[float]]],
    label: str,
    lines: Sequence[float],
) -> dict[str, Chart]:
    groups: dict[str, list[Bin]] = {}
    for found in located.bins:
        groups.setdefault(found.regime, []).append(found)
    charts = {}
    for regime, bins in groups.items():
        names = [column_name(b.label) if regime == "signal" else b.label for b in bins]
        drawn = series(bins)
        layout = _layout(label, len(bins) * len(drawn), lines)
        layout |= {"title": {"text": text(regime)}}
        traces = [_bars(names, values, name) for name, values in drawn.items()]
        charts[regime] = {"data": traces, "layout": layout}
    return charts


def _bars(names: Sequence[str], values: Sequence[float], name: str) -> dict[str, Any]:
    return {
        "type": "bar",
        "orientation": "h",
        "name": name,
        "x": numbers(values),
        "y": [text(one) for one in names],
        "marker": {"color": COLOURS[name]},
        "hovertemplate": "%{y}: %{x:.3g}",
    }


def _layout(label: str, bars: int, lines: Sequence[float]) -> dict[str, Any]:
    """Layout with upright lines: that of the noise, and that of what differs between sessions."""
    upright = {"type": "line", "yref": "paper", "y0": 0, "y1": 1}
    looks = {"color": BLACK, "dash": "dot", "width": 1.3}, {"color": GREY, "width": 1.3}
    return {
        "height": _AROUND + _BAR * bars + 8 * (bars // 2),
        "barmode": "group",
        "showlegend": False,
        "xaxis": {"title": {"text": label}, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed", "automargin": True, "type": "category"},
        "shapes": [
            {**upright, "x0": x, "x1": x, "line": look}
            for x, look in zip(numbers(lines), looks, strict=False)
        ],
    }


def _rms(located: Located) -> Mapping[tuple[str, str], float]:
    return {(b.regime, b.label): b.rms for b in located.bins}


def _excess(time: float, rms: float) -> float:
    return time * (rms**2 - 1.0)
