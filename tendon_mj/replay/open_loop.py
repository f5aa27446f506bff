"""One open-loop simulation of a model: a rollout that tells when and why it failed."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from itertools import pairwise

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.engine import unsolved_evaluations
from tendon_mj.errors import TendonError
from tendon_mj.replay.frames import FrameRecorder
from tendon_mj.replay.rollout import full_state, input_kind, rollout_sensors

FloatArray = NDArray[np.float64]
Progress = Callable[[float], None]

_PHYSICS = mujoco.mjtState.mjSTATE_FULLPHYSICS.value
_CHUNK = 2000  # steps between two reports of progress


def run_open_loop(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    control: FloatArray,
    where: str,
    when: Callable[[int], str],
    progress: Progress | None = None,
    recorder: FrameRecorder | None = None,
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
        recorder: keeps frames of the run; it changes no number either.

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
    pauses = sorted({*range(0, len(control), chunk), *due, len(control)})
    for first, end in pairwise(pauses):
        if recorder and first in due:
            recorder.keep(model, data, control[first, : model.nu])
        part = slice(first, end)
        if not _run(model, data, control[part], readings[part]):
            raise TendonError(f"{where} failed {_first_failure(model, start, control, when)}")
        if progress:
            progress(part.stop / len(control))
    for name, unsolved in unsolved_sheaths(model, data).items():
        warnings.warn(
            f"{where}: sheath {name!r} found no equilibrium in {unsolved} of {len(control)}"
            " evaluations, and took the best that it had",
            RuntimeWarning,
            stacklevel=3,
        )
    return readings


def try_open_loop(
    model: mujoco.MjModel, data: mujoco.MjData, control: FloatArray
) -> FloatArray | None:
    """Like `run_open_loop`, but returns None on failure, and warns of nothing."""
    readings = np.empty((len(control), model.nsensordata))
    return readings if _run(model, data, control, readings) else None


def unsolved_sheaths(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, int]:
    """Evaluations whose flow was not solved, of every sheath that had such."""
    return {name: count for name, count in unsolved_evaluations(model, data).items() if count}


def _run(
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
