"""Outputs of a sweep, ``<sensor>.<summary>`` of each rollout, and the influence of a parameter.

| summary | of the sensor's series over the motion |
|---|---|
| final | last value |
| min, max, mean | least, largest, mean value |
| rms | root mean square |
| error | root mean square of simulated − measured; only on a recording |
"""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.typing import FloatArray

ERROR = "error"
_MOST_BINS = 30
FEWEST_ROLLOUTS = 5  # rollouts for shares; with fewer each value is nearly its own mean

# (sensors, n) series → (sensors,)
SUMMARIES: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "final": lambda series: series[:, -1],
    "min": lambda series: series.min(axis=1),
    "max": lambda series: series.max(axis=1),
    "mean": lambda series: series.mean(axis=1),
    "rms": lambda series: np.sqrt(np.mean(series**2, axis=1)),
}


class SensorSummary(NamedTuple):
    """A summary of the readings of a sensor in a rollout.

    Attributes:
        sensor: its name.
        summary: one of ``SUMMARIES``, or ``ERROR``.
        unit: of the sensor.
    """

    sensor: str
    summary: str
    unit: str

    @property
    def name(self) -> str:
        """``<sensor>.<summary>``, a column of the table."""
        return f"{self.sensor}.{self.summary}"


def parse_outputs(
    texts: Sequence[str], units: Mapping[str, str], recorded: bool
) -> tuple[SensorSummary, ...]:
    """Outputs of ``sensor.summary``, or ``sensor`` for all its summaries; of no text, all outputs.

    ``*`` stands for any text, unless a sensor or output is so named. ``units`` has all sensors of
    one number; only what was ``recorded`` has an ``ERROR``.
    """
    if not units:
        raise InvalidValueError(
            "the model has no sensor of one number with a name, so a rollout has no output; add one"
        )
    summaries = [*SUMMARIES, *([ERROR] if recorded else [])]
    known = {
        output.name: output
        for sensor, unit in units.items()
        for output in (SensorSummary(sensor, summary, unit) for summary in summaries)
    }
    outputs: dict[str, SensorSummary] = {}
    for text in texts or ["*"]:
        wanted = {n: output for n, output in known.items() if text in (n, output.sensor)}
        wanted = wanted or {n: known[n] for n in fnmatch.filter(known, text)}
        if not wanted:
            raise UnknownNameError("output", text, [*units, *known], "--outputs")
        outputs |= wanted
    return tuple(outputs.values())


def summarised(
    outputs: Sequence[SensorSummary],
    series: Mapping[str, FloatArray],
    measured: Mapping[str, FloatArray],
) -> list[float]:
    """Values of outputs, from sensor → (n,) in a rollout and, for ``ERROR``, in the recording."""
    rows = {sensor: k for k, sensor in enumerate(series)}
    stacked = np.array(list(series.values()))
    wanted = {output.summary for output in outputs}
    summaries = {name: SUMMARIES[name](stacked) for name in wanted - {ERROR}}
    if ERROR in wanted:
        errors = stacked - np.array([measured[sensor] for sensor in series])
        summaries[ERROR] = SUMMARIES["rms"](errors)
    return [float(summaries[o.summary][rows[o.sensor]]) for o in outputs]


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
