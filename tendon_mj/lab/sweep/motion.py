"""A motion as a recording without measurements, sampled at every step of the model."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import FINGERS, drive_recording, find_trajectory, lasting
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import (
    column_of,
    control_unit,
    default_motion,
    ending_of,
    read_motion,
    reading_unit,
)
from tendon_mj.models import Finger
from tendon_mj.typing import FloatArray

_MOST_STEPS = 10_000_000  # of a rollout, whose readings are in memory
_DURATION = 6.0  # of a model without a motion of its own [s]


def motion_recording(
    name: str,
    model: mujoco.MjModel,
    motion: str | None,
    duration: float | None,
    *,
    still: bool = False,
) -> Recording:
    """What drives a model in a motion, with every sensor of one number as measured.

    Args:
        name: of the model.
        model: compiled.
        motion: of a finger: curl, tap, press, hold or a CSV; default: curl. Of any other model a
            CSV with a column for every actuator that moves; default: `default_motion`.
        duration: of it [s]; default: that of the motion, or 6.
        still: whether without a motion every control is 0, for a policy to set.

    Raises:
        UnknownNameError: no such motion, or a column for no actuator.
        InvalidValueError: a duration of no step or of too many, a motion out of reach, or an
            actuator without a name moves.
        RecordingError: the CSV cannot be read.
    """
    if duration is not None and not (math.isfinite(duration) and duration > 0.0):
        raise InvalidValueError(f"duration = {duration:g} [s] must be finite and > 0")
    if duration is not None:
        _number_of_steps(duration, model)  # before anything of that length is made
    if still and motion is None:
        time = _steps(_DURATION if duration is None else duration, model)
        return _recording("no motion", name, model, time, {}, {})
    if name in FINGERS:
        trajectory = find_trajectory(motion or "curl")
        if duration is not None:
            trajectory = lasting(trajectory, duration)
        driven = drive_recording(trajectory, model, Finger(), name=name)
        time = _steps(float(trajectory.time[-1]), model)
        columns = {c: np.interp(time, driven.time, driven.columns[c]) for c in driven.drive}
        return dataclasses.replace(
            _recording(trajectory.name, name, model, time, columns, driven.drive),
            known=driven.known,
        )
    if motion is None:
        drive, length = default_motion(name, model), _DURATION
    else:
        drive, length = read_motion(Path(motion), model)
    time = _steps(length if duration is None else duration, model)
    controls = np.array([drive(now) for now in time]).reshape(len(time), model.nu)
    columns, taken = {}, set[str]()
    actuators: dict[str, str | tuple[str, ...]] = {}
    for k in range(model.nactuator):
        control = controls[:, model.actuator_ctrladr[k]]
        if control.any():
            actuator = model.actuator(k).name
            if not actuator:
                raise InvalidValueError(f"actuator {k} moves and has no name; give it one")
            column = _column(actuator, control_unit(model, k), taken)
            columns[column], actuators[column] = control, actuator
    return _recording(
        Path(motion).stem if motion else "default motion", name, model, time, columns, actuators
    )


def _recording(
    motion: str,
    name: str,
    model: mujoco.MjModel,
    time: FloatArray,
    driven: Mapping[str, FloatArray],
    actuators: Mapping[str, str | tuple[str, ...]],
) -> Recording:
    """A motion beside what each sensor of one number would read, which is nothing yet."""
    sensors: dict[str, str] = {}
    taken = set(driven)
    for k in range(model.nsensor):
        sensor = model.sensor(k).name
        if model.sensor_dim[k] == 1 and sensor:
            sensors[_column(f"{sensor} reading", reading_unit(model, k), taken)] = sensor
    return Recording(
        name=motion,
        model=name,
        source="a motion of tendon-mj sweep",
        time=time,
        columns={**driven, **dict.fromkeys(sensors.keys() - driven.keys(), np.zeros_like(time))},
        drive=actuators,
        measured={c: Measured(s) for c, s in sensors.items() if c not in driven},
    )


def _steps(length: float, model: mujoco.MjModel) -> FloatArray:
    """Times of all steps of a duration [s], two at least."""
    step = float(model.opt.timestep)
    return np.arange(_number_of_steps(length, model) + 1, dtype=np.float64) * step


def _number_of_steps(length: float, model: mujoco.MjModel) -> int:
    step = float(model.opt.timestep)
    if length / step > _MOST_STEPS:
        raise InvalidValueError(
            f"a motion of {length:g} s has {length / step:.3g} steps of {step:g} s; a rollout has"
            f" at most {_MOST_STEPS}, so give a shorter --duration"
        )
    number = round(length / step)
    if number < 1:
        raise InvalidValueError(
            f"a motion of {length:g} s has no step of {step:g} s, the model's timestep; give a"
            " longer --duration"
        )
    return number


def _column(name: str, unit: str, taken: set[str]) -> str:
    return column_of(name, unit if ending_of(unit) else "N", taken)  # it matters to no number
