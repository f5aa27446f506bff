"""Curves of the nearest bends, copied: linear in the bend between two of them.

All recordings have one command, so that the measured curves of two bends are a prediction for any
bend between them. Beyond them the nearest curve is copied, or the line through the last two
continued.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.measured_joint.prediction import Predict, Series
from experiments.measured_joint.recording import COLUMNS, bend
from tendon_mj.lab.recordings import Recording


def fit_copied_curves(train: Sequence[Recording], seed: int = 0) -> Predict:
    """Keep the curves; there is nothing to fit, and nothing random."""
    known = sorted(train, key=bend)
    angles = [bend(r) for r in known]

    def predict(recording: Recording) -> Series:
        weights = [float(np.interp(bend(recording), angles, row)) for row in np.eye(len(known))]
        return _sum(recording, known, weights)

    return predict


def fit_continued_curves(train: Sequence[Recording], seed: int = 0) -> Predict:
    """The same, with the line through the last two curves going on beyond them."""
    known = sorted(train, key=bend)

    def predict(recording: Recording) -> Series:
        angle = bend(recording)
        above = next((k for k, r in enumerate(known) if bend(r) >= angle), len(known) - 1)
        first, second = known[max(above, 1) - 1], known[max(above, 1)]
        share = (angle - bend(first)) / (bend(second) - bend(first))
        return _sum(recording, [first, second], [1.0 - share, share])

    return predict


def _sum(recording: Recording, known: Sequence[Recording], weights: Sequence[float]) -> Series:
    """Weighted sum of measured curves, at the times of a recording."""
    return {
        column: np.sum(
            [
                weight * np.interp(recording.time, r.time, r.columns[column])
                for weight, r in zip(weights, known, strict=True)
            ],
            axis=0,
        )
        for column in COLUMNS
    }
