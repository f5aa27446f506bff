"""Regimes of motion and load at every sample, in which a misfit is located.

They are read from the recorded columns. The driven displacement gives direction, speed, distance
since the last reversal and time at rest; the first measured force or torque, or else the first
measured column, is the load. A misfit is located by the share of its excess χ² in each regime.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.limits import ABOVE_NOISE
from tendon_mj.lab.noise import estimate_noise
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.units import column_name, column_unit, from_to
from tendon_mj.lab.units import rate as rate_unit
from tendon_mj.typing import FloatArray

_BINS = 6
_ZERO = 1e-4  # of a coordinate's range: an end of a bin this near to 0 is written 0
_REST = 0.02  # of the largest speed; slower counts as at rest
_SINCE = "distance since reversal"
_WINDOWS = 5, 9, 17, 33, 65  # samples
_HYSTERESIS = 0.02  # of a column's range: a turn by less is jitter and no reversal
_CONCENTRATED = 1.5  # share of the excess over share of the samples, to be reported


@dataclass(frozen=True, eq=False)
class _Regime:
    """One coordinate, cut into bins."""

    name: str  # coordinate, such as "speed"
    labels: tuple[str, ...]  # range of each bin, with its unit
    bins: NDArray[np.int64]  # (samples,) bin of every sample


def motion(recording: Recording) -> tuple[str, FloatArray, FloatArray]:
    """Driven column that reverses most often, its values, and its rate [unit/s].

    Of a rest it is the move before it, which says in which direction friction acts.
    """
    where = f"recording {recording.name!r}"
    if not recording.drive:
        raise RecordingError(f"{where}: no column is in [drive], so nothing moved the tendon")
    best, turns = "", -1
    for column in recording.drive:
        values = recording.columns[column]
        count = _reversals(values)
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
    if recording.quasi_static:
        return best, values, np.diff(values, prepend=values[0])
    return best, values, _rate(recording.time, values)


def _rate(time: FloatArray, values: FloatArray) -> FloatArray:
    """Slopes of lines through the fewest samples that keep noise below the rest speed [unit/s].

    The slope through n samples, h apart, with noise σ has a standard deviation √12 σ/(h n^{3/2}).
    """
    step, noise = float(np.median(np.diff(time))), estimate_noise(values)
    rate: FloatArray = np.gradient(values, time)  # lines through three samples
    count = 3
    for wider in _WINDOWS:
        if np.sqrt(12.0) * noise / (step * count**1.5) < 0.5 * _REST * np.abs(rate).max():
            break
        if wider <= values.size:
            rate = scipy.signal.savgol_filter(values, wider, 1, deriv=1, delta=step)
            count = wider
    return rate


def _reversals(values: FloatArray) -> int:
    """Number of reversals of a series, by more than jitter."""
    hysteresis = _HYSTERESIS * float(np.ptp(values))
    low = high = values[0]
    heading = count = 0
    for value in values:
        low, high = min(low, value), max(high, value)
        if heading <= 0 and value > low + hysteresis:
            count += heading != 0
            heading, high = 1, value
        elif heading >= 0 and value < high - hysteresis:
            count += heading != 0
            heading, low = -1, value
    return int(count)


def regimes(recordings: Sequence[Recording]) -> list[list[_Regime]]:
    """Regimes of every recording; a coordinate has the same bins in all of them.

    A constant coordinate, as the speed of rests, is left out.
    """
    coordinates = [_coordinates(recording) for recording in recordings]
    ends: dict[tuple[str, str], list[float]] = {}
    for rows in coordinates:
        for name, unit, series in rows[1:]:
            ends.setdefault((name, unit), []).extend((float(series.min()), float(series.max())))
    constant = [name for (name, _), values in ends.items() if min(values) == max(values)]
    found = []
    for (_, _, sense), *others in coordinates:
        own = [_Regime("direction", ("loosening", "at rest", "pulling"), sense.astype(np.int64))]
        for name, unit, series in others:
            if name not in constant:
                own.append(_cut(name, series, unit, min(ends[name, unit]), max(ends[name, unit])))
        found.append(own)
    return found


def _coordinates(recording: Recording) -> list[tuple[str, str, FloatArray]]:
    """(name, unit, value at every sample); first the direction, 0 loosening to 2 pulling."""
    column, position, rate = motion(recording)
    time = recording.time
    unit = column_unit(column)
    fastest = float(np.abs(rate).max())
    way = np.where(np.abs(rate) < _REST * fastest, 0, np.sign(rate)).astype(np.int64)
    since, rest = _since_reversal(time, position, way)
    speed = np.abs(rate)
    if recording.settling_time is not None:
        speed, rest = np.zeros(time.size), np.full(time.size, recording.settling_time)
    loads = sorted(recording.measured, key=lambda name: not name.endswith(("_N", "_Nm")))
    return [
        ("direction", "", way + 1.0),
        (_SINCE, unit, since),
        ("speed", rate_unit(unit), speed),
        ("load", column_unit(loads[0]), recording.columns[loads[0]]),
        ("time at rest", "s", rest),
        ("time", "s", time - time[0]),
        *([] if unit in ("N", "Nm") else [("posture", unit, position)]),  # a drive's force is none
    ]


def _since_reversal(
    time: FloatArray, position: FloatArray, way: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Distance covered since the direction last changed, and time at rest."""
    since, rest = np.zeros(time.size), np.zeros(time.size)
    heading, turn, stopped = 0, position[0], time[0]
    for k in range(time.size):
        if way[k] != 0:
            if way[k] != heading:
                heading, turn = way[k], position[k]
            stopped = time[k]
        since[k] = abs(position[k] - turn)
        rest[k] = time[k] - stopped
    return since, rest


def _cut(name: str, series: FloatArray, unit: str, low: float, high: float) -> _Regime:
    """Regime with bins of equal width; narrower near 0 for the distance since a reversal."""
    share = np.linspace(0.0, 1.0, _BINS + 1)
    edges = low + (high - low) * (share**2 if name == _SINCE else share)
    bins = np.clip(np.searchsorted(edges, series, side="right") - 1, 0, _BINS - 1)
    rounded = np.where(np.abs(edges) < _ZERO * (high - low), 0.0, edges)
    labels = tuple(from_to(a, b, unit, " … ", rounded) for a, b in pairwise(rounded.tolist()))
    return _Regime(name, labels, bins.astype(np.int64))


@dataclass(frozen=True)
class Bin:
    """One bin of one regime."""

    # coordinate and range
    regime: str
    label: str
    excess: float  # share of the excess χ² in the bin; all bins of a regime add up to 1
    time: float  # share of the samples in the bin
    rms: float  # of the residual in the bin [noise]


@dataclass(frozen=True)
class Located:
    """Location of a residual."""

    bins: tuple[Bin, ...] = field(repr=False)  # of every regime, those that were visited
    sentence: str  # summary in words
    # frequency below which half of the excess lies [Hz]; 0 if there is no excess, or where rows
    # are rests
    frequency: float


def locate(problem: Problem, residual: FloatArray, mask: NDArray[np.bool_]) -> Located:
    """Distribute the excess χ² of a residual (m,) [noise], where ``mask``, over the regimes."""
    per_recording = regimes(problem.recordings)
    kept = [mask[rows] for _, _, rows in problem.signals]
    parts = [residual[r][used] for (_, _, r), used in zip(problem.signals, kept, strict=True)]
    inside: dict[tuple[str, str], list[FloatArray]] = {}
    for index, first in enumerate(per_recording[0]):
        for b in range(len(first.labels)):
            for (k, _, _), part, used in zip(problem.signals, parts, kept, strict=True):
                regime = per_recording[k][index]
                samples = part[regime.bins[used] == b]
                if samples.size:
                    inside.setdefault((first.name, regime.labels[b]), []).append(samples)
    for (_, column, _), part in zip(problem.signals, parts, strict=True):
        inside.setdefault(("signal", column), []).append(part)
    residual = residual[mask]
    total = float((residual**2).sum()) - residual.size
    has_shares = 0.0 < total < np.inf  # infinite if a simulation failed
    bins = []
    for (name, label), samples_of in inside.items():
        power = np.concatenate(samples_of) ** 2
        share = (float(power.sum()) - power.size) / total if has_shares else 0.0
        rms = float(np.sqrt(power.mean()))
        bins.append(Bin(name, label, share, power.size / residual.size, rms))
    frequency = _half_frequency(problem, parts) if has_shares and not problem.at_rest else 0.0
    return Located(tuple(bins), _describe(bins, residual, frequency), frequency)


def _half_frequency(problem: Problem, parts: Sequence[FloatArray]) -> float:
    """Frequency below which half of the excess power lies [Hz]."""
    frequencies, powers = [], []
    for (k, _, _), part in zip(problem.signals, parts, strict=True):
        step, size = float(np.median(np.diff(problem.recordings[k].time))), part.size
        power = np.abs(np.fft.rfft(part)) ** 2 / size - 1.0  # white noise of power 1 leaves 1
        frequencies.append(np.fft.rfftfreq(size, step))
        powers.append(power)
    frequency, power = np.concatenate(frequencies), np.concatenate(powers)
    order = np.argsort(frequency)
    added = np.cumsum(power[order])
    reached = np.flatnonzero(added >= 0.5 * added[-1])
    return float(frequency[order][reached[0]]) if added[-1] > 0.0 and reached.size else 0.0


def _describe(bins: Sequence[Bin], residual: FloatArray, frequency: float) -> str:
    rms = float(np.sqrt(np.mean(residual**2)))
    if rms < ABOVE_NOISE:
        return f"The misfit is {rms:.2f} times the noise: nothing stands out."
    dense = sorted(
        (b for b in bins if b.excess > 0.2 and b.excess > _CONCENTRATED * b.time),
        key=lambda b: b.time - b.excess,
    )
    text = f"The misfit is {rms:.1f} times the noise"
    if frequency > 0.0:
        text += f", half of its excess slower than {frequency:.2g} Hz"
    reported: list[str] = []
    for b in dense:
        if b.regime not in reported and len(reported) < 3:
            reported.append(b.regime)
            share = min(b.excess, 1.0)  # more, where another bin is below the noise
            place = (
                f"those of {column_name(b.label)}"
                if b.regime == "signal"
                else f"where {b.regime} is {b.label}"
            )
            text += f"; {share:.0%} of the excess lies in {b.time:.0%} of the samples, {place}"
    return text + ("." if reported else ", spread over all regimes.")
