"""History of a drive as numbers per sample: what a model without physics may know of the past."""

from __future__ import annotations

import numpy as np

from tendon_mj.typing import FloatArray

LAGS = (0.004, 0.01, 0.02, 0.04, 0.08, 0.16, 0.3, 0.6, 1.0, 2.0)  # s
WIDTHS = np.linspace(0.02, 0.6, 12)  # of plays, over the range of the drive [-]
FAST = 0.3  # speed at which the sign of the motion is told, in ranges of the drive per second


def drive_history(time: FloatArray, drive: FloatArray, span: float) -> FloatArray:
    """(samples, features): the drive, its rate, its past, and what plays make of it.

    Args:
        time: samples [s].
        drive: at these.
        span: range of the drive in all recordings.
    """
    rate = np.gradient(drive, time)
    past = [np.interp(time - lag, time, drive) - drive for lag in LAGS]
    plays = [_play(drive, width * span) for width in WIDTHS]
    return np.column_stack([drive, rate, np.tanh(rate / (FAST * span)), *past, *plays])


def _play(drive: FloatArray, width: float) -> FloatArray:
    """Play operator from 0: w follows the drive u where it would else be off by more than a width.

    w_k = min(max(w_{k-1}, u_k − r), u_k + r).
    """
    out = np.empty_like(drive)
    state = 0.0
    for k, value in enumerate(drive):
        out[k] = state = min(max(state, value - width), value + width)
    return out
