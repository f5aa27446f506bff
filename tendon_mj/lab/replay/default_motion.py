"""Default motion of a model, for those who give no controls."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError, UnknownNameError
from tendon_mj.lab.recordings import TIME, UNITS, in_si, read_columns, si_name
from tendon_mj.lab.replay.units import column_unit, control_unit, name_in

Drive = Callable[[float], NDArray[np.float64]]

# actuator -> amplitude in its own unit
_NAMED = {"bench": {"reel": 0.002}, "joint": {"command": np.deg2rad(60.0)}}
_REEL = 0.001  # of a reel without a control range [m]
_ANY = 1.0  # of another actuator without a control range [its own unit]
_SHARE = 0.8  # of a control range
_PERIOD = 3.0  # [s]
_EASE = 1.0  # from 0 to the middle of a control range [s]


def default_motion(name: str, model: mujoco.MjModel) -> Drive:
    """Slow sine for every actuator, as a function of time [s] to the (nu,) controls.

    `bench` winds its reel ±2 mm, `joint` follows a command of ±60°. On any other model every
    actuator goes through most of its control range; a reel without one moves ±1 mm, and another
    actuator without one goes through ±1.

    Args:
        name: of the model.
        model: compiled.
    """
    centre, amplitude = np.zeros(model.nu), np.zeros(model.nu)
    actuators = [model.actuator(k).name for k in range(model.nu)]
    named = _NAMED.get(name, {})
    if named and named.keys() <= set(actuators):
        for actuator, size in named.items():
            amplitude[actuators.index(actuator)] = size
    else:
        centre, amplitude = _within_ranges(model)

    def drive(time: float) -> NDArray[np.float64]:
        grown = min(time / _EASE, 1.0)
        share = grown * grown * (3.0 - 2.0 * grown)
        return np.asarray(share * centre + amplitude * np.sin(2.0 * np.pi * time / _PERIOD))

    return drive


def read_motion(path: Path, model: mujoco.MjModel) -> tuple[Drive, float]:
    """Controls of a model from a CSV, and how long they last [s].

    Args:
        path: of a CSV with `time_s` and one column per actuator that moves, named as it is and
            with its unit: `command_rad`. Where the kind of actuator does not say what its control
            is, as a muscle's, any unit will do.
        model: whose actuators are meant; those without a column stay at 0.

    Raises:
        RecordingError: the file cannot be read, a column is in another unit than the actuator's
            control, or two are of one actuator.
        UnknownNameError: a column names no actuator.
    """
    if not path.is_file():
        columns = ", ".join(f"{model.actuator(k).name}_…" for k in range(min(model.nu, 3)))
        raise RecordingError(
            f"--motion {path}: no such file. Motions with a name, such as curl, are the finger's;"
            " that of another model is a CSV with time_s and a column for each actuator that moves,"
            f" its unit at the end: {columns}"
        )
    actuators = [model.actuator(k).name for k in range(model.nu)]
    in_file = read_columns(path, elements=actuators).columns
    written = {si_name(column)[0]: column for column in in_file}
    table = in_si(in_file, str(path))
    time = table.pop(TIME)
    places: list[int] = []
    for column in table:
        name, here = column[: -len(_unit_ending(column))], f"{path}, column {written[column]!r}"
        if name not in actuators:
            raise UnknownNameError("actuator", name, actuators, here)
        place = actuators.index(name)
        unit = control_unit(model, place)
        if unit != column_unit(column) and name_in(unit, column):
            raise RecordingError(
                f"{here}: the control of {name!r} is in [{unit}]; the column would be"
                f" {name_in(unit, column)!r}"
            )
        if place in places:
            raise RecordingError(f"{here}: another column moves {name!r}, too; leave one out")
        places.append(place)

    def drive(now: float) -> NDArray[np.float64]:
        control = np.zeros(model.nu)
        control[places] = [np.interp(now, time - time[0], v) for v in table.values()]
        return control

    return drive, float(time[-1] - time[0])


def _unit_ending(column: str) -> str:
    return max((ending for ending in UNITS if column.endswith(ending)), key=len)


def _within_ranges(model: mujoco.MjModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    limited = model.actuator_ctrllimited.astype(bool)
    low, high = model.actuator_ctrlrange.T
    reel = np.where(model.actuator_plugin >= 0, _REEL, _ANY)
    amplitude = np.where(limited, 0.5 * _SHARE * (high - low), reel)
    return np.where(limited, 0.5 * (low + high), 0.0), amplitude
