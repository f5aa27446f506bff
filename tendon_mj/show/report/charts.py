"""Interactive charts of a report, as plotly figures: plain dictionaries of `data` and `layout`."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.lab.diagnosis import (
    Autocorrelation,
    BeforeAfter,
    Correlations,
    ErrorReduction,
    Located,
)
from tendon_mj.lab.recordings import noise_levels
from tendon_mj.lab.replay import column_unit, engineering_unit, quantity
from tendon_mj.show.figures import style
from tendon_mj.show.report.bars import (
    BEFORE,
    FLOOR,
    LABEL_COLOURS,
    Regime,
    error_bars,
    misfit_bars,
    noise_floor,
    proof_bars,
)
from tendon_mj.typing import FloatArray

Chart = dict[str, Any]  # plotly's figure: "data", a list of traces, and "layout"

_DIGITS = 5  # of a number in a chart
_BAR, _AROUND = 15, 92  # height of a bar, and of the margins of all bars [px]
_MOST = 1200  # samples of a curve over time
_MOST_IN_LOOP = 700
_BAND = 2.0  # half width of the noise band over the noise [-]
_NONE = "#F7F7F7"  # the colour of no correlation


def errors_chart(
    errors: ErrorReduction,
    sysid: Mapping[str, float] | None = None,
    *,
    changed: bool,
    floors: Mapping[str, float],
) -> Chart:
    """Rms error of every signal in units of its noise, labelled in the signal's own unit.

    ``sysid`` has the errors of `mujoco.sysid` alone [the column's unit], ``floors`` those of noise
    and reproducibility [noise], empty where it is the noise.
    """
    columns = {
        column: error_bars(signal, (sysid or {}).get(column), changed=changed)
        for column, signal in errors.signals.items()
    }
    series: dict[str, dict[str, float]] = {}  # label → column → error
    for label in LABEL_COLOURS:
        values = {column: bars[label] for column, bars in columns.items() if label in bars}
        if values:
            series[label] = values
    traces = []
    for label, values in series.items():
        ratios = [values[c] / errors.signals[c][2] for c in values]
        texts = [
            f"{ratio:.3g} ({quantity(values[c], column_unit(c))})"
            for c, ratio in zip(values, ratios, strict=True)
        ]
        trace = _bars([style.column_name(c) for c in values], ratios, label)
        traces.append(trace | {"text": texts, "textposition": "auto", "constraintext": "none"})
    if floors:
        mark = {"symbol": "line-ns-open", "size": 26, "color": style.GREY, "line": {"width": 2}}
        trace = _bars([style.column_name(c) for c in columns], [floors[c] for c in columns], FLOOR)
        traces.append(trace | {"type": "scatter", "mode": "markers", "marker": mark})
    layout = _bar_layout("rms error [noise]", len(columns) * len(series), [1.0])
    return {"data": traces, "layout": layout}


def misfit_charts(located: Located, remaining: Located | None) -> list[Chart]:
    """A chart for each regime; see `misfit_bars`."""
    return _by_regime(misfit_bars(located, remaining), "share [%]", [])


def proof_charts(before: Located, after: Located, floors: Mapping[str, float]) -> list[Chart]:
    """A chart for each regime, see `proof_bars`, with lines of the floors."""
    lines = [1.0, *([noise_floor(floors)] if floors else [])]
    return _by_regime(proof_bars(before, after), "rms error [noise]", lines)


def _by_regime(regimes: Mapping[str, Regime], label: str, lines: Sequence[float]) -> list[Chart]:
    charts = []
    for name, (bins, series) in regimes.items():
        layout = _bar_layout(label, len(bins) * len(series), lines)
        layout |= {"title": {"text": escaped(name)}}
        charts.append({"data": [_bars(bins, v, k) for k, v in series.items()], "layout": layout})
    return charts


def _bars(names: Sequence[str], values: Sequence[float], name: str) -> dict[str, Any]:
    return {
        "type": "bar",
        "orientation": "h",
        "name": name,
        "x": _numbers(values),
        "y": [escaped(label) for label in names],
        "marker": {"color": LABEL_COLOURS[name]},
        "hovertemplate": "%{y}: %{x:.3g}",
    }


def _bar_layout(label: str, bars: int, lines: Sequence[float]) -> dict[str, Any]:
    """Layout with upright lines: the noise floor, and that of noise and reproducibility."""
    upright = {"type": "line", "yref": "paper", "y0": 0, "y1": 1}
    looks = {"color": style.BLACK, "dash": "dot", "width": 1.3}, {"color": style.GREY, "width": 1.3}
    return {
        "height": _AROUND + _BAR * bars + 8 * (bars // 2),
        "barmode": "group",
        "showlegend": False,
        "xaxis": {"title": {"text": label}, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed", "automargin": True, "type": "category"},
        "shapes": [
            {**upright, "x0": x, "x1": x, "line": look}
            for x, look in zip(_numbers(lines), looks, strict=False)
        ],
    }


def over_time(row: BeforeAfter, column: str, *, changed: bool, height: int = 420) -> Chart:
    """A measured signal with its simulations over time, and below it the residuals."""
    measured = row.measured
    unit = style.drawn_unit(column, measured.columns[column])
    noise = noise_levels(measured)[column] * unit.factor
    true = measured.columns[column] * unit.factor
    traces = [_thin_curve(measured.time, true, "measured", style.PALE, 5.0)]
    for name, series, colour in _simulated(row, column, changed):
        simulated = series * unit.factor
        traces.append(_thin_curve(measured.time, simulated, name, colour, 1.6))
        traces.append(
            _thin_curve(measured.time, simulated - true, name, colour, 1.4)
            | {"yaxis": "y2", "showlegend": False}
        )
    layout = {
        "height": height,
        "hovermode": "x unified",
        "xaxis": {"title": {"text": "time [s]"}, "anchor": "y2"},
        "yaxis": {
            "title": {"text": escaped(style.column_label(column, unit))},
            "domain": [0.42, 1.0],
        },
        "yaxis2": {"title": {"text": f"residual [{unit.symbol}]"}, "domain": [0.0, 0.34]},
        "shapes": [_band(_BAND * noise) | {"yref": "y2"}],
    }
    return {"data": traces, "layout": layout}


def over_drive(row: BeforeAfter, column: str, *, changed: bool) -> Chart:
    """A measured signal with its simulations over the first driven column: its hysteresis loop."""
    measured = row.measured
    drive = next(iter(measured.drive))
    across, up = (style.drawn_unit(c, measured.columns[c]) for c in (drive, column))
    place = measured.columns[drive] * across.factor
    kept = np.unique(np.linspace(0, place.size - 1, _MOST_IN_LOOP).astype(int))
    drawn = [("measured", measured.columns[column], style.PALE, 5.0)]
    drawn += [(*simulated, 1.6) for simulated in _simulated(row, column, changed)]
    traces = [
        _curve(place[kept], (series * up.factor)[kept], name, colour, width)
        for name, series, colour, width in drawn
    ]
    layout = {
        "height": 320,
        "xaxis": {"title": {"text": escaped(style.column_label(drive, across))}},
        "yaxis": {"title": {"text": escaped(style.column_label(column, up))}},
    }
    return {"data": traces, "layout": layout}


def whiteness_chart(
    column: str, correlations: tuple[Autocorrelation, Autocorrelation], changed: bool
) -> Chart:
    """Autocorrelation of a signal's residual before and after, and the band of white noise."""
    before, after = correlations
    unit = engineering_unit("s", after.lags)
    drawn = [("before" if changed else "residual", before, LABEL_COLOURS[BEFORE])]
    drawn += [("after", after, style.BLUE)] if changed else []
    traces = [
        _curve(shown.lags * unit.factor, shown.values, name, colour, 1.4)
        | {"mode": "lines+markers", "marker": {"size": 5, "color": colour}}
        for name, shown, colour in drawn
    ]
    layout = {
        "height": 260,
        "showlegend": False,
        "title": {"text": escaped(style.column_name(column))},
        "xaxis": {"title": {"text": f"lag [{unit.symbol}]"}, "rangemode": "tozero"},
        "yaxis": {"title": {"text": "autocorrelation"}, "range": [-1.05, 1.05]},
        "shapes": [_band(before.band)],
    }
    return {"data": traces, "layout": layout}


def correlation_chart(correlations: Correlations) -> Chart:
    """Correlation coefficients as cells from −1 to 1, each with its number."""
    names = [escaped(name) for name in correlations.names]
    cells = {
        "type": "heatmap",
        "x": names,
        "y": names,
        "z": [_numbers(row) for row in correlations.matrix],
        "zmin": -1,
        "zmax": 1,
        "colorscale": [[0.0, style.BLUE], [0.5, _NONE], [1.0, style.VERMILLION]],
        "texttemplate": "%{z:.2f}",
        "hovertemplate": "%{y}, %{x}: %{z:.3f}",
        "name": "",
        "showscale": False,
        "xgap": 2,
        "ygap": 2,
    }
    layout = {
        "height": 150 + 42 * len(names),
        "xaxis": {"automargin": True, "tickangle": -35, "type": "category"},
        "yaxis": {"automargin": True, "autorange": "reversed", "type": "category"},
    }
    return {"data": [cells], "layout": layout}


def _simulated(
    row: BeforeAfter, column: str, changed: bool
) -> Iterator[tuple[str, FloatArray, str]]:
    """Name, series and colour of each simulation."""
    yield ("before" if changed else "simulated"), row.before.columns[column], style.VERMILLION
    if changed:
        yield "after", row.after.columns[column], style.BLUE


def _thin_curve(x: FloatArray, y: FloatArray, *look: Any) -> dict[str, Any]:
    kept = thin(y, _MOST)
    return _curve(x[kept], y[kept], *look)


def _curve(x: FloatArray, y: FloatArray, name: str, colour: str, width: float) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "legendgroup": name,
        "x": _numbers(x),
        "y": _numbers(y),
        "line": {"color": colour, "width": width},
    }


def _band(half: float) -> dict[str, Any]:
    """A grey band about zero."""
    return {
        "type": "rect",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": -half,
        "y1": half,
        "fillcolor": style.PALE,
        "opacity": 0.45,
        "line": {"width": 0},
        "layer": "below",
    }


def escaped(words: str) -> str:
    """Words as plotly shows them unformatted: tags in them may come from a file."""
    return html.escape(words, quote=False)


def _numbers(values: ArrayLike) -> list[float]:
    """(n,) values with five digits each."""
    return [float(f"{value:.{_DIGITS}g}") for value in np.asarray(values, float).tolist()]


def thin(values: FloatArray, most: int) -> NDArray[np.int64]:
    """Ascending indices of the samples of a curve to draw, about ``most``.

    The least and the largest value of each of ``most``/2 stretches: no peak is lost.
    """
    size = values.size
    if size <= most:
        return np.arange(size)
    edges = np.linspace(0, size, max(1, most // 2) + 1).astype(np.int64)
    kept = {0, size - 1}
    for first, last in pairwise(edges.tolist()):
        inside = values[first:last]
        kept |= {first + int(inside.argmin()), first + int(inside.argmax())}
    return np.array(sorted(kept))
