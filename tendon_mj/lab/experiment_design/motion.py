"""Motions of a driven column: ramps, stairs, growing reversals, sines and sweeps.

A motion goes between two levels at one speed, from where the recordings begin, and rests at its
turns. Every number is rounded, so that it can be written down and set on a rig.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import cycle

import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.experiment_design.bounds import DriveBounds
from tendon_mj.lab.replay import rate as per_second
from tendon_mj.typing import FloatArray

SHAPES = ("ramps", "stairs", "growing", "sine", "sweep")
NUMBERS = 5  # that describe a motion within its bounds: shape, span, place, speed, rest
_SMALLEST_SPAN = 0.1  # of the range
_CYCLES = 1.5  # at least, in a recording
_MOVING = 0.5  # of a recording, at least: rests take no more than the other half
_WAYS = 4.0  # from the start and then between the levels, in that time
_SAMPLES = 4  # at least, on the way from one level to the other
_NO_DWELL = 0.3  # share of the motions that do not rest
_RESTS = {"ramps": 6.0, "stairs": 12.0, "growing": 12.0}  # all rests of a cycle fit in a recording
_STAIRS, _LOOPS = 4, 4


@dataclass(frozen=True)
class Motion:
    """Motion of one driven column.

    Attributes:
        shape: one of `SHAPES`.
        start: where it begins [the column's unit].
        low, high: levels between which it goes [unit].
        rate: highest speed [unit/s].
        dwell: rest at each turn [s].
    """

    shape: str
    start: float
    low: float
    high: float
    rate: float
    dwell: float = 0.0

    @property
    def frequency(self) -> float:
        """Frequency of a sine of that amplitude and speed [Hz]."""
        return self.rate / (np.pi * (self.high - self.low))

    def series(self, time: FloatArray) -> FloatArray:
        """(n,) values at ``time`` [s], which begins at 0."""
        if self.high <= self.low:
            raise InvalidValueError(
                f"a motion between {self.low!r} and {self.high!r}: the second must be larger"
            )
        begin = abs(self.low - self.start) / self.rate
        if self.shape not in ("sine", "sweep"):
            return self._ramps(time)
        since = np.maximum(0.0, time - begin)
        phase = 2.0 * np.pi * self.frequency * since
        if self.shape == "sweep":
            length = max(float(time[-1]) - begin, 1e-9)
            slow = min(_CYCLES / length, self.frequency)
            growth = np.log(self.frequency / slow) / length
            phase = (
                2.0 * np.pi * slow * (np.expm1(growth * since) / growth if growth > 0.0 else since)
            )
        wave = 0.5 * (self.high + self.low) - 0.5 * (self.high - self.low) * np.cos(phase)
        reach = np.interp(time, [0.0, max(begin, 1e-12)], [self.start, self.low])
        moved: FloatArray = np.where(time < begin, reach, wave)
        return moved

    def words(self, unit: str, duration: float) -> str:
        """The motion in words."""
        span = f"between {self.low:g} and {self.high:g} {unit}"
        speed = f"at {self.rate:g} {per_second(unit)}"
        if self.shape == "sine":
            return f"following a sine {span} of {self.frequency:.3g} Hz"
        if self.shape == "sweep":
            slow = _CYCLES / duration
            return f"following a sine {span} that goes from {slow:.2g} to {self.frequency:.3g} Hz"
        rest = f", with {self.dwell:g} s of rest at each turn" if self.dwell > 0.0 else ""
        if self.shape == "stairs":
            return f"going up and down in {_STAIRS} steps {span}, {speed}{rest}"
        if self.shape == "growing":
            return f"going back and forth in {_LOOPS} growing loops {span}, {speed}{rest}"
        return f"going back and forth {span}, {speed}{rest}"

    def _ramps(self, time: FloatArray) -> FloatArray:
        corners, values = [0.0], [self.start]
        for level in cycle(self._levels()):
            way = abs(level - values[-1])
            corners.append(corners[-1] + way / self.rate)
            values.append(level)
            if self.dwell > 0.0:
                corners.append(corners[-1] + self.dwell)
                values.append(level)
            if corners[-1] > time[-1]:
                break
        series: FloatArray = np.interp(time, corners, values)
        return series

    def _levels(self) -> list[float]:
        """Turning points of one cycle."""
        middle, span = 0.5 * (self.low + self.high), self.high - self.low
        if self.shape == "stairs":
            places = [*range(_STAIRS + 1), *range(_STAIRS - 1, 0, -1)]
            return [self.low + span * k / _STAIRS for k in places]
        if self.shape == "growing":
            shares = [k / _LOOPS for k in range(1, _LOOPS + 1)]
            return [middle + side * 0.5 * span * s for s in shares for side in (1.0, -1.0)]
        return [self.low, self.high]


def motion_at(
    point: FloatArray, bounds: DriveBounds, start: float, duration: float, interval: float
) -> Motion:
    """The motion at a point of the unit cube.

    Args:
        point: (`NUMBERS`,) each 0 … 1.
        bounds: of the column.
        start: where it begins [the column's unit].
        duration: of the recording [s].
        interval: between samples [s].
    """
    shape = SHAPES[min(int(point[0] * len(SHAPES)), len(SHAPES) - 1)]
    whole = bounds.high - bounds.low
    span = whole * (_SMALLEST_SPAN + (1.0 - _SMALLEST_SPAN) * point[1])
    moving = _MOVING * duration
    reach = bounds.rate * moving / _WAYS  # of the start, and of one way from level to level
    span = min(span, reach)
    low = bounds.low + point[2] * (whole - span)
    low = min(max(low, start - reach, bounds.low), start + reach - span, bounds.high - span)
    approach = max(abs(low - start), abs(low + span - start))
    slowest = (approach + (_WAYS - 1.0) * span) / moving
    fastest = max(slowest, min(bounds.rate, span / (_SAMPLES * interval)))
    longest = min(bounds.dwell, duration / _RESTS.get(shape, np.inf))
    dwell = longest * max(0.0, float(point[4]) - _NO_DWELL) / (1.0 - _NO_DWELL)
    rate = float(slowest * (fastest / slowest) ** point[3])
    return Motion(
        shape=shape,
        start=start,
        low=max(rounded(low, span), bounds.low),
        high=min(rounded(low + span, span), bounds.high),
        rate=min(rounded(rate, rate), bounds.rate),
        dwell=rounded(dwell, duration) if shape in _RESTS else 0.0,
    )


def rounded(value: float, scale: float) -> float:
    """The number to about a thousandth of ``scale`` > 0."""
    return round(float(value), 2 - math.floor(math.log10(scale)))
