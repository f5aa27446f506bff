"""Frames of a simulation, to be drawn: poses, controls, readings, and the tensions of tendons."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.plugin import ALL_OF_IT, UNDRAWN, Branch, most_bent_branch, sheaths, tension_path
from tendon_mj.typing import FloatArray

POSE = mujoco.mjtState.mjSTATE_PHYSICS
_FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
FPS = 30.0  # [1/s]
_MOST_MEMORY = 2.0  # that frames may take [GB]


@dataclass(frozen=True)
class Cable:
    """The tendon of a sheath, frame by frame."""

    points: FloatArray  # (frames, m+1, 3) path [m], input end first, see `tension_path`
    tensions: FloatArray  # (frames, m) between them [N], NaN between branches
    branch: Branch = ALL_OF_IT  # whose ends are shown
    group: int = 0  # of the tendon, by which viewers show and hide it

    @property
    def ends(self) -> tuple[int, int]:
        """Columns of the tensions at the input and the output of that branch."""
        gaps = [-1, *np.flatnonzero(np.isnan(self.tensions[0])), self.tensions.shape[1]]
        return int(gaps[self.branch.number]) + 1, int(gaps[self.branch.number + 1]) - 1

    @property
    def end_tensions(self) -> FloatArray:
        """(frames, 2) tensions at the input and the output of that branch [N]."""
        return self.tensions[:, self.ends]


@dataclass(frozen=True)
class Frames:
    """A simulation, frame by frame."""

    fps: float  # frames per second [1/s]
    time: FloatArray  # (frames,) [s]
    poses: FloatArray  # (frames, k) states of kind POSE
    controls: FloatArray  # (frames, nu)
    cables: dict[str, Cable]  # by name of the sheath
    readings: FloatArray  # (frames, nsensordata) of the sensors [SI]
    # of each frame, (k, 6): where two bodies touch [m], and the force there on the one that comes
    # later in the model [N], one row per pair of bodies. In a model with touch sensors only of the
    # bodies that they are on: the clip shows what is felt
    contacts: tuple[FloatArray, ...]

    @property
    def drawn(self) -> dict[str, Cable]:
        """Cables of tendons that have a path."""
        paths = {n: c for n, c in self.cables.items() if np.isfinite(c.points).any()}
        return {n: c for n, c in paths.items() if c.group != UNDRAWN}

    def __repr__(self) -> str:
        return f"Frames({len(self.time)} at {self.fps:g} per second, of {', '.join(self.cables)})"


class FrameRecorder:
    """Keeps frames of a simulation at 0, 1/fps, 2/fps, … [s] while something else steps it."""

    def __init__(self, fps: float = FPS) -> None:
        _check_positive("fps", fps, "1/s")
        self.fps = fps
        self._kept: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
        self._cables: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
        self._shown: dict[str, tuple[Branch, int]] = {}
        self._scratch: mujoco.MjData | None = None

    def due(self, start: float, timestep: float, steps: int) -> list[int]:
        """Steps that begin with a frame, of a run of ``steps`` from ``start`` [s] on."""
        count = max(1, round((start + steps * timestep) * self.fps))
        wanted = np.rint((np.arange(count) / self.fps - start) / timestep).astype(int)
        return [int(step) for step in wanted if step < max(1, steps)]

    def keep(self, model: mujoco.MjModel, data: mujoco.MjData, control: ArrayLike) -> None:
        """Keep a frame of the state of ``data`` under (nu,) ``control``, without changing it."""
        if data.warning.number.any() or not np.isfinite(data.qpos).all():
            raise TendonError(f"the simulation became unstable before {data.time:.3g} s")
        if self._scratch is None:
            self._scratch = mujoco.MjData(model)
            self._cables = {name: [] for name in sheaths(model)}
            for name, sheath in sheaths(model).items():
                group = int(model.tendon_group[model.tendon(sheath.tendon).id])
                self._shown[name] = most_bent_branch(model, name), group
        mujoco.mj_copyState(model, data, self._scratch, _FULL)
        self._scratch.ctrl[:] = control
        mujoco.mj_forward(model, self._scratch)  # the path and its tensions belong to this pose
        pose = np.empty(mujoco.mj_stateSize(model, POSE))
        mujoco.mj_getState(model, self._scratch, pose, POSE)
        readings = self._scratch.sensordata.copy()
        contacts = _contact_forces(model, self._scratch)
        self._kept.append((pose, self._scratch.ctrl.copy(), readings, contacts))
        for name, rows in self._cables.items():
            rows.append(tension_path(model, self._scratch, name))

    def frames(self) -> Frames:
        """All frames that were kept."""
        poses, controls, readings, contacts = zip(*self._kept, strict=True)
        cables = {}
        for name, rows in self._cables.items():
            points, tensions = np.array([p for p, _ in rows]), np.array([t for _, t in rows])
            cables[name] = Cable(points, tensions, *self._shown[name])
        return Frames(
            fps=self.fps,
            time=np.arange(len(self._kept)) / self.fps,
            poses=np.array(poses),
            controls=np.array(controls),
            readings=np.array(readings),
            contacts=contacts,
            cables=cables,
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
    pairwise = zip(middles, forces, strict=True)
    return np.array([np.concatenate(row) for row in pairwise]).reshape(-1, 6)


def check_frames(model: mujoco.MjModel, duration: float, fps: float) -> None:
    """Refuse frames of a duration [s] at ``fps`` [1/s] that do not fit into memory."""
    _check_positive("duration", duration, "s")
    _check_positive("fps", fps, "1/s")
    numbers = mujoco.mj_stateSize(model, POSE) + model.nu + model.nsensordata
    numbers += 4 * model.nwrap  # points of the tendons and tensions between them
    memory = 8e-9 * numbers * duration * fps
    if memory > _MOST_MEMORY:
        raise InvalidValueError(
            f"duration = {duration:g} [s] at fps = {fps:g} [1/s] takes {memory:.3g} GB of memory,"
            f" above {_MOST_MEMORY:g} GB; give a shorter duration or fewer fps"
        )


def _check_positive(name: str, value: float, unit: str) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InvalidValueError(f"{name} = {value} [{unit}] must be finite and > 0")
