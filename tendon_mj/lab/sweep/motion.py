"""A motion as a recording without measurements, sampled at every step of the model."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import find_motion
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import column_of, control_unit, ending_of, reading_unit
from tendon_mj.typing import FloatArray

_MOST_STEPS = 10_000_000  # of a rollout; its readings are in memory
_DURATION = 6.0  # of a model without a motion that ends [s]


def motion_recording(
    name: str,
    model: mujoco.MjModel,
    motion: str | None,
    duration: float | None,
    *,
    still: bool = False,
) -> Recording:
    """The drive of a model in a motion, with every sensor of one number as measured.

    Args:
        name: of the model.
        model: compiled.
        motion: see `find_motion`.
        duration: of it [s]; default: that of the motion, or 6.
        still: whether without a motion every control is 0, for a policy to set.
    """
    if duration is not None:
        _steps(duration, model)  # before anything of that length is made
    known, columns, taken = {}, {}, set[str]()
    actuators: dict[str, str | tuple[str, ...]] = {}
    if still and motion is None:
        title, time = "no motion", _steps(_DURATION if duration is None else duration, model)
    else:
        chosen = find_motion(name, model, motion, duration)
        title, known = chosen.name, dict(chosen.parameters)
        length = chosen.duration if math.isfinite(chosen.duration) else _DURATION
        time = _steps(length if duration is None else duration, model)
        controls = np.array([chosen.drive(now) for now in time]).reshape(len(time), model.nu)
        for k in range(model.nactuator):
            control = controls[:, model.actuator_ctrladr[k]]
            if control.any():
                actuator = model.actuator(k).name
                if not actuator:
                    raise InvalidValueError(f"actuator {k} moves and has no name; give it one")
                column = _column(actuator, control_unit(model, k), taken)
                columns[column], actuators[column] = control, actuator
    sensors = [(model.sensor(k).name, k) for k in range(model.nsensor) if model.sensor_dim[k] == 1]
    readings = {
        _column(f"{sensor} reading", reading_unit(model, k), taken): Measured(sensor)
        for sensor, k in sensors
        if sensor
    }
    return Recording(
        name=title,
        model=name,
        source="a motion of tendon-mj sweep",
        time=time,
        columns={**columns, **dict.fromkeys(readings, np.zeros_like(time))},
        drive=actuators,
        measured=readings,
        known=known,
    )


def _steps(length: float, model: mujoco.MjModel) -> FloatArray:
    """Times of all steps of a duration [s], two at least."""
    step = float(model.opt.timestep)
    if not 0.5 <= length / step <= _MOST_STEPS:
        raise InvalidValueError(
            f"--duration: {length:g} s is outside 1 … {_MOST_STEPS} steps of {step:g} s, the"
            " model's timestep; give another"
        )
    return np.arange(max(1, round(length / step)) + 1, dtype=np.float64) * step


def _column(name: str, unit: str, taken: set[str]) -> str:
    return column_of(name, unit if ending_of(unit) else "N", taken)  # it matters to no number
