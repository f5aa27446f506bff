"""The finger along a trajectory, by ordinary position and torque servos; motions of any model."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger.trajectories import (
    ANGLES,
    Trajectory,
    check_reach,
    find_trajectory,
    lasting,
)
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import (
    Adjustable,
    Drive,
    FrameRecorder,
    Misfit,
    ProgressShare,
    default_motion,
    read_motion,
    replay_error,
    replay_recording,
)
from tendon_mj.models import JOINTS, TENDONS, Finger, spool_angles
from tendon_mj.typing import FloatArray

_FINGERS = ("finger", "finger_spring")  # models that follow trajectories
OUT_OF_REACH = 0.5  # where the object rests on its slide for the finger to miss it [m]
_UNITS = {"angle": "rad", "force": "N", "tension": "N", "displacement": "m"}
_LEAST = 1e-3  # output tension that a ratio divides by at least [N]


class Motion(NamedTuple):
    """A motion of a model.

    Attributes:
        name: of the motion.
        drive: time [s] → (nu,) controls.
        duration: of it [s]; infinite for a default motion, which has no end.
        parameters: of the model that it needs, by name.
        hidden: bodies that are out of the way, so far that they are not shown.
    """

    name: str
    drive: Drive
    duration: float
    parameters: Mapping[str, float] = {}
    hidden: tuple[str, ...] = ()

    def prepared(self, model: mujoco.MjModel) -> mujoco.MjModel:
        """A copy of a model with these parameters, in which the hidden bodies are invisible."""
        adjustable = Adjustable(copy.copy(model))
        adjustable.set(self.parameters)
        for body in self.hidden:
            adjustable.model.geom_rgba[model.geom_bodyid == model.body(body).id, 3] = 0.0
        return adjustable.model


def find_motion(
    name: str, model: mujoco.MjModel, motion: str | None = None, duration: float | None = None
) -> Motion:
    """The motion that a command names, or the default one.

    Args:
        name: of the model.
        model: compiled.
        motion: of a finger: curl, tap, press, hold or a CSV of joint angles or tensions; default:
            curl. Of any other model a CSV with ``time_s`` and a column for every actuator that
            moves (see `read_motion`); default: `default_motion`.
        duration: of a finger's motion [s], which is cut or held at its end; default: its own.
    """
    if name not in _FINGERS:
        if motion is None:
            return Motion("default motion", default_motion(name, model), math.inf)
        return Motion(Path(motion).stem, *read_motion(Path(motion), model))
    trajectory = find_trajectory(motion or "curl")
    if duration is not None:
        trajectory = lasting(trajectory, duration)
    return _along(trajectory, model, _drive_recording(trajectory, model, Finger(), name=name))


def _along(trajectory: Trajectory, model: mujoco.MjModel, commands: Recording) -> Motion:
    rows = [(model.actuator(a).id, commands.columns[c]) for c, a in commands.driven]

    def drive(now: float) -> FloatArray:
        control = np.zeros(model.nu)
        for actuator, values in rows:
            control[actuator] = np.interp(now, commands.time, values)
        return control

    hidden = ("object",) if trajectory.aside else ()
    return Motion(trajectory.name, drive, float(trajectory.time[-1]), commands.known, hidden)


def _drive_recording(
    trajectory: Trajectory,
    model: mujoco.MjModel,
    finger: Finger,
    *,
    name: str = "finger",
    friction: float | None = None,
) -> Recording:
    """Commands of the motors for a trajectory, as a recording still without readings.

    Joint angles become spool angles by geometry alone, as for an ideal tendon; tensions become
    torques, T r, with the position servos off. Friction is not compensated.
    """
    check_reach(trajectory, finger)
    tendons = [t for t in TENDONS if t in {model.tendon(k).name for k in range(model.ntendon)}]
    columns, drive, known = _commands(trajectory, finger, tendons)
    if trajectory.aside:
        known["object.springref"] = OUT_OF_REACH
    if friction is not None:
        known |= {f"{tendon}_sheath.friction": friction for tendon in tendons}
    measured = {}
    for k in range(model.nsensor):
        sensor = model.sensor(k).name
        if model.sensor_dim[k] == 1:  # a column is one number
            measured[f"{sensor}_{_UNITS[sensor.rpartition('_')[2]]}"] = Measured(sensor)
    asked = {f"asked_{column}": values for column, values in trajectory.columns.items()}
    nothing = np.zeros_like(trajectory.time)
    return Recording(
        name=trajectory.name,
        model=name,
        source="simulated by tendon-mj simulate",
        time=trajectory.time,
        columns={**columns, **dict.fromkeys(measured, nothing), **asked},
        drive=drive,
        measured=measured,
        known=known,
    )


def _commands(
    trajectory: Trajectory, finger: Finger, tendons: list[str]
) -> tuple[dict[str, FloatArray], dict[str, str], dict[str, float]]:
    """Columns, the actuators that they drive, and the parameters that this needs."""
    columns: dict[str, FloatArray] = {}
    drive: dict[str, str] = {}
    known: dict[str, float] = {}
    if not trajectory.by_tension:
        angles = np.stack([trajectory.columns[column] for column in ANGLES], axis=-1)
        for tendon, turned in spool_angles(finger, angles).items():
            if tendon in tendons:
                columns[f"{tendon}_command_rad"] = turned
                drive[f"{tendon}_command_rad"] = f"{tendon}_angle"
        return columns, drive, known
    for column, tension in trajectory.columns.items():
        tendon = column.removesuffix("_N")
        if tendon not in tendons:
            raise InvalidValueError(
                f"trajectory {trajectory.name!r}: unknown tendon {tendon!r}; the model has"
                f" {', '.join(tendons)}"
            )
        torque = (tension - finger.pretension) * finger.spool_radius / finger.gear
        columns[f"{tendon}_command_Nm"] = torque
        drive[f"{tendon}_command_Nm"] = f"{tendon}_torque"
        known |= {f"{tendon}_angle.kp": 0.0, f"{tendon}_angle.kv": 0.0}
    return columns, drive, known


def prepare_finger(
    trajectory: Trajectory,
    model: mujoco.MjModel,
    finger: Finger | None = None,
    *,
    friction: float | None = None,
) -> tuple[Adjustable, FloatArray]:
    """A copy of a model set for a trajectory, with its data, and its (steps, nu) controls.

    For callers that step the model themselves; `simulate_finger` steps it too.
    """
    commands = _drive_recording(trajectory, model, finger or Finger(), friction=friction)
    motion = _along(trajectory, model, commands)
    adjustable = Adjustable(copy.copy(model))
    adjustable.set(motion.parameters)
    time = np.arange(0.0, motion.duration, model.opt.timestep)
    return adjustable, np.array([motion.drive(now) for now in time])


def simulate_finger(
    trajectory: Trajectory,
    model: mujoco.MjModel,
    finger: Finger | None = None,
    *,
    name: str = "finger",
    friction: float | None = None,
    progress: ProgressShare | None = None,
    recorder: FrameRecorder | None = None,
) -> Recording:
    """Follow a trajectory, and return every sensor in a recording that `replay` can run again.

    Args:
        trajectory: to follow.
        model: `finger` or `finger_spring`; not changed.
        finger: its parameters; default: those of the package's model.
        name: of the model, for the recording.
        friction: μ of every sheath in place of the model's [-].
        progress: called with the share that is done, 0 … 1.
        recorder: keeps frames of the motion, for a clip of it.

    Returns:
        Columns `asked_…` of the trajectory, `…_command_…` driven, and one for every sensor.
    """
    finger = finger or Finger()
    drive = _drive_recording(trajectory, model, finger, name=name, friction=friction)
    answer = replay_recording(drive, model, progress=progress, recorder=recorder)
    asked = {c: v for c, v in drive.columns.items() if c.startswith("asked_")}
    return dataclasses.replace(
        answer, name=drive.name, source=drive.source, columns={**answer.columns, **asked}
    )


def summarise(answer: Recording) -> dict[str, float]:
    """Largest tip force, and extremes of the flexor's T_in/T_out, of a simulated motion."""
    columns = answer.columns
    output = np.maximum(columns["flexor_output_tension_N"], _LEAST)
    ratio = columns["flexor_input_tension_N"] / output
    return {
        "tip_force_max_N": float(columns["tip_force_N"].max()),
        "flexor_input_over_output_max": float(ratio.max()),
        "flexor_input_over_output_min": float(ratio.min()),
    }


def tracking_error(answer: Recording) -> dict[str, Misfit]:
    """Misfit achieved − commanded of every joint angle or tension of a trajectory.

    A tension is commanded at the motor, so it is compared at the tendon's input, and at its output
    as well.
    """
    goals = {f"{joint}_angle_rad": f"asked_{joint}_rad" for joint in JOINTS}
    goals |= {
        f"{tendon}_{end}_tension_N": f"asked_{tendon}_N"
        for tendon in TENDONS
        for end in ("input", "output")
    }
    goals = {column: goal for column, goal in goals.items() if goal in answer.columns}
    wanted = dataclasses.replace(
        answer,
        columns={**answer.columns, **{c: answer.columns[goal] for c, goal in goals.items()}},
        measured={column: answer.measured[column] for column in goals},
    )
    return replay_error(wanted, answer)
