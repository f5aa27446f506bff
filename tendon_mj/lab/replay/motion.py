"""Motions of models, by default or from a CSV, and frames of them: poses, tensions of tendons."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.errors import InvalidValueError, RecordingError, TendonError, UnknownNameError
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.recordings import in_si, read_columns
from tendon_mj.lab.replay.parameters import Adjustable
from tendon_mj.lab.replay.units import control_unit
from tendon_mj.lab.units import TIME, column_unit, name_in, si_name, unit_ending
from tendon_mj.plugin import ALL_OF_IT, Branch, most_bent_branch, sheaths, tension_path
from tendon_mj.typing import FloatArray

Drive = Callable[[float], FloatArray]

POSE = mujoco.mjtState.mjSTATE_PHYSICS
_FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS
_FPS = 30.0  # [1/s]
_MOST_MEMORY = 2.0  # that frames may take [GB]
_FRICTION = (
    *("friction", "static_friction", "constant_friction", "stribeck_friction"),
    *("viscous_friction", "friction_gradient", "friction_drift", "direction_asymmetry"),
)
# actuator -> amplitude of its default motion in its own unit
_NAMED = {"bench": {"reel": 0.002}, "joint": {"command": np.deg2rad(60.0)}}
_REEL = 0.001  # of a reel without a control range [m]
_ANY = 1.0  # of another actuator without a control range [its own unit]
_SHARE = 0.8  # of a control range
_PERIOD = 3.0  # of an actuator [s]
_FILTERS = [
    getattr(mujoco.mjtDyn, f"mjDYN_{kind}").value
    for kind in ("INTEGRATOR", "FILTER", "FILTEREXACT")
]
_NO_BIAS, _AFFINE_BIAS = (mujoco.mjtBias.mjBIAS_NONE.value, mujoco.mjtBias.mjBIAS_AFFINE.value)
_FIXED_GAIN, _AFFINE_GAIN = (mujoco.mjtGain.mjGAIN_FIXED.value, mujoco.mjtGain.mjGAIN_AFFINE.value)
_CYCLE = 12.0  # of all actuators at most [s]; of more than four the next begins earlier


def resting(model: mujoco.MjModel) -> mujoco.MjData:
    """Data at rest: the first keyframe, else `qpos0`, with controls to begin with.

    Without a keyframe that has controls these are the ones under which actuators have no force
    there, as near as their ranges allow: a position servo's is where it is. A muscle rests at 0.
    """
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
        if data.ctrl.any():
            return data
    mujoco.mj_fwdPosition(model, data)
    low, high = control_limits(model, np.inf)
    slope, offset = _force_at(model, data.actuator_length)
    free = np.divide(-offset, slope, out=np.zeros(model.nu), where=np.isfinite(offset / slope))
    data.ctrl[:] = np.clip(free, low, high)
    for k in np.flatnonzero(np.isin(model.actuator_dyntype, _FILTERS)):
        data.act[model.actuator_actadr[k]] = free[k]
    integrates = model.actuator_dyntype == mujoco.mjtDyn.mjDYN_INTEGRATOR.value
    data.ctrl[integrates] = np.clip(0.0, low, high)[integrates]
    return data


def _force_at(model: mujoco.MjModel, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(nu,) slope and offset of each actuator's force over its control, at rest at a length.

    They are NaN for an actuator whose force is not a polynomial, such as a muscle.
    """
    length = length[: model.nu]
    gain, bias = (
        prm[:, 0] + np.where(kind == affine, prm[:, 1] * length, 0.0)
        for prm, kind, affine in (
            (model.actuator_gainprm, model.actuator_gaintype, _AFFINE_GAIN),
            (model.actuator_biasprm, model.actuator_biastype, _AFFINE_BIAS),
        )
    )
    bias = np.where(model.actuator_biastype == _AFFINE_BIAS, bias, 0.0)
    linear = np.isin(model.actuator_gaintype, (_FIXED_GAIN, _AFFINE_GAIN))
    linear &= np.isin(model.actuator_biastype, (_NO_BIAS, _AFFINE_BIAS)) & (gain != 0.0)
    return np.where(linear, gain, np.nan), np.where(linear, bias, np.nan)


def pullers(model: mujoco.MjModel, tendons: Collection[str] | None = None) -> NDArray[np.bool_]:
    """(nu,) whether an actuator acts on one of these tendons, by default any that has a sheath."""
    sheathed = {sheath.tendon for sheath in sheaths(model).values()}
    ids = [model.tendon(name).id for name in (sheathed if tendons is None else tendons)]
    on_tendon = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON.value
    return np.asarray(on_tendon & np.isin(model.actuator_trnid[:, 0], ids))


def default_motion(
    name: str, model: mujoco.MjModel, tendons: Collection[str] | None = None
) -> Drive:
    """One actuator after the other moves slowly, as a function of time [s] to the (nu,) controls.

    `bench` winds its reel ±2 mm, `joint` follows a command of ±60°. On any other model every
    actuator goes through most of its control range and then rests as in `resting`; a reel without
    a range moves ±1 mm, and another actuator without one goes through ±1. The actuator of a tendon
    in a sheath only pulls. If any acts on one of the given ``tendons``, the others rest.
    """
    start = resting(model)
    low, high = control_limits(model, 1.0 / _SHARE)
    rest = np.clip(start.ctrl, low, high)
    up, down = _SHARE * (high - rest), _SHARE * (low - rest)
    slope = model.actuator_gear[:, 0] * _force_at(model, start.actuator_length)[0]
    one_way = pullers(model) & (model.actuator_plugin < 0)
    up = np.where(one_way & (slope > 0.0) & (down < 0.0), 0.0, up)
    down = np.where(one_way & (slope < 0.0) & (up > 0.0), 0.0, down)
    moving = _moving(model, tendons)
    up, down = np.where(moving, up, 0.0), np.where(moving, down, 0.0)
    count = int(moving.sum())
    starts = (np.cumsum(moving) - 1) * min(_PERIOD, (_CYCLE - _PERIOD) / max(count - 1, 1))
    actuators = [model.actuator(k).name for k in range(model.nu)]
    named = _NAMED.get(name, {})
    if named and named.keys() <= set(actuators):
        rest, up, down, starts = np.zeros((4, model.nu))
        for actuator, size in named.items():
            k = actuators.index(actuator)
            up[k], down[k] = size, -size
    cycle = _PERIOD + starts.max(initial=0.0)

    def drive(time: float) -> FloatArray:
        turn = np.minimum(np.maximum(time - starts, 0.0) % cycle / _PERIOD, 1.0)
        there_and_back, wave = np.sin(np.pi * turn) ** 2, np.sin(2.0 * np.pi * turn)
        one_sided = np.where(up > 0.0, up, down) * there_and_back
        both_sided = np.where(wave > 0.0, up, -down) * wave
        return np.asarray(rest + np.where(up * down < 0.0, both_sided, one_sided))

    return drive


def _moving(model: mujoco.MjModel, tendons: Collection[str] | None) -> NDArray[np.bool_]:
    """(nu,) whether an actuator moves in a default motion."""
    chosen = pullers(model, tendons)
    return chosen if tendons is not None and chosen.any() else np.ones(model.nu, bool)


def without_range(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """(nu,) whether a control has no range, neither `ctrlrange` nor a muscle's from 0 to 1."""
    is_muscle = model.actuator_dyntype == mujoco.mjtDyn.mjDYN_MUSCLE.value
    return np.asarray(~(model.actuator_ctrllimited.astype(bool) | is_muscle))


def control_limits(model: mujoco.MjModel, wider: float = 5.0) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (nu,) controls: the control range, or several times ±1 mm or ±1.

    Without a range a muscle's is 0 to 1, to which MuJoCo clips it.
    """
    wide = wider * np.where(model.actuator_plugin >= 0, _REEL, _ANY)
    limited, free = model.actuator_ctrllimited.astype(bool), without_range(model)
    low, high = np.where(limited, model.actuator_ctrlrange.T, [[0.0], [1.0]])
    return np.where(free, -wide, low), np.where(free, wide, high)


def demonstration_time(model: mujoco.MjModel, tendons: Collection[str] | None = None) -> float:
    """Time in which every actuator has its turn in a default motion [s], and at least 6 s."""
    return float(max(2.0 * _PERIOD, min(_PERIOD * _moving(model, tendons).sum(), _CYCLE)))


def read_motion(path: Path, model: mujoco.MjModel) -> tuple[Drive, float]:
    """Controls of a model from a CSV, and how long they last [s].

    It has `time_s` and one column per actuator that moves, named as it is and with its unit:
    `command_rad`. Any unit will do where the kind of actuator does not define it, as a muscle's.
    Actuators without a column stay as in `resting`.
    """
    if not path.is_file():
        columns = ", ".join(f"{model.actuator(k).name}_…" for k in range(min(model.nu, 3)))
        raise RecordingError(
            f"--motion {path}: no such file. Motions with a name, such as curl, are the finger's;"
            " of another model it is a CSV with time_s and a column for each actuator that moves,"
            f" its unit at the end: {columns}"
        )
    actuators = [model.actuator(k).name for k in range(model.nu)]
    in_file = read_columns(path, elements=actuators).columns
    written = {si_name(column)[0]: column for column in in_file}
    table = in_si(in_file, str(path))
    time = table.pop(TIME)
    places: list[int] = []
    for column in table:
        name, here = column.removesuffix(unit_ending(column)), f"{path}, column {written[column]!r}"
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

    rest = resting(model).ctrl.copy()

    def drive(now: float) -> FloatArray:
        control = rest.copy()
        control[places] = [np.interp(now, time - time[0], v) for v in table.values()]
        return np.asarray(control)

    return drive, float(time[-1] - time[0])


@dataclass(frozen=True)
class Cable:
    """The tendon of a sheath, frame by frame."""

    points: FloatArray  # (frames, m+1, 3) path [m], input end first, see `tension_path`
    tensions: FloatArray  # (frames, m) between them [N], NaN between branches
    branch: Branch = ALL_OF_IT  # whose ends are shown

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

    def __repr__(self) -> str:
        return f"Frames({len(self.time)} at {self.fps:g} per second, of {', '.join(self.cables)})"


class FrameRecorder:
    """Keeps frames of a simulation at 0, 1/fps, 2/fps, … [s] while something else steps it."""

    def __init__(self, fps: float = _FPS) -> None:
        _check_positive("fps", fps, "1/s")
        self.fps = fps
        self._kept: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
        self._cables: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
        self._branches: dict[str, Branch] = {}
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
            self._branches = {name: most_bent_branch(model, name) for name in self._cables}
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
            rows.append(tension_path(model, self._scratch, name))

    def frames(self) -> Frames:
        """All frames that were kept."""
        poses, controls, readings, contacts = zip(*self._kept, strict=True)
        return Frames(
            fps=self.fps,
            time=np.arange(len(self._kept)) / self.fps,
            poses=np.array(poses),
            controls=np.array(controls),
            readings=np.array(readings),
            contacts=contacts,
            cables={
                name: Cable(
                    np.array([p for p, _ in rows]),
                    np.array([t for _, t in rows]),
                    self._branches[name],
                )
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
    pairwise = zip(middles, forces, strict=True)
    return np.array([np.concatenate(row) for row in pairwise]).reshape(-1, 6)


def record_frames(
    model: mujoco.MjModel,
    drive: Callable[[float], ArrayLike],
    *,
    duration: float,
    fps: float = _FPS,
    parameters: Mapping[str, float] | None = None,
    at_rest: bool = False,
    progress: Progress | None = None,
) -> Frames:
    """Simulate a model from its reference pose for a duration [s], and return frames of it.

    With ``at_rest`` it starts as `resting` has it.

    ``drive`` is time [s] → (nu,) controls. ``parameters`` are those of `replay.parameters`; the
    model is not changed.
    """
    check_frames(model, duration, fps)
    if (shape := np.shape(drive(0.0))) != (model.nu,):
        raise InvalidValueError(
            f"drive gives controls of shape {shape}, the model takes ({model.nu},)"
        )
    recorder, data = FrameRecorder(fps), mujoco.MjData(model)
    if parameters:
        adjustable = Adjustable(copy.copy(model))
        adjustable.set(parameters)
        model, data = adjustable.model, adjustable.data
    if at_rest:
        start = resting(model)
        data.qpos[:], data.qvel[:], data.act[:] = start.qpos, start.qvel, start.act
    frames = max(1, round(duration * fps))
    for k in range(frames):
        while data.time < k / fps - 0.5 * model.opt.timestep:
            data.ctrl[:] = drive(data.time)
            mujoco.mj_step(model, data)
        recorder.keep(model, data, drive(data.time))
        if progress:
            progress("simulate", k + 1, frames)
    return recorder.frames()


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


def frictionless(model: mujoco.MjModel) -> dict[str, float]:
    """Parameters for `record_frames` that take all friction from every sheath of a model."""
    adjustable = Adjustable(copy.copy(model))
    return {
        name: 0.0 for name, value in adjustable.live.items() if is_friction(name) and value != 0.0
    }


def is_friction(name: str) -> bool:
    """Return whether a live parameter, as ``flexor_sheath.friction``, is 0 without friction."""
    return name.rpartition(".")[2] in _FRICTION


def _check_positive(name: str, value: float, unit: str) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InvalidValueError(f"{name} = {value} [{unit}] must be finite and > 0")
