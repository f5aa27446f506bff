"""Whiteness of residuals: whether what a model leaves of a signal looks like independent noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_mj.lab.diagnosis.before_after import BeforeAfter
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

LAGS = 40  # at most
_SHARE = 0.25  # of the samples, at most
_QUANTILE = 1.96  # of a normal distribution: 95 % of the lags of white noise lie within
_WHITE = 0.85  # share of the lags within the band; chance leaves less in fewer than 1 of 100


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Autocorrelation of a residual.

    Attributes:
        lags: (n,) [s], from one sample on.
        values: (n,) ρ(lag), 1 at lag 0 [-].
        band: 95 % of the values of white noise lie within ± this [-].
    """

    lags: FloatArray
    values: FloatArray
    band: float

    @property
    def inside(self) -> float:
        """Share of the lags whose value lies within the band."""
        return float(np.mean(np.abs(self.values) <= self.band))

    @property
    def white(self) -> bool:
        """Whether as many lags lie within the band as of white noise."""
        return self.inside >= _WHITE


def autocorrelation(time: FloatArray, residual: FloatArray) -> Autocorrelation:
    """ρ_k = Σ e_i e_{i+k} / Σ e_i², of the residual less its mean.

    Args:
        time: (n,) [s]; lags are counted in samples, and told in median intervals.
        residual: (n,).
    """
    error = residual - residual.mean()
    count = max(1, min(LAGS, int(_SHARE * error.size)))
    power = float(error @ error)
    steps = np.arange(1, count + 1)
    sums = np.array([error[:-k] @ error[k:] for k in steps])
    values = np.asarray(sums / power if power > 0.0 else np.zeros(count), np.float64)
    lags = np.asarray(steps * np.median(np.diff(time)), np.float64)
    return Autocorrelation(lags, values, _QUANTILE / float(np.sqrt(error.size)))


def residual_autocorrelations(
    row: BeforeAfter,
) -> dict[str, tuple[Autocorrelation, Autocorrelation]]:
    """Measured column → autocorrelation of its residual before and after."""

    def of(simulated: Recording, column: str) -> Autocorrelation:
        error = simulated.columns[column] - row.measured.columns[column]
        return autocorrelation(row.measured.time, error)

    return {c: (of(row.before, c), of(row.after, c)) for c in row.measured.measured}
