"""Picture of a colour bar: which colour is which tension."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

_DPI = 100


def colour_bar(low: float, high: float, width: int, height: int) -> NDArray[np.uint8]:
    """(height, width, 3) picture of a colour bar that lies on its side.

    Args:
        low, high: tensions at its ends [N].
        width, height: of the picture [pixels].
    """
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    colours = ScalarMappable(Normalize(low, high), colormaps["viridis"])
    bar = figure.colorbar(colours, cax=figure.add_subplot(), orientation="horizontal")
    bar.set_label("tension [N]; magenta: the tendon slips over this guide", fontsize=8)
    bar.ax.tick_params(labelsize=8)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3].copy()
