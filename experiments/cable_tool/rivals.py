"""Predictors without sheath friction, against which the tool is judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.cable_tool.recording import ToolRecording
from tendon_mj.typing import FloatArray

SLIDING = 0.15  # travel after a reversal from which on the output slides [rad]


@dataclass(frozen=True)
class Regression:
    """Constant and load-proportional part, each with the sign of motion: x = a± T_in + b±.

    Attributes:
        closing, opening: (a, b) of either direction [-], [N m].
    """

    closing: tuple[float, float]
    opening: tuple[float, float]

    def load(self, recording: ToolRecording) -> FloatArray:
        """Load at the output, from the input side [N m]."""
        torque = recording.input_torque
        lines = [a * torque + b for a, b in (self.closing, self.opening)]
        return np.where(recording.strokes.direction < 0.0, *lines)


def fit_regression(recordings: Sequence[ToolRecording]) -> Regression:
    """Fit the four numbers where the output slides, as the transitions are none of its concern."""
    results = []
    for sense in (-1.0, 1.0):
        chosen = [sliding(r) & (r.strokes.direction == sense) for r in recordings]
        torque = np.concatenate(
            [r.input_torque[c] for r, c in zip(recordings, chosen, strict=True)]
        )
        load = np.concatenate([r.load[c] for r, c in zip(recordings, chosen, strict=True)])
        slope, offset = np.polyfit(torque, load, 1)
        results.append((float(slope), float(offset)))
    return Regression(*results)


@dataclass(frozen=True)
class SteadyLoad:
    """The load hardly changes within a recording: x = a mean(T_in) + b + c (θ − θ_mid) + d sgn θ̇.

    Attributes:
        numbers: a [-], b [N m], c [N m/rad], d [N m].
    """

    numbers: tuple[float, ...]

    def load(self, recording: ToolRecording) -> FloatArray:
        """Load at the output, from the input side [N m]."""
        result: FloatArray = _steady_columns(recording) @ np.array(self.numbers)
        return result


def fit_steady_load(recordings: Sequence[ToolRecording]) -> SteadyLoad:
    """Fit the four numbers."""
    columns = np.concatenate([_steady_columns(r) for r in recordings])
    loads = np.concatenate([r.load for r in recordings])
    return SteadyLoad(tuple(np.linalg.lstsq(columns, loads, rcond=None)[0].tolist()))


def sliding(recording: ToolRecording) -> np.ndarray:
    """Return whether the output slides at each sample: the input has travelled ``SLIDING``."""
    result: np.ndarray = recording.strokes.travel > SLIDING
    return result


def _steady_columns(recording: ToolRecording) -> FloatArray:
    strokes = recording.strokes
    mean = np.full(len(recording.time), recording.input_torque.mean())
    return np.column_stack([mean, np.ones_like(mean), strokes.excursion, strokes.direction])
