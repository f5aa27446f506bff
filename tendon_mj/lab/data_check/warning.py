"""A warning about a recording, and measures of a column that several checks share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import column_unit
from tendon_mj.typing import FloatArray

_TURN, _NEARLY = 2.0 * np.pi, 0.15  # of an encoder [rad], and by what share a jump may differ
_SMOOTH = 0.1  # of a turn, by which other samples differ at most, in the median
_OUTER = 1.0  # percent of the samples at either end that do not count for the usual range


@dataclass(frozen=True)
class DataWarning:
    """Something in a recording that a fit would take for a property of the rig.

    Attributes:
        identifier: its kind in one word.
        place: recording and column, actuator or joint.
        value: the finding, with its unit.
        way_out: what to do.
        blocks: whether a fit cannot see through it, so that no effect is to be named meanwhile.
    """

    identifier: str
    place: str
    value: str
    way_out: str
    blocks: bool = False

    @property
    def sentence(self) -> str:
        """The warning in one line."""
        return f"{self.place}: {self.value}; {self.way_out}"

    def result(self) -> dict[str, str | bool]:
        """Plain entries for `result.json`."""
        return vars(self) | {"sentence": self.sentence}


def columns_of(recording: Recording) -> Iterator[tuple[str, str]]:
    """("drive" or "measured", column) of each column that has a role."""
    yield from (("drive", column) for column in recording.drive)
    yield from (("measured", column) for column in recording.measured)


def place_of(recording: Recording, column: str) -> str:
    """Recording, table of the description and name in the file of a column, for messages."""
    table = "drive" if column in recording.drive else "measured"
    return f"{recording.name}, [{table}] {recording.written(column)!r}"


def row_of(recording: Recording, sample: int) -> str:
    """Row and time of a sample, for messages."""
    return f"row {recording.row(sample)} ({recording.time[sample]:.6g} s)"


def more(count: int) -> str:
    """Message that there are others besides the first."""
    return f", and {count - 1} times more" if count > 1 else ""


def usual_range(series: FloatArray) -> float:
    """Range of a series without its most extreme samples; all of it where the rest is constant."""
    low, high = np.percentile(series, [_OUTER, 100.0 - _OUTER])
    return float(high - low) or float(np.ptp(series))


def median_around(series: FloatArray, around: int) -> FloatArray:
    """(n,) median of each sample and its neighbours, so many on either side."""
    padded = np.pad(series, around, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * around + 1)
    median: FloatArray = np.median(windows, axis=1)
    return median


def lost_turns(recording: Recording, column: str) -> NDArray[np.int64]:
    """Samples before which an angle jumps by a turn, as of an encoder that begins again."""
    if column_unit(column) != "rad":
        return np.zeros(0, np.int64)
    steps = np.abs(np.diff(recording.columns[column]))
    if float(np.median(steps)) > _SMOOTH * _TURN:
        return np.zeros(0, np.int64)
    return np.flatnonzero(np.abs(steps - _TURN) < _NEARLY * _TURN) + 1
