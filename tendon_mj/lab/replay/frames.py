"""Frames of a simulation: poses, and the tension along every tendon in a sheath."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.replay.parameters import Adjustable
from tendon_mj.plugin import segment_tensions, sheaths
from tendon_mj.typing import FloatArray

POSE = mujoco.mjtState.mjSTATE_PHYSICS
_FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
FPS = 30.0  # [1/s]
_LEAST_FPS = 0.01  # of a clip [1/s]
_MOST_MEMORY = 2.0  # that frames may take [GB]
_FRICTION = (
    "friction",
    "static_friction",
    "constant_friction",
    "stribeck_friction",
    "viscous_friction",
    "friction_gradient",
    "friction_drift",
    "direction_asymmetry",
)


@dataclass(frozen=True)
class Cable:
    """The tendon of a sheath, frame by frame.

    Attributes:
        points: (frames, n+2, 3) path [m], input end first.
        tensions: (frames, n+1) of the segments between them [N].
    """

    points: FloatArray
    tensions: FloatArray


@dataclass(frozen=True)
class Frames:
    """A simulation, frame by frame.

    Attributes:
        fps: frames per second [1/s].
        time: (frames,) [s].
        poses: (frames, k) states of kind ``POSE``.
        controls: (frames, nu).
        cables: by name of the sheath.
        readings: (frames, nsensordata) of the sensors [SI].
        contacts: of each frame, (k, 6): where two bodies touch [m], and the force there on the one
            that comes later in the model [N], one row per pair of bodies. In a model with touch
            sensors only of the bodies that they are on, as what is shown is what is felt.
    """

    fps: float
    time: FloatArray
    poses: FloatArray
    controls: FloatArray
    cables: dict[str, Cable]
    readings: FloatArray
    contacts: tuple[FloatArray, ...]


class FrameRecorder:
    """Keeps frames of a simulation at 0, 1/fps, 2/fps, … while something else steps it.

    Args:
        fps: frames per second [1/s].

    Raises:
        InvalidValueError: no frame rate.
    """

    def __init__(self, fps: float = FPS) -> None:
        _check_positive("fps", fps, "1/s")
        self.fps = fps
        self._kept: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
        self._cables: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
        self._scratch: mujoco.MjData | None = None

    def due(self, start: float, timestep: float, steps: int) -> list[int]:
        """Steps at whose beginning a frame is due, of a run of ``steps`` from ``start`` [s] on."""
        count = max(1, round((start + steps * timestep) * self.fps))
        wanted = np.rint((np.arange(count) / self.fps - start) / timestep).astype(int)
        return [int(step) for step in wanted if step < max(1, steps)]

    def keep(self, model: mujoco.MjModel, data: mujoco.MjData, control: ArrayLike) -> None:
        """Keep a frame of the state of ``data`` under (nu,) ``control``; ``data`` is not changed.

        Raises:
            TendonError: the simulation became unstable.
        """
        if data.warning.number.any() or not np.isfinite(data.qpos).all():
            raise TendonError(f"the simulation became unstable before {data.time:.3g} s")
        if self._scratch is None:
            self._scratch = mujoco.MjData(model)
            self._cables = {name: [] for name in sheaths(model)}
        state = np.empty(mujoco.mj_stateSize(model, _FULL))
        mujoco.mj_getState(model, data, state, _FULL)
        mujoco.mj_setState(model, self._scratch, state, _FULL)
        self._scratch.ctrl[:] = control
        mujoco.mj_forward(model, self._scratch)  # the path and its tensions belong to this pose
        pose = np.empty(mujoco.mj_stateSize(model, POSE))
        mujoco.mj_getState(model, self._scratch, pose, POSE)
        readings = self._scratch.sensordata.copy()
        contacts = _contact_forces(model, self._scratch)
        self._kept.append((pose, self._scratch.ctrl.copy(), readings, contacts))
        for name, rows in self._cables.items():
            rows.append(segment_tensions(model, self._scratch, name))

    def frames(self) -> Frames:
        """All frames that were kept.

        Raises:
            InvalidValueError: there is none; the recorder was given to no simulation.
        """
        if not self._kept:
            raise InvalidValueError("no frame was recorded; give the recorder to a simulation")
        poses, controls, readings, contacts = zip(*self._kept, strict=True)
        return Frames(
            fps=self.fps,
            time=np.arange(len(self._kept)) / self.fps,
            poses=np.array(poses),
            controls=np.array(controls),
            readings=np.array(readings),
            contacts=contacts,
            cables={
                name: Cable(np.array([p for p, _ in rows]), np.array([t for _, t in rows]))
                for name, rows in self._cables.items()
            },
        )


def _contact_forces(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """Point and force of every pair of bodies that touch, (k, 6); see `Frames.contacts`."""
    sites = model.sensor_objid[model.sensor_type == mujoco.mjtSensor.mjSENS_TOUCH.value]
    feeling = set(model.site_bodyid[sites].tolist())
    pairs: dict[tuple[int, int], list[FloatArray]] = {}
    wrench = np.empty(6)
    for k in range(data.ncon):
        contact = data.contact[k]
        bodies = [int(model.geom_bodyid[geom]) for geom in contact.geom if geom >= 0]
        mujoco.mj_contactForce(model, data, k, wrench)
        force = contact.frame.reshape(3, 3).T @ wrench[:3]  # on the second geom
        felt = not feeling or not feeling.isdisjoint(bodies)
        if felt and len(bodies) == 2 and wrench[0] > 0.0:
            later = force if bodies[1] >= bodies[0] else -force
            pair = min(bodies), max(bodies)
            pairs.setdefault(pair, []).append(np.concatenate([contact.pos, later, wrench[:1]]))
    rows = [np.array(points) for points in pairs.values()]
    middles = [np.average(r[:, :3], axis=0, weights=r[:, 6]) for r in rows]
    forces = [r[:, 3:6].sum(axis=0) for r in rows]
    return np.array([np.concatenate(row) for row in zip(middles, forces, strict=True)]).reshape(
        -1, 6
    )


def record_frames(
    model: mujoco.MjModel,
    drive: Callable[[float], ArrayLike] | ArrayLike,
    *,
    duration: float,
    fps: float = FPS,
    parameters: Mapping[str, float] | None = None,
    progress: Progress | None = None,
) -> Frames:
    """Simulate a model from its reference pose, and return frames of it.

    Args:
        model: to move; it is not changed.
        drive: time [s] → (nu,) controls; or a (steps, nu) row of them per time step, of which the
            last one holds on.
        duration: of the simulation [s].
        fps: frames per second [1/s].
        parameters: ``<element>.<parameter>`` to value (see `replay.parameters`).
        progress: called with what is being done, how much is done, and of how much.

    Raises:
        UnknownNameError: no such parameter.
        InvalidValueError: no duration, no frame rate, more frames than memory should hold, or
            controls of the wrong shape.
        TendonError: the simulation became unstable; the message says when.
    """
    check_frames(model, duration, fps)
    control, recorder, data = _control(model, drive), FrameRecorder(fps), mujoco.MjData(model)
    if parameters:
        adjustable = Adjustable(copy.copy(model))
        adjustable.set(parameters)
        model, data = adjustable.model, adjustable.data
    frames = max(1, round(duration * fps))
    for k in range(frames):
        while data.time < k / fps - 0.5 * model.opt.timestep:
            data.ctrl[:] = control(data.time)
            mujoco.mj_step(model, data)
        recorder.keep(model, data, control(data.time))
        if progress:
            progress("simulate", k + 1, frames)
    return recorder.frames()


def check_frames(model: mujoco.MjModel, duration: float, fps: float) -> None:
    """Refuse a number of frames that cannot be held in memory.

    Args:
        model: to be recorded.
        duration: of the simulation [s].
        fps: frames per second [1/s].

    Raises:
        InvalidValueError: it says how much memory the frames would take.
    """
    _check_positive("duration", duration, "s")
    _check_positive("fps", fps, "1/s")
    if fps < _LEAST_FPS:
        raise InvalidValueError(f"fps = {fps:g} [1/s] must be at least {_LEAST_FPS:g}")
    numbers = mujoco.mj_stateSize(model, POSE) + model.nu + model.nsensordata
    numbers += 4 * model.nwrap  # points of the tendons and tensions between them
    memory = 8e-9 * numbers * duration * fps
    if memory > _MOST_MEMORY:
        raise InvalidValueError(
            f"duration = {duration:g} [s] at fps = {fps:g} [1/s] are {duration * fps:.3g} frames, "
            f"which take {memory:.3g} GB of memory; at most {_MOST_MEMORY:g} GB are taken: ask for "
            "a shorter duration or for fewer frames"
        )


def frictionless(model: mujoco.MjModel) -> dict[str, float]:
    """Parameters for `record_frames` that take all friction from every sheath of a model."""
    adjustable = Adjustable(copy.copy(model))
    return {
        name: 0.0
        for name, value in adjustable.live.items()
        if name.rpartition(".")[2] in _FRICTION and value != 0.0
    }


def _check_positive(name: str, value: float, unit: str) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InvalidValueError(f"{name} = {value} [{unit}] must be finite and > 0")


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
