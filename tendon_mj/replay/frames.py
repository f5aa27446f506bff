"""A simulation as a row of frames: poses, and the tension along every tendon in a sheath."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.engine import segment_tensions, sheaths
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.progress import Progress

Array = NDArray[np.float64]
POSE = mujoco.mjtState.mjSTATE_PHYSICS


@dataclass(frozen=True)
class Cable:
    """The tendon of a sheath, frame by frame.

    Attributes:
        points: (frames, n+2, 3) path [m], input end first.
        tensions: (frames, n+1) of the segments between them [N].
    """

    points: Array
    tensions: Array


@dataclass(frozen=True)
class Take:
    """A simulation, frame by frame.

    Attributes:
        time: (frames,) [s].
        poses: (frames, k) states of kind ``POSE``.
        controls: (frames, nu).
        cables: by name of the sheath.
    """

    time: Array
    poses: Array
    controls: Array
    cables: dict[str, Cable]


def record_take(
    model: mujoco.MjModel,
    drive: Callable[[float], ArrayLike] | ArrayLike,
    *,
    duration: float,
    fps: float = 30.0,
    progress: Progress | None = None,
) -> Take:
    """Simulate from the reference pose, and keep what is to be seen.

    Args:
        model: to move.
        drive: time [s] → (nu,) controls; or a (steps, nu) row of them per time step, of which the
            last one holds on.
        duration: of the take [s].
        fps: frames per second [1/s].
        progress: called with what is being done, how much is done, and of how much.

    Raises:
        InvalidValueError: no duration, no frame rate, or controls of the wrong shape.
        TendonError: the simulation became unstable; the message says when.
    """
    for name, value, unit in (("duration", duration, "s"), ("fps", fps, "1/s")):
        if not (np.isfinite(value) and value > 0.0):
            raise InvalidValueError(f"{name} = {value} [{unit}] must be finite and > 0")
    control = _control(model, drive)
    data = mujoco.MjData(model)
    frames = max(1, round(duration * fps))
    poses = np.empty((frames, mujoco.mj_stateSize(model, POSE)))
    time, controls = np.arange(frames) / fps, np.empty((frames, model.nu))
    seen: dict[str, list[tuple[Array, Array]]] = {name: [] for name in sheaths(model)}
    for k in range(frames):
        while data.time < time[k] - 0.5 * model.opt.timestep:
            data.ctrl[:] = control(data.time)
            mujoco.mj_step(model, data)
        data.ctrl[:] = control(data.time)
        mujoco.mj_forward(model, data)  # the path and its tensions belong to this pose
        if data.warning.number.any() or not np.isfinite(data.qpos).all():
            raise TendonError(f"the simulation became unstable before {time[k]:.3g} s")
        mujoco.mj_getState(model, data, poses[k], POSE)
        controls[k] = data.ctrl
        for name, rows in seen.items():
            rows.append(segment_tensions(model, data, name))
        if progress:
            progress("simulate", k + 1, frames)
    cables = {
        name: Cable(np.array([p for p, _ in rows]), np.array([t for _, t in rows]))
        for name, rows in seen.items()
    }
    return Take(time, poses, controls, cables)


def _control(
    model: mujoco.MjModel, drive: Callable[[float], ArrayLike] | ArrayLike
) -> Callable[[float], ArrayLike]:
    if callable(drive):
        shape = np.shape(drive(0.0))
        if shape != (model.nu,):
            raise InvalidValueError(
                f"drive gives controls of shape {shape}, the model takes ({model.nu},)"
            )
        return drive
    rows = np.asarray(drive, float)
    if rows.ndim != 2 or rows.shape[1] != model.nu or not len(rows):
        raise InvalidValueError(
            f"drive has shape {rows.shape}, the model takes (steps, {model.nu}) controls"
        )
    step = model.opt.timestep
    return lambda time: rows[min(round(time / step), len(rows) - 1)]
