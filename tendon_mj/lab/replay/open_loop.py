"""One open-loop simulation of a model: a rollout that tells when and why it failed."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.replay.frames import FrameRecorder
from tendon_mj.lab.replay.rollout import full_state, input_kind, rollout_sensors
from tendon_mj.plugin import unsolved_evaluations
from tendon_mj.typing import FloatArray

Progress = Callable[[float], None]

_PHYSICS = mujoco.mjtState.mjSTATE_FULLPHYSICS.value
_CHUNK = 2000  # steps between two reports of progress
_WATCHED = 0.05  # of a rest, between two looks at whether anything still moves [s]
_RESTS = 1e-4  # of what a reading spans or a joint moved: less to come until a rest's end is none
_UNMOVED = 1e-3  # [rad or m], by which a joint moves at least for this


class Rests(NamedTuple):
    """Rests of a run, of which the steps are left out in which nothing moves any more.

    Attributes:
        ends: step at which a rest ends → time there [s].
        spans: (nsensordata,) range of each reading, infinite where it does not count.
    """

    ends: Mapping[int, float]
    spans: FloatArray


def run_open_loop(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    control: FloatArray,
    where: str,
    when: Callable[[int], str],
    progress: Progress | None = None,
    recorder: FrameRecorder | None = None,
    rests: Rests | None = None,
) -> FloatArray:
    """Step once for every row of controls, and read the sensors as of the start of each step.

    A step's readings therefore belong to its own control and to the pose that the steps before it
    led to. Warns where a sheath's flow was not solved.

    Args:
        model, data: where to start; ``data`` is at the end afterwards.
        control: (steps, nu), or (steps, nu+nv) with applied forces.
        where: begins every message.
        when: says to the reader when a step was.
        progress: called with the share that is done, 0 … 1; what it costs is a call every 2000
            steps, and it changes no number.
        recorder: keeps frames of the run; it changes no number either, but that of rests no step
            is left out.
        rests: of the run; what is left of one is left out as soon as nothing moves any more.

    Returns:
        (steps, nsensordata) readings.

    Raises:
        TendonError: MuJoCo raised a warning, or a reading is not finite; it says when.
    """
    readings = np.empty((len(control), model.nsensordata))
    start = full_state(model, data)
    chunk = _CHUNK if progress else len(control)
    step = model.opt.timestep
    due = set(recorder.due(data.time, step, len(control) - 1)) if recorder else set()
    pauses = sorted(
        {0, *(rests.ends if rests else range(0, len(control), chunk)), *due, len(control)}
    )
    for first, end in pairwise(pauses):
        if recorder and first in due:
            recorder.keep(model, data, control[first, : model.nu])
        if not _run(model, data, control, readings, slice(first, end), rests):
            raise TendonError(f"{where} failed {_first_failure(model, start, control, when)}")
        if progress:
            progress(end / len(control))
    for name, unsolved in unsolved_sheaths(model, data).items():
        warnings.warn(
            f"{where}: sheath {name!r} found no equilibrium in {unsolved} of {len(control)}"
            " evaluations, and took the best that it had",
            RuntimeWarning,
            stacklevel=3,
        )
    return readings


def try_open_loop(
    model: mujoco.MjModel, data: mujoco.MjData, control: FloatArray, rests: Rests | None = None
) -> FloatArray | None:
    """Like `run_open_loop`, but returns None on failure, and warns of nothing."""
    readings = np.empty((len(control), model.nsensordata))
    pauses = sorted({0, *(rests.ends if rests else ()), len(control)})
    for first, end in pairwise(pauses):
        if not _run(model, data, control, readings, slice(first, end), rests):
            return None
    return readings


def unsolved_sheaths(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, int]:
    """Evaluations whose flow was not solved, of every sheath that had such."""
    return {name: count for name, count in unsolved_evaluations(model, data).items() if count}


def _run(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    control: FloatArray,
    readings: FloatArray,
    part: slice,
    rests: Rests | None,
) -> bool:
    """Fill a part of the readings, see `_step`; of one that ends with a rest, until all rests."""
    if rests is None or part.stop not in rests.ends:
        return _step(model, data, control[part], readings[part])
    changes = np.flatnonzero((control[part] != control[part.stop - 1]).any(axis=1))
    at = part.start + (int(changes[-1]) + 1 if changes.size else 0)
    began, watched = data.qpos.copy(), max(1, round(_WATCHED / model.opt.timestep))
    if at > part.start and not _step(
        model, data, control[part.start : at], readings[part.start : at]
    ):
        return False
    while at < part.stop:
        chunk, before = slice(at, min(at + watched, part.stop)), data.qpos.copy()
        if not _step(model, data, control[chunk], readings[chunk]):
            return False
        at = chunk.stop
        longer = (part.stop - at) / (chunk.stop - chunk.start)
        moved = np.abs(_moved(model, before, data.qpos)) * longer
        reach = np.maximum(np.abs(_moved(model, began, data.qpos)), _UNMOVED)
        changed = np.ptp(readings[chunk], axis=0) * longer
        if (moved <= _RESTS * reach).all() and (changed <= _RESTS * rests.spans).all():
            readings[at : part.stop] = readings[at - 1]
            break
    data.time = rests.ends[part.stop]
    return True


def _moved(model: mujoco.MjModel, before: FloatArray, after: FloatArray) -> FloatArray:
    """(nv,) way of every degree of freedom from one pose to another [rad or m]."""
    way = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, way, 1.0, before, after)
    return way


def _step(
    model: mujoco.MjModel, data: mujoco.MjData, control: FloatArray, readings: FloatArray
) -> bool:
    """Fill readings from where the data is; false if MuJoCo warned or a reading is not finite."""
    start, warmstart = full_state(model, data)[None], data.qacc_warmstart[None].copy()
    readings[:] = rollout_sensors(model, [data], start, control[None], warmstart)[0]
    return not data.warning.number.any() and bool(np.isfinite(readings).all())


def _first_failure(
    model: mujoco.MjModel, start: FloatArray, control: FloatArray, when: Callable[[int], str]
) -> str:
    """Step once more from the start, and say when and why it failed."""
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, start, _PHYSICS)
    timestep = f"the timestep was {model.opt.timestep:.6g} s"
    for step, row in enumerate(control):
        mujoco.mj_setState(model, data, row, input_kind(model, row))
        mujoco.mj_step(model, data)
        raised = [k for k, warning in enumerate(data.warning) if warning.number]
        if raised:
            name = mujoco.mjtWarning(raised[0]).name
            return f"{when(step)}: MuJoCo raised {name}; {timestep}"
        if not np.isfinite(data.sensordata).all():
            return f"{when(step)}: a sensor reads no finite number; {timestep}"
    return f"at a time that a second run did not find; {timestep}"
