"""How much of an output's variance follows one parameter."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tendon_mj.typing import FloatArray

_MOST_BINS = 30
FEWEST = 5  # rollouts of which shares are told; with less each value is nearly its own mean


def bins_of(values: FloatArray, drawn: bool) -> NDArray[np.int64]:
    """(n,) number of the bin of each value: on a grid its own, of draws a quantile.

    The m draws are in √m bins, at most 30, each with as many.
    """
    different, place = np.unique(values, return_inverse=True)
    if drawn:
        number = min(_MOST_BINS, max(2, math.isqrt(len(different))))
        place = (place * number) // len(different)
    return np.asarray(place, np.int64)


def share_of_variance(values: FloatArray, output: FloatArray, among: int = 0) -> float:
    """The part of an output's variance that its mean at each parameter value accounts for.

        S = Var(E[y | x]) / Var(y)

    It is the first-order Sobol index (Sobol, 2001) where the parameters are independent. The mean
    at a value is over all rollouts that have it: all combinations of the others. Of parameters that
    are drawn together each draw has one value of every one; there E[y | x] is straight lines in
    quantiles of x, and R² is adjusted for their number, so that the others' scatter is not
    counted. 0 where nothing varies.

    Args:
        values: (n,) of the parameter.
        output: (n,) finite.
        among: number of parameters that are drawn together with this one and itself; 0 for a grid.
    """
    spread = float(np.ptp(output)) if len(output) else 0.0
    if not spread > 0.0:
        return 0.0
    output = (output - output.mean()) / spread
    different, place, count = np.unique(values, return_inverse=True, return_counts=True)
    mean = np.bincount(place, output) / count
    between = float(np.sum(count * mean**2) / np.sum(output**2))
    return between * _explained(different, mean) if among > 1 else between


def _explained(x: FloatArray, y: FloatArray) -> float:
    """Adjusted R² of straight lines in quantiles of x, which is sorted."""
    bins = min(_MOST_BINS, max(1, math.isqrt(len(x)) // 2))
    free = len(x) - 2 * bins
    total = float(np.sum((y - y.mean()) ** 2))
    if free < 1 or not total > 0.0:
        return 0.0
    rest = 0.0
    for part in np.array_split(np.arange(len(x)), bins):
        line = np.polynomial.Polynomial.fit(x[part], y[part], 1)
        rest += float(np.sum((y[part] - line(x[part])) ** 2))
    return max(0.0, 1.0 - rest / free * (len(x) - 1) / total)
