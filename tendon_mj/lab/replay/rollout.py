"""Rollouts of a model: a sequence of controls without Python in a step, read by its sensors."""

from __future__ import annotations

import mujoco
import numpy as np
from mujoco import rollout

from tendon_mj.errors import TendonError
from tendon_mj.typing import FloatArray


def full_state(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """State of kind FULLPHYSICS, from which a rollout goes on. Shape (state size,)."""
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    return state


def input_kind(model: mujoco.MjModel, control: FloatArray) -> int:
    """Kind of state that a row of controls is: nu controls, with or without nv applied forces."""
    kind = int(mujoco.mjtState.mjSTATE_CTRL.value)
    applied = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED.value)
    return kind if control.shape[-1] == model.nu else kind | applied


def rollout_sensors(
    model: mujoco.MjModel,
    data: list[mujoco.MjData],
    start: FloatArray,
    control: FloatArray,
    warmstart: FloatArray | None = None,
) -> FloatArray:
    """(runs, steps, nsensordata) readings of rollouts, one thread for each of ``data``.

    Unlike a plain `mujoco.rollout` it keeps no states: a sheath of 64 guides has thousands of
    numbers, and writing them down at every step would cost more than the step.

    Args:
        model: of all runs.
        data: work space, one a thread.
        start: (runs, state size) states of kind FULLPHYSICS.
        control: (runs, steps, nu), or (runs, steps, nu+nv) with applied forces (`input_kind`).
        warmstart: (runs, nv) accelerations from which the solver starts; none are 0.
    """
    runs, steps = control.shape[:2]
    readings = np.empty((runs, steps, model.nsensordata))
    with rollout.Rollout(nthread=len(data) if len(data) > 1 else 0) as runner:
        runner.rollout(
            [model] * runs,
            data,
            start,
            np.ascontiguousarray(control),
            control_spec=input_kind(model, control),
            skip_checks=True,  # with them it would allocate the states of all steps
            nstep=steps,
            initial_warmstart=warmstart,
            sensordata=readings,
        )
    return readings


def rollout_named_sensors(
    model: mujoco.MjModel, control: FloatArray, threads: int = 1
) -> dict[str, FloatArray]:
    """Readings by sensor of a model whose one actuator follows ``control``.

    Args:
        model: with one actuator.
        control: (steps,) or (runs, steps); readings have the same shape.
        threads: simulations at a time.

    Raises:
        TendonError: a simulation became unstable or left a flow unsolved.
    """
    commands = np.atleast_2d(control)
    data = [mujoco.MjData(model) for _ in range(threads)]
    start = np.tile(full_state(model, data[0]), (len(commands), 1))
    readings = rollout_sensors(model, data, start, commands[:, :, None])
    if not np.isfinite(readings).all() or any(d.warning.number.any() for d in data):
        raise TendonError(f"a simulation at a step of {model.opt.timestep:g} s became unstable")
    readings = readings.reshape(*control.shape, model.nsensordata)
    names = [model.sensor(k).name for k in range(model.nsensor)]
    found = {name: readings[..., int(model.sensor(name).adr[0])] for name in names}
    if "unsolved" in found and found["unsolved"].max() > 0.0:
        raise TendonError(f"{found['unsolved'].max():g} flows of the plugin were not solved")
    return found
