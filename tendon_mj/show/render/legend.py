"""Legend above a chart, in as many columns as there is place for and as many rows as that needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

from matplotlib.axes import Axes
from matplotlib.font_manager import findfont
from matplotlib.lines import Line2D
from PIL import ImageFont

_SIZE = 8.0  # of the text [pt]
_HANDLE, _GAP, _COLUMN = 1.3, 0.4, 0.8  # lengths of the line and of both gaps over the text's size
_ROW, _ROWS_APART = 1.25, 0.1  # height of a row, and what is between rows, over the text's size
_MOST_COLUMNS = 4
_MOST_LONG = 6  # entries in a single column
_FINE = 16  # pixels to a point that text is measured in


class Legend:
    """A legend laid out in a width.

    Attributes:
        names: of the entries; one that is too long for its column lacks its middle.
        columns, rows: of the legend.

    Args:
        names: of the entries.
        width: that there is [inch].
    """

    def __init__(self, names: Sequence[str], width: float) -> None:
        place = 72.0 * width / _SIZE  # over the text's size
        around = _HANDLE + _GAP + _COLUMN
        least = 1 if len(names) <= _MOST_LONG else 2
        self.names = [shortened(name, place / least - around) for name in names]
        widest = around + max((text_width(name) for name in self.names), default=0.0)
        most = max(1, min(_MOST_COLUMNS, int(place / widest + 1e-9)))
        self.rows = max(1, math.ceil(len(self.names) / most))
        self.columns = max(1, math.ceil(len(self.names) / self.rows))

    @property
    def height(self) -> float:
        """Height of all rows [inch]."""
        return self.rows * (_ROW + _ROWS_APART) * _SIZE / 72.0

    def draw(self, axes: Axes, entries: Sequence[Line2D], left: float) -> None:
        """Draw the legend above a chart, from ``left`` of its width on, and keep its place free."""
        # the layout leaves the place of a title, which is as wide as the chart, unlike the legend
        axes.set_title(" ", fontsize=_SIZE, pad=72.0 * self.height - _SIZE)
        drawn = axes.legend(
            entries,
            self.names,
            loc="lower left",
            bbox_to_anchor=(left, 1.0),
            ncols=self.columns,
            borderpad=0.2,
            borderaxespad=0.1,
            labelspacing=_ROWS_APART,
            columnspacing=_COLUMN,
            handlelength=_HANDLE,
            handletextpad=_GAP,
            fontsize=_SIZE,
        )
        drawn.set_in_layout(False)


def shortened(text: str, width: float) -> str:
    """A text that is not wider than ``width`` over its size; "…" stands for what it lacks."""
    kept = text
    while len(kept) > 1 and text_width(kept) > width:
        half = (len(kept) - 2) // 2  # what tells names apart is as often at their end
        kept = f"{text[:half]}…{text[-half:] if half else ''}"
    return kept


def text_width(text: str) -> float:
    """Width of a text over its size."""
    return float(_font().getlength(text)) / (_FINE * _SIZE)


@cache
def _font() -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(findfont("DejaVu Sans"), int(_FINE * _SIZE))
