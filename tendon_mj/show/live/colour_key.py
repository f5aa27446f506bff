"""Picture of what the colours mean: which is which tension, and which tendon's a curve is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from tendon_mj.typing import FloatArray

_DPI = 100
_FONT = 8  # [points]
_COLUMNS = 2  # of names: input and output of a tendon


def colour_key(
    limits: tuple[float, float],
    tendons: Sequence[str],
    colours: FloatArray,
    width: int,
    height: int,
) -> NDArray[np.uint8]:
    """(height, width, 3) picture of a colour bar that lies on its side, and lines with names.

    Args:
        limits: tensions at the ends of the colour bar [N].
        tendons: names of those that have curves.
        colours: (tendons, 2, 3) of the curves at input and output, 0 to 1.
        width, height: of the picture [pixels].
    """
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    scale = ScalarMappable(Normalize(*limits), colormaps["viridis"])
    bar = figure.colorbar(scale, cax=figure.add_subplot(), orientation="horizontal", extend="both")
    bar.set_label(
        "tension along the tendon [N], at the tips or beyond;\nmagenta: it slips over this guide",
        size=_FONT,
    )
    bar.ax.tick_params(labelsize=_FONT)
    lines = [
        Line2D([], [], color=colour, linewidth=2.5, label=f"{name} {end}")
        for name, both in zip(tendons, colours, strict=True)
        for colour, end in zip(both, ("input", "output"), strict=True)
    ]
    if lines:
        figure.legend(
            handles=lines,
            loc="outside lower center",
            ncols=_COLUMNS,
            fontsize=_FONT,
            frameon=False,
            handlelength=1.2,
            columnspacing=1.0,
        )
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3].copy()


def key_height(tendons: int) -> int:
    """Height that the picture of so many tendons' colours needs [pixels]."""
    return 92 + 17 * -(-2 * tendons // _COLUMNS)
