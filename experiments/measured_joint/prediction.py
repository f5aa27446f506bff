"""Predictions of a recording's measured columns, and their errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.measured_joint.recording import COLUMNS, degrees
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

Series = Mapping[str, FloatArray]  # measured column → (n,) at the samples
Predict = Callable[[Recording], Series]
Fit = Callable[[Sequence[Recording], int], Predict]  # of recordings, with a seed


@dataclass(frozen=True)
class Error:
    """Root mean square errors on one recording.

    Attributes:
        bend: of the sheath [deg].
        seed: of the fit.
        rms: measured column → error [its unit].
    """

    bend: int
    seed: int
    rms: Mapping[str, float]


def error(recording: Recording, series: Series, seed: int = 0) -> Error:
    """Error of a prediction over the whole recording."""
    return Error(
        degrees(recording),
        seed,
        {c: float(np.sqrt(np.mean((series[c] - recording.columns[c]) ** 2))) for c in COLUMNS},
    )
