"""A chart, and what all charts share: text that is shown as it is written, and thin curves."""

from __future__ import annotations

import html
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.typing import FloatArray

Chart = dict[str, Any]  # plotly's figure: "data", a list of traces, and "layout"

_DIGITS = 5  # of a number in a chart


def text(words: str) -> str:
    """Words as plotly shows them unformatted: tags in them may come from a file."""
    return html.escape(words, quote=False)


def numbers(values: ArrayLike) -> list[float]:
    """(n,) values with five digits each."""
    return [float(f"{value:.{_DIGITS}g}") for value in np.asarray(values, float).tolist()]


def thin(values: FloatArray, most: int) -> NDArray[np.int64]:
    """Samples of a curve to draw: the least and the largest value of each of ``most``/2 stretches.

    No peak is lost, and a curve that has no more samples than ``most`` is drawn whole.

    Args:
        values: (n,) of the curve.
        most: samples to keep, two or more; the first and the last are kept besides.

    Returns:
        (k,) ascending indices.
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
