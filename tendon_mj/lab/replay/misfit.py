"""Misfit of a simulation: its error against the measured columns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_mj.errors import RecordingError, unknown
from tendon_mj.lab.recordings import Recording


@dataclass(frozen=True)
class Misfit:
    """Error e = simulated − measured of one column.

    Attributes:
        rmse: √(mean e²) [the column's unit].
        share_of_range: rmse over the measured column's largest less smallest value [-].
        largest: max |e| [the column's unit].
        bias: mean e [the column's unit].
    """

    rmse: float
    share_of_range: float
    largest: float
    bias: float

    @property
    def of_range(self) -> str:
        """The share of the range in words, after a comma; empty where the column is constant."""
        share = self.share_of_range
        return f", {share:.1%} of its range" if math.isfinite(share) else ""


def replay_error(measured: Recording, simulated: Recording) -> dict[str, Misfit]:
    """Misfit of every column that ``measured`` lists as measured.

    Raises:
        RecordingError: the two differ in their times, or a column is missing.
    """
    where = f"recording {simulated.name!r}"
    if not np.array_equal(measured.time, simulated.time):
        raise RecordingError(f"{where}: its times are not those of {measured.name!r}")
    misfits = {}
    for column in measured.measured:
        if column not in simulated.columns:
            raise RecordingError(f"{where}: {unknown('column', column, simulated.columns)}")
        truth = measured.columns[column]
        error = simulated.columns[column] - truth
        rmse = math.sqrt(float(np.mean(error**2)))
        span = float(np.ptp(truth))
        share = rmse / span if span > 0.0 else (0.0 if rmse == 0.0 else math.inf)
        misfits[column] = Misfit(rmse, share, float(np.abs(error).max()), float(error.mean()))
    return misfits
