"""How much of an output's variance follows one parameter."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_MOST_BINS = 30
FEWEST = 5  # rollouts of which shares are told; with less each value is nearly its own mean


def bins_of(values: Array) -> NDArray[np.int64]:
    """(n,) number of the bin of each value: its own where few differ, else quantiles.

    The bins are at most 30, and at most √n.
    """
    different, place = np.unique(values, return_inverse=True)
    most = min(_MOST_BINS, max(2, math.isqrt(len(values))))
    if len(different) <= most or len(different) <= len(values) / 4:
        return np.asarray(place, np.int64)
    edges = np.quantile(values, np.linspace(0.0, 1.0, most + 1)[1:-1])
    return np.asarray(np.searchsorted(edges, values), np.int64)


def share_of_variance(values: Array, output: Array) -> float:
    """The part of an output's variance that its mean at each parameter value accounts for.

        S = Var(E[y | x]) / Var(y),   corrected for the number of bins of x (ε²)

    It is the first-order Sobol index where the parameters are independent. 0 where nothing varies.

    Args:
        values: (n,) of the parameter.
        output: (n,) finite.
    """
    total = float(np.var(output)) * len(output)
    if len(output) < 2 or not total > 0.0:
        return 0.0
    place = bins_of(values)
    count = np.bincount(place)
    used = count > 0
    mean = np.bincount(place, output)[used] / count[used]
    between = float(np.sum(count[used] * (mean - output.mean()) ** 2))
    bins, within = int(used.sum()), total - between
    if len(output) <= bins:
        return between / total
    return max(0.0, (between - (bins - 1) * within / (len(output) - bins)) / total)
