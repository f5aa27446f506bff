"""Chart of the correlations of parameters."""

from __future__ import annotations

from tendon_mj.lab.diagnosis import Correlations
from tendon_mj.show.figures.style import BLUE, VERMILLION
from tendon_mj.show.report.charts.chart import Chart, numbers, text

_NONE = "#F7F7F7"  # the colour of no correlation


def correlation_chart(found: Correlations) -> Chart:
    """Correlation coefficients as cells from −1 to 1, each with its number."""
    names = [text(name) for name in found.names]
    cells = {
        "type": "heatmap",
        "x": names,
        "y": names,
        "z": [numbers(row) for row in found.matrix],
        "zmin": -1,
        "zmax": 1,
        "colorscale": [[0.0, BLUE], [0.5, _NONE], [1.0, VERMILLION]],
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
