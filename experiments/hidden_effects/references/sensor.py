"""Model of a tension sensor: gain, bias, delay, lag, drift, hum and saturation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Reading = clip(lag(delay((1 + gain) T + bias))) + drift t + hum; the defaults are ideal.

    Attributes:
        bias: [N]. gain: [-]. delay: [s]. lag: time constant, first order [s]. drift: [N/s].
        hum: amplitude [N] of a sine of ``hum_frequency`` [Hz]. limit: highest reading [N].
    """

    bias: float = 0.0
    gain: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    drift: float = 0.0
    hum: float = 0.0
    hum_frequency: float = 50.0
    limit: float = math.inf

    def read(self, time: FloatArray, tension: FloatArray) -> FloatArray:
        """Readings at ``time`` [s], evenly spaced, before noise."""
        now = time - time[0]
        reading: FloatArray = (1.0 + self.gain) * tension + self.bias
        if self.delay > 0.0:
            reading = np.interp(now - self.delay, now, reading)
        if self.lag > 0.0:
            reading = _lagged(reading, now[1] / self.lag)
        reading = np.minimum(reading, self.limit)
        hum = self.hum * np.sin(2.0 * np.pi * self.hum_frequency * now)
        total: FloatArray = reading + self.drift * now + hum
        return total


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
