"""Outputs of a sweep by name: ``<sensor>.<summary>`` of each rollout.

| summary | of the sensor's series over the motion |
|---|---|
| final | last value |
| min, max, mean | least, largest, mean value |
| rms | root mean square |
| error | root mean square of simulated − measured; only on a recording |
"""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.typing import FloatArray

ERROR = "error"

# (sensors, n) series → (sensors,)
SUMMARIES: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "final": lambda series: series[:, -1],
    "min": lambda series: series.min(axis=1),
    "max": lambda series: series.max(axis=1),
    "mean": lambda series: series.mean(axis=1),
    "rms": lambda series: np.sqrt(np.mean(series**2, axis=1)),
}


class Output(NamedTuple):
    """A summary of what a sensor reads in a rollout.

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
) -> tuple[Output, ...]:
    """Outputs of ``sensor.summary``, or ``sensor`` for all its summaries.

    Args:
        texts: in which ``*`` stands for any text, unless a sensor or output is so named; without
            any, all outputs there are.
        units: sensor → unit of its reading, of all sensors with one number.
        recorded: whether there is something measured, to which ``ERROR`` is.

    Raises:
        UnknownNameError: no such output, with the nearest.
        InvalidValueError: the model has no sensor of one number.
    """
    if not units:
        raise InvalidValueError(
            "the model has no sensor of one number with a name, so a rollout has no output; add one"
        )
    summaries = [*SUMMARIES, *([ERROR] if recorded else [])]
    known = {
        output.name: output
        for sensor, unit in units.items()
        for output in (Output(sensor, summary, unit) for summary in summaries)
    }
    found: dict[str, Output] = {}
    for text in texts or ["*"]:
        wanted = {n: output for n, output in known.items() if text in (n, output.sensor)}
        wanted = wanted or {n: known[n] for n in fnmatch.filter(known, text)}
        if not wanted:
            raise UnknownNameError("output", text, [*units, *known], "--outputs")
        found |= wanted
    return tuple(found.values())


def summarised(
    outputs: Sequence[Output], series: Mapping[str, FloatArray], measured: Mapping[str, FloatArray]
) -> list[float]:
    """Values of outputs.

    Args:
        outputs: of a sweep.
        series: sensor → (n,) in a rollout.
        measured: sensor → (n,) of the recording, for ``ERROR``.
    """
    rows = {sensor: k for k, sensor in enumerate(series)}
    stacked = np.array(list(series.values()))
    wanted = {output.summary for output in outputs}
    found = {name: SUMMARIES[name](stacked) for name in wanted - {ERROR}}
    if ERROR in wanted:
        apart = stacked - np.array([measured[sensor] for sensor in series])
        found[ERROR] = SUMMARIES["rms"](apart)
    return [float(found[o.summary][rows[o.sensor]]) for o in outputs]
