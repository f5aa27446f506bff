"""Line style of each route, caption and legend of the figures."""

from __future__ import annotations

import textwrap

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj.show import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION

PALE = "#BDBDBD"
# colour, line, width: wide and pale below, narrow and dark above, so that all stay visible
LOOKS: dict[str, tuple[str, object, float]] = {
    "closed form": (PALE, "-", 4.0),
    "closed form, μ_d": (PALE, "-", 4.0),
    "continuum": (SKY, "-", 2.6),
    "elements, μ_s = μ_d": (GREEN, (0, (1, 1)), 1.5),
    "elements": (VERMILLION, "-", 1.2),
    "elements in MuJoCo": (PURPLE, (0, (6, 1.5, 1, 1.5)), 1.0),
    "sheath alone": (ORANGE, (0, (5, 3)), 1.4),
    "plugin in MuJoCo": (BLUE, (0, (2, 2)), 1.2),
}
_LINE = 0.165  # height of a caption's line [inch]


def caption_below(figure: Figure, text: str) -> None:
    """Put a caption at the bottom, below everything that the layout places."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(text, round(15.5 * width))
    share = (_LINE * len(lines) + 0.08) / (height + _LINE * len(lines))
    figure.set_size_inches(width, height + _LINE * len(lines))
    figure.get_layout_engine().set(rect=(0.0, share, 1.0, 1.0 - share))  # type: ignore[union-attr,call-arg]
    figure.text(
        0.5, 0.04 / height, "\n".join(lines), ha="center", va="bottom", size=7.5, color=GREY
    )


def legend_above(figure: Figure, axes: Axes, columns: int) -> None:
    """Put the legend of ``axes`` above everything; the caption has the place below."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns)
