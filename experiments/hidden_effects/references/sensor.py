"""Model of a tension sensor: gear, gain, bias, delay, lag, drift, hum and saturation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_mj.typing import FloatArray


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
