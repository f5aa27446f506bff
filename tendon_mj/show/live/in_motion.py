"""Controls over time that keep a model moving for as long as someone watches."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import FINGERS, find_trajectory, prepare_finger
from tendon_mj.lab.replay import Drive, default_motion, read_motion
from tendon_mj.typing import FloatArray

_JUMP = 1e-3  # from the end of a motion to its beginning that is none, over its range
_RETURN = 0.5  # from the last controls of a motion back to its first [s]


def in_motion(name: str, model: mujoco.MjModel, motion: str | None) -> tuple[mujoco.MjModel, Drive]:
    """A model ready for a motion, and its controls over time.

    Args:
        name: of the model; `finger` and `finger_spring` know motions by name.
        model: compiled; not changed.
        motion: a name, or the path of a CSV: for the finger one of joint angles or tensions, for
            any other model one with ``time_s`` and a column for each actuator that is driven, named
            like it and followed by a unit; None: the finger curls, and other models do as in
            `default_motion`.

    Returns:
        The model, which is a copy where the motion needs it, and time [s] → (nu,) controls. A
        motion that ends begins anew.

    Raises:
        UnknownNameError: the finger has no such motion, or a column is for an actuator that is not
            there.
        RecordingError: there is no such CSV, or it cannot be read.
        InvalidValueError: a motion out of reach of the finger.
    """
    if name in FINGERS:
        trajectory = find_trajectory(motion or "curl")
        adjustable, rows = prepare_finger(trajectory, model)
        if trajectory.aside:  # the object, which would hang in the air far away
            unused = adjustable.model.geom_bodyid == adjustable.model.body("object").id
            adjustable.model.geom_rgba[unused, 3] = 0.0
        return adjustable.model, repeated(rows, model.opt.timestep)
    if motion is None:
        return model, default_motion(name, model)
    drive, length = read_motion(Path(motion), model)
    times = np.arange(0.0, length, model.opt.timestep)
    if not len(times):
        raise InvalidValueError(f"{motion}: the motion is shorter than a step of the model")
    return model, repeated(np.stack([drive(time) for time in times]), model.opt.timestep)


def repeated(rows: FloatArray, step: float) -> Drive:
    """Controls that begin anew where they end, by way of a straight line if they end elsewhere.

    Args:
        rows: (steps, nu) controls.
        step: of the simulation [s].
    """
    if len(rows) and (np.abs(rows[-1] - rows[0]) > _JUMP * np.ptp(rows, axis=0)).any():
        share = np.linspace(0.0, 1.0, max(2, round(_RETURN / step)))[1:, None]
        rows = np.concatenate([rows, (1.0 - share) * rows[-1] + share * rows[0]])
    return lambda time: np.asarray(rows[round(time / step) % len(rows)])


def stands_still(model: mujoco.MjModel, drive: Drive, duration: float) -> str:
    """Why no actuator moves a model within a duration [s]; empty where one does."""
    if model.nu == 0:
        return "it has no actuator"
    times = np.arange(0.0, duration, 0.1)
    if any(np.any(drive(time)) for time in times):
        return ""
    return "the controls stay at 0"
