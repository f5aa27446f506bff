"""Axes of a sweep, values of its parameters in each rollout, outputs, and their shares of variance.

Outputs are ``<sensor>.<summary>``:

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
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.typing import FloatArray

MOST_ROLLOUTS = 10_000_000  # of a sweep; their columns are read into memory
_GRID = 5  # values of a range without a number, if nothing is drawn
_FORMS = "name=low:high, name=low:high:values or name=value,value,…"

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


class Axis(NamedTuple):
    """Parameters that vary together, and their values."""

    name: str  # as given
    targets: tuple[str, ...]  # parameters that have its value
    # ends of its values [the parameter's unit]
    low: float
    high: float
    # its values, in order; None where they are drawn from low to high
    grid: NDArray[np.float64] | None


def parse_axes(
    texts: Sequence[str], draws: int, parameters: Collection[str], sheaths: Mapping[str, str]
) -> list[Axis]:
    """Axes of ``name=low:high``, ``name=low:high:values`` and ``name=value,value,…``.

    ``*`` in a name stands for any text, the name of a tendon for its sheath; ``sheaths`` maps a
    sheath to its tendon. Without ``draws`` a range without a number of values is a grid of 5.
    """
    axes = [_parse(text, draws, parameters, sheaths) for text in texts]
    seen: dict[str, str] = {}
    for axis in axes:
        for target in axis.targets:
            if target in seen:
                both = f"--parameter {seen[target]} and --parameter {axis.name}"
                raise InvalidValueError(f"{both} both set {target}; give it one range")
            seen[target] = axis.name
    if not axes:
        raise InvalidValueError(f"nothing is varied; give --parameter {_FORMS}")
    if draws and all(axis.grid is not None for axis in axes):
        raise InvalidValueError(
            f"--draws {draws}: no --parameter is a range to draw from, low:high"
        )
    return axes


def _parse(text: str, draws: int, parameters: Collection[str], sheaths: Mapping[str, str]) -> Axis:
    name, equals, values = (part.strip() for part in text.rpartition("="))
    form = f"--parameter {text}: it is not like {_FORMS}"
    if not equals:
        raise InvalidValueError(form)
    targets = _targets(name, f"--parameter {text}", parameters, sheaths)
    try:
        numbers = [float(part) for part in values.split(":" if ":" in values else ",")]
    except ValueError:
        raise InvalidValueError(form) from None
    if not all(map(math.isfinite, numbers)):
        raise InvalidValueError(f"--parameter {text}: values must be finite")
    if ":" not in values:
        return Axis(name, targets, min(numbers), max(numbers), np.array(numbers))
    if len(numbers) not in (2, 3) or not numbers[0] < numbers[1]:
        raise InvalidValueError(f"--parameter {text}: a range is low:high, or low:high:values")
    low, high, *given = numbers
    if not given and draws:
        return Axis(name, targets, low, high, None)
    count = given[0] if given else _GRID
    if count != int(count) or not 2 <= count <= MOST_ROLLOUTS:
        raise InvalidValueError(
            f"--parameter {text}: {count:g} values; a range has 2 to {MOST_ROLLOUTS}"
        )
    return Axis(name, targets, low, high, np.linspace(low, high, int(count)))


def _targets(
    name: str, where: str, parameters: Collection[str], sheaths: Mapping[str, str]
) -> tuple[str, ...]:
    if name in parameters:
        return (name,)
    tendon, _, parameter = name.rpartition(".")
    inside = [sheath for sheath, of in sheaths.items() if of == tendon]
    if "*" in name:
        targets = tuple(fnmatch.filter(sorted(parameters), name))
    else:
        targets = tuple(n for s in inside if (n := f"{s}.{parameter}") in parameters)
    if not targets:
        others = {n.rpartition(".")[2] for n in parameters if n.rpartition(".")[0] in inside}
        valid = [*parameters, *(f"{tendon}.{other}" for other in others)]
        raise UnknownNameError("parameter", name, valid, where)
    return targets


class Design:
    """Every combination of the grids' values, each with the same random draws of the ranges.

    The last axis changes fastest, and draws faster than grids. That all combinations have the same
    draws keeps their scatter out of the differences between them. The first draws are the same
    whatever their number.
    """

    def __init__(self, axes: Sequence[Axis], draws: int, seed: int) -> None:
        self._grids = {k: axis.grid for k, axis in enumerate(axes) if axis.grid is not None}
        drawn = [axis for axis in axes if axis.grid is None]
        self._drawn = [k for k, axis in enumerate(axes) if axis.grid is None]
        low, high = np.array([[axis.low, axis.high] for axis in drawn]).reshape(-1, 2).T
        size = (draws if drawn else 1, len(drawn))
        self._shape = (*(len(grid) for grid in self._grids.values()), size[0])
        self._axes = len(axes)
        self.rollouts = math.prod(self._shape)
        if self.rollouts > MOST_ROLLOUTS:
            raise InvalidValueError(
                f"{' × '.join(map(str, self._shape))} make {self.rollouts} rollouts; a sweep has"
                f" at most {MOST_ROLLOUTS}, so give fewer --draws, or fewer values of a --parameter"
            )
        self._draws = np.random.default_rng(seed).uniform(low, high, size)

    def values(self, start: int, stop: int) -> FloatArray:
        """(stop − start, axes) of the rollouts from ``start`` on."""
        *places, draw = np.unravel_index(np.arange(start, stop), self._shape)
        values = np.empty((stop - start, self._axes))
        for (axis, grid), place in zip(self._grids.items(), places, strict=True):
            values[:, axis] = grid[place]
        values[:, self._drawn] = self._draws[draw]
        return values


class SensorSummary(NamedTuple):
    """A summary of the readings of a sensor in a rollout."""

    sensor: str  # its name
    summary: str  # one of ``SUMMARIES``, or ``ERROR``
    unit: str  # of the sensor

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
    counted. 0 if nothing varies. ``values`` are (n,) of the parameter, and ``among`` parameters,
    itself included, are drawn together with it; 0 for a grid.
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
