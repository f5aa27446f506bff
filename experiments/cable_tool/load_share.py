"""Friction that grows with the load, by wrist pose: λ, radius ratio, and the constants.

In mid-stroke, T_in = a± x + b± by direction. A capstan gives a₋ = ϱ e^{+λ} when closing and
a₊ = ϱ e^{−λ} when opening, with ϱ the ratio of the spools' radii: λ = ½ ln(a₋/a₊), ϱ = √(a₋ a₊).
No model of the transitions and no fit of the tool has a part in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.cable_tool.recording import MID_STROKE, ToolRecording
from tendon_mj.typing import FloatArray

_RESAMPLES = 400
_QUANTILES = (0.025, 0.975)


@dataclass(frozen=True)
class LoadShare:
    """Friction of one wrist pose.

    Attributes:
        pose: as the files name it.
        exponent, exponent_interval: λ and its 95 % interval, strokes resampled [-].
        radius_ratio: ϱ [-].
        constant_friction: (b₋ − b₊)/2 [N m].
        zero: (b₋ + b₊)/2 [N m].
        residual: of the two lines, root mean square [N m].
    """

    pose: str
    exponent: float
    exponent_interval: tuple[float, float]
    radius_ratio: float
    constant_friction: float
    zero: float
    residual: float


@dataclass(frozen=True)
class _Strokes:
    """Means in mid-stroke of every stroke in one direction: load and input torque [N m]."""

    load: FloatArray
    torque: FloatArray

    def line(self, chosen: np.ndarray) -> tuple[float, float]:
        """Slope [-] and offset [N m] of T_in over the load."""
        slope, offset = np.polyfit(self.load[chosen], self.torque[chosen], 1)
        return float(slope), float(offset)


def load_share(recordings: Sequence[ToolRecording], pose: str) -> LoadShare:
    """Friction of the recordings in one wrist pose; they need two loads."""
    mine = [r for r in recordings if r.pose == pose]
    both = [_mid_strokes(mine, sense) for sense in (-1.0, 1.0)]
    everything = [np.arange(len(s.load)) for s in both]
    lines = [s.line(c) for s, c in zip(both, everything, strict=True)]
    (up, up_offset), (down, down_offset) = lines
    errors = [
        s.torque - slope * s.load - offset for s, (slope, offset) in zip(both, lines, strict=True)
    ]
    return LoadShare(
        pose,
        0.5 * math.log(up / down),
        _interval(both),
        math.sqrt(up * down),
        0.5 * (up_offset - down_offset),
        0.5 * (up_offset + down_offset),
        float(np.sqrt(np.mean(np.concatenate(errors) ** 2))),
    )


def _interval(both: Sequence[_Strokes]) -> tuple[float, float]:
    rng = np.random.default_rng(0)
    results = []
    for _ in range(_RESAMPLES):
        slopes = []
        for strokes in both:
            chosen = rng.integers(len(strokes.load), size=len(strokes.load))
            if np.ptp(strokes.load[chosen]) < 0.5 * np.ptp(strokes.load):
                break  # one load alone has no slope
            slopes.append(strokes.line(chosen)[0])
        if len(slopes) == 2 and min(slopes) > 0.0:
            results.append(0.5 * math.log(slopes[0] / slopes[1]))
    low, high = np.quantile(results, _QUANTILES)
    return float(low), float(high)


def _mid_strokes(recordings: Sequence[ToolRecording], sense: float) -> _Strokes:
    loads, torques = [], []
    for recording in recordings:
        strokes = recording.strokes
        middle = np.abs(strokes.excursion) < MID_STROKE
        chosen = np.flatnonzero(
            middle & (strokes.direction == sense) & (strokes.travel > MID_STROKE)
        )
        for stroke in np.split(chosen, np.flatnonzero(np.diff(chosen) > 1) + 1):
            if len(stroke) and np.ptp(strokes.excursion[stroke]) > MID_STROKE:
                loads.append(np.median(recording.load[stroke]))
                torques.append(np.median(recording.input_torque[stroke]))
    return _Strokes(np.array(loads), np.array(torques))
