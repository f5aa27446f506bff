"""Style of all figures: colours for all eyes, lines that print, labels with units."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from tendon_mj.lab.units import EngineeringUnit, column_name, column_unit, engineering_unit
from tendon_mj.typing import FloatArray

# from Okabe and Ito's palette
BLACK = "#000000"
ORANGE = "#E69F00"
SKY = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#6E6E6E"
PALE = "#B4B4B4"  # a wide line for others to lie on
# colour, line style and marker of the series of a figure, in order
SERIES = (
    (BLUE, "--", "o"),
    (VERMILLION, "-.", "s"),
    (GREEN, (0, (1, 1)), "^"),
    (PURPLE, (0, (6, 1, 1, 1, 1, 1)), "D"),
    (ORANGE, (0, (4, 2)), "v"),
    (SKY, (0, (8, 2)), "P"),
)
DPI = 160


class Theme(NamedTuple):
    """Colours of text, secondary text, background and of a ghost on it."""

    ink: str
    grey: str
    background: str
    ghost: str


LIGHT = Theme("#202020", GREY, "#FFFFFF", "#ADB0B5")
DARK = Theme("#E6EDF3", "#9198A1", "#0D1117", "#585B61")


def on_theme(colour: str, theme: Theme) -> str:
    """A colour of the light theme, as bright on the dark one as it can be read there."""
    if theme is LIGHT:
        return colour
    named = {BLACK: theme.ink, LIGHT.ink: theme.ink, GREY: theme.grey}
    red, green, blue = (0.65 * part + 0.35 for part in to_rgb(colour))
    return named.get(colour) or to_hex((red, green, blue))


_SETTINGS: Any = {
    "font.size": 9.0,
    "axes.labelsize": 9.5,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "lines.markersize": 5.0,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "savefig.dpi": DPI,
    "figure.dpi": DPI,
}


@contextmanager
def print_style(theme: Theme = LIGHT) -> Iterator[None]:
    """Apply the style to figures made inside; nothing outside it changes."""
    drawn = ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color")
    dark: Any = dict.fromkeys(drawn, theme.ink) | {
        "figure.facecolor": theme.background,
        "axes.facecolor": theme.background,
        "grid.color": "#30363D",
    }
    with mpl.rc_context(_SETTINGS | (dark if theme is DARK else {})):
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of that size [inch] that places its parts itself and needs no pyplot."""
    figure = Figure(figsize=(width, height), layout="constrained", dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def legend_below(figure: Figure, axes: Axes, columns: int) -> None:
    """Put the legend of ``axes`` under the whole figure, off the data."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)


def drawn_unit(column: str, *series: FloatArray) -> EngineeringUnit:
    """The unit in which series of a column are drawn on one axis."""
    largest = [float(np.abs(values).max(initial=0.0)) for values in series]
    return engineering_unit(column_unit(column), largest)


def column_label(column: str, unit: EngineeringUnit) -> str:
    """A column as an axis label: ``joint_rad`` in degrees is `joint [°]`."""
    return labelled(column_name(column), unit)


def labelled(name: str, unit: EngineeringUnit | None = None) -> str:
    """A name with its unit, if it has one."""
    return f"{name} [{unit.symbol}]" if unit and unit.symbol else name
