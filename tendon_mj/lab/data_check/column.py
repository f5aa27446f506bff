"""A column of a recording beside the model's, with what the checks need of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.faults import DataWarning
from tendon_mj.lab.noise import noise_levels, resolution
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.units import column_unit, quantity
from tendon_mj.typing import FloatArray


@dataclass(frozen=True)
class Column:
    """A driven or measured column of a recording, and its simulation if that did not fail."""

    recording: Recording
    name: str
    simulated: Recording | None = None

    @cached_property
    def driven(self) -> bool:
        """True if it is in [drive]."""
        return self.name in self.recording.drive

    @cached_property
    def read(self) -> FloatArray:
        """(n,) its samples."""
        return self.recording.columns[self.name]

    @cached_property
    def model(self) -> FloatArray:
        """(n,) the model's readings; NaN of a driven column, and if the simulation failed."""
        if self.driven or self.simulated is None:
            return np.full(self.read.size, np.nan)
        return self.simulated.columns[self.name]

    @cached_property
    def noise(self) -> float:
        """Standard deviation of a measured column."""
        return noise_levels(self.recording)[self.name]

    @cached_property
    def stated_noise(self) -> float | None:
        """Standard deviation that the description states."""
        return None if self.driven else self.recording.measured[self.name].noise

    @cached_property
    def unit(self) -> str:
        """SI unit."""
        return column_unit(self.name)

    @cached_property
    def sensor(self) -> str:
        """Sensor of a measured column."""
        return self.recording.measured[self.name].sensor

    @cached_property
    def correlation(self) -> float:
        """Correlation with the model, 0 where one stands; outliers would be all that counts."""
        if stands(self.read) or stands(self.model):
            return 0.0
        read, model = (
            np.clip(s, *inner(s)) if np.ptp(inner(s)) else s for s in (self.read, self.model)
        )
        return float(np.corrcoef(read, model)[0, 1])

    @cached_property
    def step(self) -> float:
        """Step in which it is quantised; 0 if it is not."""
        return resolution(self.read)

    @cached_property
    def lost_turns(self) -> NDArray[np.int64]:
        """Samples before which an angle jumps by a turn, as of an encoder that begins again."""
        steps, near = np.abs(np.diff(self.read)), limits.LITTLE * math.tau
        if self.unit != "rad" or float(np.median(steps)) > near:
            return np.zeros(0, np.int64)
        return np.flatnonzero(np.abs(steps - math.tau) < near) + 1

    @property
    def place(self) -> str:
        """Recording, table of the description and name in the file, for messages."""
        table = "drive" if self.driven else "measured"
        return f"{self.recording.name}, [{table}] {self.recording.written(self.name)!r}"

    def warn(
        self, identifier: str, value: str, way_out: str, *, blocks: bool = False
    ) -> DataWarning:
        """A warning of this column."""
        return DataWarning(identifier, self.place, value, way_out, blocks)

    def say(self, value: float, digits: int = 3) -> str:
        """A value with its unit, for messages."""
        return quantity(float(value), self.unit, digits)

    def row(self, sample: int) -> str:
        """Row and time of a sample, for messages."""
        return row_of(self.recording, sample)

    def changed(self, series: FloatArray) -> Recording:
        """The recording with another series in this column."""
        columns = {**self.recording.columns, self.name: series}
        return replace(self.recording, columns=columns)


def columns_of(recording: Recording, simulated: Recording | None = None) -> list[Column]:
    """The columns that have a role, the driven ones first."""
    return [Column(recording, c, simulated) for c in (*recording.drive, *recording.measured)]


def row_of(recording: Recording, sample: int) -> str:
    """Row and time of a sample, for messages."""
    return f"row {recording.row(sample)} ({recording.time[sample]:.6g} s)"


def more(count: int) -> str:
    """Message that there are others besides the first."""
    return f", and {count - 1} times more" if count > 1 else ""


def inner(series: FloatArray) -> tuple[float, float]:
    """Ends of the range of a series without its outliers."""
    low, high = np.quantile(series, [limits.OUTER, 1.0 - limits.OUTER])
    return float(low), float(high)


def usual_range(series: FloatArray) -> float:
    """Range of a series without its outliers; all of it if the rest is constant."""
    low, high = inner(series)
    return high - low or float(np.ptp(series))


def stands(series: FloatArray) -> bool:
    """Return whether a series moves by nothing but rounding."""
    return float(np.ptp(series)) <= limits.ROUNDING * float(np.abs(series).max(initial=0.0))


def median_around(series: FloatArray, around: int) -> FloatArray:
    """(n,) median of each sample and its neighbours, so many on either side."""
    padded = np.pad(series, around, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * around + 1)
    return np.median(windows, axis=1)


def a_step(changes: FloatArray) -> float:
    """Size from which on one of some changes is a step, and no motion."""
    return limits.STEP * float(np.percentile(np.abs(changes), limits.OFTEN))
