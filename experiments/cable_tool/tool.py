"""The tool's eight numbers, and the load and output angle that they predict of a recording."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.cable_tool.recording import MID_STROKE, ToolRecording
from experiments.cable_tool.transmission import predict_load
from tendon_mj.errors import RecordingError
from tendon_mj.typing import FloatArray


@dataclass(frozen=True)
class Tool:
    """Numbers of the tool, the same in every recording.

    Attributes:
        friction_exponent: λ of the straight wrist, load-proportional (sheath) friction [-].
        wrist_friction: addition of a pitched wrist to λ [1/rad].
        closing_offset: b_c, input torque when closing without load: constant friction and zero of
            the cells [N m].
        load_difference: by how much the load is larger when closing than when opening, from the
            friction of the brake itself; None if `opening_offset` takes its place [N m].
        stiffness: k, elastic torque at the input over its angle [N m/rad].
        take_up: w, travel after a reversal over which the cable comes to slide [rad].
        angle_ratio: ρ, output over input angle without torque [-].
        compliance: C of the cable, output angle over what it carries [rad/(N m)].
        opening_offset: b_o of all recordings; None takes it from the input side of each [N m].
    """

    friction_exponent: float = 0.35
    wrist_friction: float = 0.0
    closing_offset: float = 0.025
    load_difference: float | None = 0.005
    stiffness: float = 0.02
    take_up: float = 0.2
    angle_ratio: float = 1.0
    compliance: float = 0.0
    opening_offset: float | None = None

    def exponent(self, recording: ToolRecording) -> float:
        """λ in the wrist pose of a recording [-]."""
        return self.friction_exponent + self.wrist_friction * recording.pitch

    def opening(self, recording: ToolRecording) -> float:
        """Input torque when opening without load, b_o [N m].

        It differs between wrist poses and sessions, and nothing but the recording tells it. Its own
        input side does: the brake asks for the same load in either direction, but for
        ``load_difference`` D. With τ_c and τ_o the medians in mid-stroke,
        b_o = τ_o − [(τ_c − b_c) e^{−λ} − D] e^{−λ}. The measured load has no part in it.

        Raises:
            RecordingError: a recording that does not pass mid-stroke both ways.
        """
        if self.opening_offset is not None:
            return self.opening_offset
        assert self.load_difference is not None, "either of the two is given"
        closing, opening = self.mid_stroke(recording)
        ratio = math.exp(-self.exponent(recording))
        load = (closing - self.closing_offset) * ratio
        return opening - (load - self.load_difference) * ratio

    def mid_stroke(self, recording: ToolRecording) -> tuple[float, float]:
        """Medians of T_in + k (θ − θ_mid) in mid-stroke, closing and opening [N m]."""
        strokes, torque = recording.strokes, recording.input_torque
        closing, opening = (
            torque[stroke] + self.stiffness * strokes.excursion[stroke] for stroke in strokes.middle
        )
        if not (closing.size and opening.size):
            raise RecordingError(
                f"{recording.name} does not pass the middle of its range both ways"
            )
        return float(np.median(closing)), float(np.median(opening))

    def load(self, recording: ToolRecording) -> FloatArray:
        """Load at the output, from the input side [N m]."""
        return predict_load(
            recording,
            self.exponent(recording),
            self.closing_offset,
            self.opening(recording),
            self.stiffness,
            self.take_up,
        )

    def angle(self, recording: ToolRecording) -> FloatArray:
        """Output angle but for its zero, which no input tells [rad].

        θ_out = −ρ θ_in − C × `carried`: what the cable carries stretches it.
        """
        return -self.angle_ratio * recording.input_angle - self.compliance * self.carried(recording)

    def carried(self, recording: ToolRecording) -> FloatArray:
        """Torque that stretches the cable [N m]: x + ½ f (b_c − b_o)/2.

        Constant friction acts all along the cable, whose mean so bears half of it. With the
        capstan's part counted likewise, (T_in + x)/2, the output angle is predicted worse: that
        part acts where the cable bends, on the input's side of what yields. f, the share of the
        friction that opposes closing, is 1 on the line of closing and −1 on that of opening.
        """
        load = self.load(recording)
        drive = recording.input_torque + self.stiffness * recording.strokes.excursion
        ratio = math.exp(self.exponent(recording))
        closing, opening = (
            load * ratio + self.closing_offset,
            load / ratio + self.opening(recording),
        )
        share = np.clip(2.0 * (drive - opening) / (closing - opening) - 1.0, -1.0, 1.0)
        result: FloatArray = load + 0.25 * share * (self.closing_offset - self.opening(recording))
        return result

    def replaced(self, numbers: Mapping[str, float | None]) -> Tool:
        """The same tool with other numbers, by their names."""
        given: dict[str, Any] = dict(numbers)
        return dataclasses.replace(self, **given)


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
    results = []
    for slow in recordings:
        for fast in recordings:
            same = slow.pose == fast.pose and slow.load_share == fast.load_share
            if same and _speed(slow) < 0.8 * _speed(fast):
                widths = [_half_width(r) for r in (slow, fast)]
                speeds = (_speed(slow), _speed(fast))
                results.append(RateRatio(slow.load_share, widths[0], widths[1], speeds))
    return results


def _half_width(recording: ToolRecording) -> float:
    closing, opening = Tool(stiffness=0.0).mid_stroke(recording)
    return 0.5 * (closing - opening)


def _speed(recording: ToolRecording) -> float:
    middle = np.abs(recording.strokes.excursion) < MID_STROKE
    speed = np.gradient(recording.input_angle, recording.time)
    return float(np.median(np.abs(speed[middle])))
