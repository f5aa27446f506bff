"""Motions of models, by default or from a CSV, and frames of them."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.frames import FPS, FrameRecorder, Frames, check_frames
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.recordings import in_si, read_columns
from tendon_mj.lab.replay import Adjustable, control_unit
from tendon_mj.lab.units import TIME, column_unit, name_in, si_name, unit_ending
from tendon_mj.plugin import sheaths
from tendon_mj.typing import FloatArray

Drive = Callable[[float], FloatArray]

_FRICTION = (
    *("friction", "static_friction", "constant_friction", "stribeck_friction"),
    *("viscous_friction", "friction_gradient", "load_gradient"),
    *("friction_drift", "direction_asymmetry"),
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


def record_frames(
    model: mujoco.MjModel,
    drive: Callable[[float], ArrayLike],
    *,
    duration: float,
    fps: float = FPS,
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


def frictionless(model: mujoco.MjModel) -> dict[str, float]:
    """Parameters for `record_frames` that take all friction from every sheath of a model."""
    adjustable = Adjustable(copy.copy(model))
    return {
        name: 0.0 for name, value in adjustable.live.items() if is_friction(name) and value != 0.0
    }


def is_friction(name: str) -> bool:
    """Return whether a live parameter, as ``flexor_sheath.friction``, is 0 without friction."""
    return name.rpartition(".")[2] in _FRICTION
