"""Leave-one-load-out, leave-one-pose-out and leave-the-faster-sine-out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.cable_tool.candidates import Candidate, Predicts
from experiments.cable_tool.recording import ToolRecording
from experiments.cable_tool.rivals import sliding
from experiments.cable_tool.tool import Tool
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.typing import FloatArray

LEFT_OUT: dict[str, Callable[[ToolRecording], str]] = {
    "load": lambda r: f"{r.load_share:.0%}",
    "pose": lambda r: r.pose,
    "rate": lambda r: r.rate,
}


@dataclass(frozen=True)
class HeldOut:
    """Errors on one recording that had no part in the fit; all root mean squares.

    Attributes:
        name, group: of the recording.
        left_out: value that was left out of the fit, such as ``80%``.
        torque: error of the load over the whole recording [N m].
        torque_sliding: the same where the output slides [N m].
        torque_variation: the same with its mean apart [N m].
        angle: error of the output angle, its mean apart [rad]; None for a model without angle.
        angle_zeroed: the same with the zero from the recordings of this pose that were fitted
            [rad]; None if there are none.
    """

    name: str
    group: str
    left_out: str
    torque: float
    torque_sliding: float
    torque_variation: float
    angle: float | None
    angle_zeroed: float | None


def cross_validate(
    candidate: Candidate,
    recordings: Sequence[ToolRecording],
    left_out: str,
    progress: Progress = silent,
) -> list[HeldOut]:
    """Fit without each load, pose or rate in turn, and predict the recordings with it.

    Args:
        candidate: that is fitted anew for every fold.
        recordings: all of them.
        left_out: a name in `LEFT_OUT`.
        progress: called with the stage, the number done and the total.

    Raises:
        InvalidValueError: fewer than two values to leave out.
    """
    value = LEFT_OUT[left_out]
    folds = sorted({value(r) for r in recordings})
    if left_out == "rate":
        folds = [fold for fold in folds if fold.startswith("f")]
    elif len(folds) < 2:
        raise InvalidValueError(f"leaving out one {left_out} takes two; the data have {folds}")
    errors = []
    for done, fold in enumerate(folds):
        progress(f"{candidate.name}: {left_out}", done, len(folds))
        known = [r for r in recordings if value(r) != fold]
        result = candidate.fit(known)
        errors += [
            _held_out(result, recording, known, fold)
            for recording in recordings
            if value(recording) == fold
        ]
    progress(f"{candidate.name}: {left_out}", len(folds), len(folds))
    return errors


def root_mean_square(error: FloatArray) -> float:
    """Root mean square of an error, in its unit."""
    return float(np.sqrt(np.mean(error**2)))


def _held_out(
    predicts: Predicts, recording: ToolRecording, known: Sequence[ToolRecording], fold: str
) -> HeldOut:
    error = predicts.load(recording) - recording.load
    angle = zeroed = None
    if isinstance(predicts, Tool):
        off = predicts.angle(recording) - recording.output_angle
        angle = float(np.std(off))
        same = [r for r in known if r.pose == recording.pose]
        if same:
            zero = np.mean([np.mean(predicts.angle(r) - r.output_angle) for r in same])
            zeroed = root_mean_square(off - float(zero))
    return HeldOut(
        recording.name,
        recording.group,
        fold,
        root_mean_square(error),
        root_mean_square(error[sliding(recording)]),
        float(np.std(error)),
        angle,
        zeroed,
    )
