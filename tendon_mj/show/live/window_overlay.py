"""What MuJoCo's viewer shows beside the model: tensions as numbers and as curves."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from tendon_mj.typing import FloatArray

MOST = 6  # tendons that there is space for
_POINTS = 1000  # of a curve, as many as `mjvFigure` takes
_SHARE = 0.42, 0.34  # of the window's width and height that the curves take
_KEY = 420  # width of the key of colours [pixels]
_MARGIN = 10  # [pixels]


def tension_text(tendons: Sequence[str], tensions: FloatArray, time: float) -> tuple[str, str]:
    """Two columns of text: what is shown, and its value.

    Args:
        tendons: their names.
        tensions: (tendons, 2) at input and output [N].
        time: of the simulation [s].
    """
    left, right = ["time [s]"], [f"{time:.1f}"]
    for name, (first, last) in list(zip(tendons, tensions, strict=True))[:MOST]:
        left.append(f"{name}: input to output tension [N]")
        right.append(f"{first:.1f} to {last:.1f}")
    if len(tendons) > MOST:
        left.append(f"and {len(tendons) - MOST} more tendons")
        right.append("")
    return "\n".join(left), "\n".join(right)


def new_figure(colours: FloatArray, high: float) -> mujoco.MjvFigure:
    """A figure for the curves of tension, still without them.

    Args:
        colours: (tendons, 2, 3) of the curves at input and output.
        high: tension at the end of the colour bar [N], which the axis begins with.
    """
    figure = mujoco.MjvFigure()
    mujoco.mjv_defaultFigure(figure)
    figure.title, figure.xlabel = "tension at the ends [N]", "time [s]"
    figure.xformat, figure.yformat = "%.1f", "%.3g"
    figure.figurergba[:], figure.panergba[:] = (1.0, 1.0, 1.0, 0.85), (1.0, 1.0, 1.0, 1.0)
    figure.textrgb[:], figure.gridrgb[:] = 0.0, 0.85
    figure.linewidth, figure.gridwidth = 2.5, 1.0
    figure.flg_legend, figure.flg_extend = 0, 1
    figure.flg_ticklabel[:] = 1
    figure.gridsize[:] = (5, 5)
    figure.range[1] = (0.0, high)
    shown = colours[:MOST].reshape(-1, 3)
    figure.linergb[: len(shown)] = shown
    return figure


def draw_curves(
    figure: mujoco.MjvFigure, times: FloatArray, tensions: FloatArray, span: float
) -> None:
    """Put curves into a figure of `new_figure`.

    Args:
        figure: changed in place.
        times: (n,) [s].
        tensions: (n, tendons, 2) at input and output [N].
        span: of the axis of time [s].
    """
    chosen = slice(max(0, len(times) - _POINTS), None)
    shown, rows = times[chosen], np.nan_to_num(tensions[chosen], posinf=0.0)
    for k in range(min(tensions.shape[1], MOST)):
        for end in (0, 1):
            line = 2 * k + end
            figure.linedata[line, 0 : 2 * len(shown) : 2] = shown
            figure.linedata[line, 1 : 2 * len(shown) : 2] = rows[:, k, end]
            figure.linepnt[line] = len(shown)
    start = max(0.0, float(shown[-1]) - span) if len(shown) else 0.0
    figure.range[0] = (start, start + span)


def curves_place(viewport: mujoco.MjrRect) -> mujoco.MjrRect:
    """Where the curves lie in a window: at its lower right."""
    width, height = round(_SHARE[0] * viewport.width), round(_SHARE[1] * viewport.height)
    left = viewport.left + viewport.width - width - _MARGIN
    return mujoco.MjrRect(left, viewport.bottom + _MARGIN, width, height)


def key_place(viewport: mujoco.MjrRect, height: int) -> mujoco.MjrRect:
    """Where a key of colours of that height [pixels] lies in a window: at its lower left."""
    width = min(_KEY, max(1, viewport.width // 2))
    return mujoco.MjrRect(viewport.left + _MARGIN, viewport.bottom + _MARGIN, width, height)
