"""Charts of signals: over time with their residual, over the drive, and autocorrelations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tendon_mj.lab.diagnosis import Autocorrelation, BeforeAfter
from tendon_mj.lab.recordings import noise_levels
from tendon_mj.lab.replay import engineering_unit
from tendon_mj.show.figures.before_after import AFTER, BEFORE
from tendon_mj.show.figures.labels import column_label, column_name, drawn_unit
from tendon_mj.show.figures.style import PALE
from tendon_mj.show.report.charts.chart import Chart, numbers, text, thin
from tendon_mj.typing import FloatArray

_MOST = 1200  # samples of a curve over time
_MOST_IN_LOOP = 700
_BAND = 2.0  # half width of the noise band over the noise [-]


def over_time(row: BeforeAfter, column: str, *, changed: bool, height: int = 420) -> Chart:
    """A measured signal with its simulations over time, and below it the residuals.

    Args:
        row: a recording and its simulations.
        column: measured.
        changed: whether the simulation after differs, and is drawn.
        height: of the chart [px].
    """
    measured = row.measured
    unit = drawn_unit(column, measured.columns[column])
    noise = noise_levels(measured)[column] * unit.factor
    true = measured.columns[column] * unit.factor
    traces = [_line(measured.time, true, "measured", PALE, 5.0)]
    for name, series, (colour, _) in _simulated(row, column, changed):
        simulated = series * unit.factor
        traces.append(_line(measured.time, simulated, name, colour, 1.6))
        traces.append(
            _line(measured.time, simulated - true, name, colour, 1.4)
            | {"yaxis": "y2", "showlegend": False}
        )
    band = {
        "type": "rect",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "yref": "y2",
        "y0": -_BAND * noise,
        "y1": _BAND * noise,
        "fillcolor": PALE,
        "opacity": 0.45,
        "line": {"width": 0},
        "layer": "below",
    }
    layout = {
        "height": height,
        "hovermode": "x unified",
        "xaxis": {"title": {"text": "time [s]"}, "anchor": "y2"},
        "yaxis": {"title": {"text": text(column_label(column, unit))}, "domain": [0.42, 1.0]},
        "yaxis2": {"title": {"text": f"residual [{unit.symbol}]"}, "domain": [0.0, 0.34]},
        "shapes": [band],
    }
    return {"data": traces, "layout": layout}


def over_drive(row: BeforeAfter, column: str, *, changed: bool) -> Chart:
    """A measured signal with its simulations over the first driven column: its hysteresis loop."""
    measured = row.measured
    drive = next(iter(measured.drive))
    across, up = (drawn_unit(c, measured.columns[c]) for c in (drive, column))
    place = measured.columns[drive] * across.factor
    kept = np.unique(np.linspace(0, place.size - 1, _MOST_IN_LOOP).astype(int))

    def loop(series: FloatArray, name: str, colour: str, width: float) -> dict[str, Any]:
        values = series * up.factor
        return _trace(place[kept], values[kept], name, colour, width)

    traces = [loop(measured.columns[column], "measured", PALE, 5.0)]
    traces += [loop(s, name, c, 1.6) for name, s, (c, _) in _simulated(row, column, changed)]
    layout = {
        "height": 320,
        "xaxis": {"title": {"text": text(column_label(drive, across))}},
        "yaxis": {"title": {"text": text(column_label(column, up))}},
    }
    return {"data": traces, "layout": layout}


def whiteness(column: str, found: tuple[Autocorrelation, Autocorrelation], changed: bool) -> Chart:
    """Autocorrelation of a signal's residual, and the band of white noise."""
    unit = engineering_unit("s", found[1].lags)
    named = [("before", found[0], BEFORE[0]), ("after", found[1], AFTER[0])]
    traces = [
        _trace(one.lags * unit.factor, one.values, name, colour, 1.4)
        | {"mode": "lines+markers", "marker": {"size": 5, "color": colour}}
        for name, one, colour in (named if changed else [("residual", found[0], BEFORE[0])])
    ]
    band = found[0].band
    rectangle = {
        "type": "rect",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": -band,
        "y1": band,
        "fillcolor": PALE,
        "opacity": 0.45,
        "line": {"width": 0},
        "layer": "below",
    }
    layout = {
        "height": 260,
        "showlegend": False,
        "title": {"text": text(column_name(column))},
        "xaxis": {"title": {"text": f"lag [{unit.symbol}]"}, "rangemode": "tozero"},
        "yaxis": {"title": {"text": "autocorrelation"}, "range": [-1.05, 1.05]},
        "shapes": [rectangle],
    }
    return {"data": traces, "layout": layout}


def _simulated(
    row: BeforeAfter, column: str, changed: bool
) -> Iterator[tuple[str, FloatArray, tuple[str, str]]]:
    yield ("before" if changed else "simulated"), row.before.columns[column], BEFORE
    if changed:
        yield "after", row.after.columns[column], AFTER


def _line(x: FloatArray, y: FloatArray, name: str, colour: str, width: float) -> dict[str, Any]:
    kept = thin(y, _MOST)
    return _trace(x[kept], y[kept], name, colour, width)


def _trace(x: FloatArray, y: FloatArray, name: str, colour: str, width: float) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "legendgroup": name,
        "x": numbers(x),
        "y": numbers(y),
        "line": {"color": colour, "width": width},
    }
