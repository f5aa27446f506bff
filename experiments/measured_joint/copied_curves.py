"""Curves of the nearest bends, copied: linear in the bend between two of them.

All recordings have one command, so that the measured curves of two bends are a prediction for any
bend between them. Beyond them the nearest curve is copied.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.measured_joint.prediction import Predict, Series
from experiments.measured_joint.recording import COLUMNS, bend
from tendon_mj.recordings import Recording


def fit_copied_curves(train: Sequence[Recording], seed: int = 0) -> Predict:
    """Keep the curves; there is nothing to fit, and nothing random."""
    known = sorted(train, key=bend)
    angles = [bend(r) for r in known]

    def predict(recording: Recording) -> Series:
        weights = [float(np.interp(bend(recording), angles, row)) for row in np.eye(len(known))]
        return {
            column: np.sum(
                [
                    w * np.interp(recording.time, r.time, r.columns[column])
                    for w, r in zip(weights, known, strict=True)
                    if w > 0.0
                ],
                axis=0,
            )
            for column in COLUMNS
        }

    return predict
