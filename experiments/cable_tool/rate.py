"""Dependence on rate: friction of a faster sine against the slow one at the same load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.cable_tool.recording import ToolRecording
from experiments.cable_tool.strokes import MID_STROKE
from experiments.cable_tool.tool import Tool


@dataclass(frozen=True)
class RateRatio:
    """Friction of two recordings of one load and pose.

    Attributes:
        load_share: of full load [-].
        slow, fast: half the width of the torque loop in mid-stroke [N m].
        speeds: peak input speeds, slow and fast [rad/s].
    """

    load_share: float
    slow: float
    fast: float
    speeds: tuple[float, float]

    @property
    def change(self) -> float:
        """Share by which the faster sine's friction is larger [-]."""
        return self.fast / self.slow - 1.0


def rate_ratios(recordings: Sequence[ToolRecording]) -> list[RateRatio]:
    """Every pair of recordings of one load and pose with different rates."""
    found = []
    for slow in recordings:
        for fast in recordings:
            same = slow.pose == fast.pose and slow.load_share == fast.load_share
            if same and _speed(slow) < 0.8 * _speed(fast):
                widths = [_half_width(r) for r in (slow, fast)]
                speeds = (_speed(slow), _speed(fast))
                found.append(RateRatio(slow.load_share, widths[0], widths[1], speeds))
    return found


def _half_width(recording: ToolRecording) -> float:
    closing, opening = Tool(stiffness=0.0).mid_stroke(recording)
    return 0.5 * (closing - opening)


def _speed(recording: ToolRecording) -> float:
    middle = np.abs(recording.strokes.excursion) < MID_STROKE
    speed = np.gradient(recording.input_angle, recording.time)
    return float(np.median(np.abs(speed[middle])))
