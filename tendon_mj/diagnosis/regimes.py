"""What was going on at every sample: the coordinates in which a misfit is looked for.

Everything is read from what was recorded: the driven displacement says which way, how fast, how far
since the last reversal and how long at rest; the first measured column stands for the load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.errors import RecordingError
from tendon_mj.simulate.recording import Recording

FloatArray = NDArray[np.float64]

_BINS = 6
_REST = 0.02  # of the largest speed: slower is at rest


@dataclass(frozen=True, eq=False)
class Regime:
    """One coordinate, cut into bins.

    Attributes:
        name: of the coordinate, such as "speed".
        labels: of the bins, in words and units.
        number: (samples,) bin of every sample.
    """

    name: str
    labels: tuple[str, ...]
    number: NDArray[np.int64]


def motion(recording: Recording) -> tuple[str, FloatArray, FloatArray]:
    """The driven column that moves most often, its values, and its smoothed rate [unit/s].

    Raises:
        RecordingError: nothing is driven, or what is driven never reverses.
    """
    where = f"recording {recording.name!r}"
    if not recording.drive:
        raise RecordingError(f"{where}: no column is in [drive], so nothing moved the tendon")
    best, turns = "", -1
    for column in recording.drive:
        values = recording.columns[column]
        moved = values[np.concatenate([[True], np.diff(values) != 0.0])]
        count = int(np.count_nonzero(np.diff(np.sign(np.diff(moved))))) if moved.size > 2 else 0
        if np.ptp(values) > 0.0 and count > turns:
            best, turns = column, count
    if turns < 0:
        raise RecordingError(f"{where}: the drive stands still, so the tendon never moved")
    if turns == 0:
        raise RecordingError(
            f"{where}: the tendon never reversed; friction shows at reversals, so record a motion"
            f" that goes back and forth (column {best!r} only goes one way)"
        )
    values = recording.columns[best]
    return best, values, np.gradient(values, recording.time)


def regimes(recording: Recording) -> list[Regime]:
    """All coordinates of a recording."""
    column, place, rate = motion(recording)
    time = recording.time
    unit = column.rsplit("_", 1)[-1]
    fastest = float(np.abs(rate).max())
    way = np.where(np.abs(rate) < _REST * fastest, 0, np.sign(rate)).astype(np.int64)
    since, rest = _since_reversal(time, place, way)
    load = recording.columns[next(iter(recording.measured))]
    load_unit = next(iter(recording.measured)).rsplit("_", 1)[-1]
    return [
        Regime("direction", ("loosening", "at rest", "pulling"), way + 1),
        _cut("distance since reversal", since, unit, spread=True),
        _cut("speed", np.abs(rate), f"{unit}/s"),
        _cut("load", load, load_unit),
        _cut("time at rest", rest, "s"),
        _cut("time", time - time[0], "s"),
        _cut("posture", place, unit),
    ]


def _since_reversal(
    time: FloatArray, place: FloatArray, way: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Distance covered since the direction last changed, and time at rest."""
    since, rest = np.zeros(time.size), np.zeros(time.size)
    heading, turn, stopped = 0, place[0], time[0]
    for k in range(time.size):
        if way[k] != 0:
            if way[k] != heading:
                heading, turn = way[k], place[k]
            stopped = time[k]
        since[k] = abs(place[k] - turn)
        rest[k] = time[k] - stopped
    return since, rest


def _cut(name: str, values: ArrayLike, unit: str, spread: bool = False) -> Regime:
    """Bins of equal width; with ``spread`` narrower near 0, where most happens after a reversal."""
    series = np.asarray(values, float)
    low, high = float(series.min()), float(series.max())
    share = np.linspace(0.0, 1.0, _BINS + 1)
    edges = low + (high - low) * (share**2 if spread else share)
    number = np.clip(np.searchsorted(edges, series, side="right") - 1, 0, _BINS - 1)
    labels = tuple(f"{edges[k]:.3g} … {edges[k + 1]:.3g} {unit}" for k in range(_BINS))
    return Regime(name, labels, number.astype(np.int64))
