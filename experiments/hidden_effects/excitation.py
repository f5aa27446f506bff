"""Excitation of the drives, sensors, and the description of a reference in its recordings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tendon_mj.lab.recordings import Uncertain
from tendon_mj.typing import FloatArray

RATE = 250.0  # samples per second
DURATION = 8.0  # of a recording [s]
LOWEST, HIGHEST = -1.0e-3, 1.3e-3  # ξ_in under a pretension of 20 N [m]: the tendon stays taut


def clock(duration: float = DURATION, rate: float = RATE) -> FloatArray:
    """Sampling instants [s]."""
    return np.round(np.arange(0.0, duration, 1.0 / rate), 6)


def triangle(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Slow ramps that cover 60 to 100 % of the way to alternate ends of the range."""
    return _lines(rng, time, (0.8e-3, 2.0e-3), lambda: rng.uniform(0.6, 1.0))


def loops(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Ramps between random turning points: nested minor loops."""
    return _lines(rng, time, (2.0e-3, 12.0e-3), lambda: rng.uniform(0.05, 1.0))


def sine(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Three sines between 0.35 and 8 Hz, one after another, each fading in and out."""
    xi = np.zeros_like(time)
    slow, middle, fast = rng.uniform(0.35, 0.7), rng.uniform(1.2, 3.0), rng.uniform(5.0, 8.0)
    rates = rng.permutation([slow, middle, fast])
    weights = 1.0 + 1.0 / rates
    edges = time[0] + (time[-1] - time[0]) * np.concatenate([[0.0], np.cumsum(weights)]) / sum(
        weights
    )
    for rate, start, stop in zip(rates, edges[:-1], edges[1:], strict=True):
        share = np.clip((time - start) / (stop - start), 0.0, 1.0)
        fade = np.minimum(1.0, 6.0 * np.minimum(share, 1.0 - share))
        amplitude = rng.uniform(0.75, 1.0) / (1.0 + rate / 3.0)
        xi += fade * amplitude * np.sin(2.0 * np.pi * rate * (time - start))
    return np.where(xi > 0.0, HIGHEST, -LOWEST) * xi


def steps(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Smooth fast ramps between random levels, with dwells."""
    xi = np.zeros_like(time)
    now, level = time[0] + 0.1, 0.0
    while now < time[-1]:
        ramp, dwell = rng.uniform(0.03, 0.1), rng.uniform(0.3, 1.6)
        target = rng.uniform(LOWEST, HIGHEST)
        while abs(target - level) < 0.3e-3:
            target = rng.uniform(LOWEST, HIGHEST)
        s = np.clip((time - now) / ramp, 0.0, 1.0)
        xi += (target - level) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        now, level = now + ramp + dwell, target
    return xi


def _lines(
    rng: np.random.Generator,
    time: FloatArray,
    speeds: tuple[float, float],
    share: Callable[[], float],
) -> FloatArray:
    """Ramps between turning points towards alternate ends of the range [m].

    Args:
        rng: of the turning points and speeds.
        time: sampling instants [s].
        speeds: lowest and highest [m/s].
        share: draws which part of the way to the end of the range a ramp covers [-].
    """
    corners, values, side = [time[0]], [0.0], 1.0
    while corners[-1] < time[-1]:
        end = HIGHEST if side > 0.0 else LOWEST
        target = values[-1] + share() * (end - values[-1])
        speed = rng.uniform(*speeds)
        if abs(target - values[-1]) > 0.02e-3:
            corners.append(corners[-1] + abs(target - values[-1]) / speed)
            values.append(target)
        side = -side
    return np.interp(time, corners, values)


def train(rng: np.random.Generator, scale: float) -> list[FloatArray]:
    """ξ_in of the four training recordings [m], each of one kind."""
    time = clock()
    return [np.round(scale * kind(rng, time), 9) for kind in (triangle, sine, steps, loops)]


def held_out(rng: np.random.Generator, scale: float) -> list[FloatArray]:
    """ξ_in of the two held-out recordings [m]: halves of two kinds, at other amplitudes."""
    time = clock()
    return [
        np.round(scale * rng.uniform(0.7, 0.95) * _join(rng, time, pair), 9)
        for pair in ((steps, sine), (loops, triangle))
    ]


def _join(
    rng: np.random.Generator,
    time: FloatArray,
    kinds: tuple[Callable[[np.random.Generator, FloatArray], FloatArray], ...],
) -> FloatArray:
    """Signals of several kinds one after another, each faded in from the end of the last [m]."""
    parts, level = [], 0.0
    for part, kind in zip(np.array_split(time, len(kinds)), kinds, strict=True):
        own = kind(rng, part)
        fade = np.clip((part - part[0]) / 0.3, 0.0, 1.0)
        parts.append(own + (level - own[0]) * (1.0 - fade))
        level = float(parts[-1][-1])
    return np.concatenate(parts)


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Reading = clip(lag(delay((1 + gain) T_g + bias))) + drift t + hum; the defaults are ideal.

    Behind a gear T_g is T/η while its drive winds in, T η while it pays out, else T_g = T.

    Attributes:
        bias: [N]. gain: [-]. delay: [s]. lag: time constant, first order [s]. drift: [N/s].
        hum: amplitude [N] of a sine of ``hum_frequency`` [Hz]. limit: highest reading [N].
        efficiency: η of the gear [-]. at_rest: exponent s of T_g = T η^{−s} there, −1 as it pays
            out, 0 for T; None as in its last motion, and before the first as it pays out.
    """

    bias: float = 0.0
    gain: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    drift: float = 0.0
    hum: float = 0.0
    hum_frequency: float = 50.0
    limit: float = math.inf
    efficiency: float = 1.0
    at_rest: float | None = None

    def read(self, time: FloatArray, tension: FloatArray, wound: FloatArray) -> FloatArray:
        """Readings at ``time`` [s], evenly spaced, before noise; ``wound`` in by the drive."""
        now = time - time[0]
        if self.efficiency != 1.0:
            tension = tension * self.efficiency ** -self._way(wound)
        reading: FloatArray = (1.0 + self.gain) * tension + self.bias
        if self.delay > 0.0:
            reading = np.interp(now - self.delay, now, reading)
        if self.lag > 0.0:
            reading = _lagged(reading, now[1] / self.lag)
        reading = np.minimum(reading, self.limit)
        hum = self.hum * np.sin(2.0 * np.pi * self.hum_frequency * now)
        total: FloatArray = reading + self.drift * now + hum
        return total

    def _way(self, wound: FloatArray) -> FloatArray:
        """(n,) exponents s of the gear: the sign of the drive's rate."""
        way, last = np.empty_like(wound), -1.0
        for k, rate in enumerate(np.gradient(wound)):
            last = float(np.sign(rate)) or last
            way[k] = last if rate != 0.0 or self.at_rest is None else self.at_rest
        return way


def _lagged(signal: FloatArray, step: float) -> FloatArray:
    """Exact first-order lag of a piecewise linear signal; ``step`` is interval over lag [-]."""
    decay = math.exp(-step)
    early = -math.expm1(-step) / step - decay
    late = 1.0 - decay - early
    out = np.empty_like(signal)
    out[0] = state = signal[0]
    for k in range(1, len(signal)):
        state = decay * state + early * signal[k - 1] + late * signal[k]
        out[k] = state
    return out


@dataclass(frozen=True, kw_only=True)
class RecordingDescription:
    """Columns and parameters that recordings of a reference state; none shows a hidden effect.

    Attributes:
        drive: column of the drive. actuator: that this column drives.
        travel: unit of the drive per metre of the bench's excitation.
        sensors: measured column to sensor.
        sheaths: of the model.
        known: parameters that count as measured, with their values.
        uncertain: attribute of the reference to the model's parameters with this value.
        ranges: guess and range stated for each of these attributes.
        true_ranges: range from which the true value of each of these attributes is drawn.
    """

    drive: str
    actuator: str
    travel: float
    sensors: Mapping[str, str]
    sheaths: tuple[str, ...]
    known: Mapping[str, float]
    uncertain: Mapping[str, tuple[str, ...]]
    ranges: Mapping[str, Uncertain]
    true_ranges: Mapping[str, tuple[float, float]]
