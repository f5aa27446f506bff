"""Replay: simulate what was measured, and return it in the same columns."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.simulate.library import load_model
from tendon_mj.simulate.recording import Measured, Recording
from tendon_mj.simulate.replay_clock import Clock, make_clock
from tendon_mj.simulate.replay_error import Misfit as Misfit
from tendon_mj.simulate.replay_error import replay_error as replay_error
from tendon_mj.simulate.replay_parameters import Adjustable
from tendon_mj.simulate.replay_run import Progress, run_open_loop

FloatArray = NDArray[np.float64]


def replay(
    recording: Recording,
    model: mujoco.MjModel | None = None,
    *,
    parameters: Mapping[str, float] | None = None,
    settle: float = 0.5,
    progress: Progress | None = None,
) -> Recording:
    """Drive a model with a recording's driven columns and read off its measured ones.

    Between samples the drive is linear in time. The step is uniform, no longer than the model's
    and a whole fraction of the sampling interval (see ``replay_clock``); readings belong to the
    pose and the control at the sample's time. Before the first sample the model, from its
    reference pose, is brought to the first drive value by a linear ramp over half of ``settle``
    and held there for the other half. Actuators that are not driven stay at 0.

    Args:
        recording: what was driven and measured.
        model: to drive in place of the one that ``recording.model`` names; not changed.
        parameters: ``<element>.<parameter>`` to value (see ``replay_parameters``), over
            ``recording.known`` and the values of ``recording.uncertain``.
        settle: time before the first sample [s]; with 0 the model starts in its reference pose.
        progress: called with the share that is done, 0 … 1, every 2000 steps.

    Returns:
        The driven columns as they were and the measured ones as simulated, at the same times;
        ``known`` holds every parameter that was applied.

    Raises:
        RecordingError: the model lacks an actuator or sensor, or the sensor is not one number.
        UnknownNameError: no such model or parameter, with the nearest.
        InvalidValueError: a parameter or ``settle`` outside its range.
        TendonError: the simulation failed; the message says when.
    """
    if not (math.isfinite(settle) and settle >= 0.0):
        raise InvalidValueError(f"settle = {settle} [s] must be finite and ≥ 0")
    rig = Adjustable(copy.copy(model) if model is not None else load_model(recording.model))
    addresses = _sensor_addresses(recording, rig.model)
    values = {
        **recording.known,
        **{name: uncertain.value for name, uncertain in recording.uncertain.items()},
        **(parameters or {}),
    }
    rig.set(values)
    clock = make_clock(recording.time, rig.model.opt.timestep)
    rig.model.opt.timestep = clock.timestep
    lead = math.ceil(settle / clock.timestep * (1.0 - 1e-9))
    control = _control(recording, rig, clock, lead)

    def when(step: int) -> str:
        if step < lead:
            return f"{(lead - step) * clock.timestep:.6g} s before the first sample, settling"
        return f"at time {clock.time[step - lead]:.6g} s"

    where = f"replay of {recording.name!r} on model {recording.model!r}"
    readings = run_open_loop(rig.model, rig.data, control, where, when, progress)
    samples = clock.sample(readings[lead:])
    columns = {column: recording.columns[column] for column in recording.drive}
    for column, (sensor, address) in addresses.items():
        scale, offset = rig.readings[sensor]
        columns[column] = scale * samples[:, address] + offset
    return Recording(
        name=f"{recording.name}_simulated",
        model=recording.model,
        source=f"simulated by tendon-mj, driven by {recording.name!r} ({recording.source})",
        time=recording.time,
        columns={c: columns[c] for c in recording.columns if c in columns},
        drive=recording.drive,
        measured={c: Measured(m.sensor) for c, m in recording.measured.items()},
        known=values,
    )


def _sensor_addresses(recording: Recording, model: mujoco.MjModel) -> dict[str, tuple[int, int]]:
    """Sensor and its place in `mjData.sensordata` for every measured column."""
    sensors = {model.sensor(k).name: k for k in range(model.nsensor)}
    actuators = {model.actuator(k).name for k in range(model.nactuator)}
    recording.check_against(actuators - {""}, sensors.keys() - {""})
    found = {}
    for column, measured in recording.measured.items():
        sensor = sensors[measured.sensor]
        if model.sensor_dim[sensor] != 1:
            raise RecordingError(
                f"recording {recording.name!r}, [measured] {column!r}: sensor {measured.sensor!r}"
                f" reads {model.sensor_dim[sensor]} numbers, and a column is one"
            )
        found[column] = (sensor, int(model.sensor_adr[sensor]))
    return found


def _control(recording: Recording, rig: Adjustable, clock: Clock, lead: int) -> FloatArray:
    """(lead+steps+1, nu) controls: the ramp and rest before the first sample, then the drive."""
    control = np.zeros((lead + clock.steps + 1, rig.model.nu))
    ramp = np.minimum(1.0, np.arange(1, lead + 1) / max(1, lead // 2))
    for column, name in recording.drive.items():
        actuator = rig.model.actuator(name).id
        scale, offset = rig.commands[actuator]
        drive = scale * np.interp(clock.time, recording.time, recording.columns[column]) + offset
        slot = rig.model.actuator_ctrladr[actuator]
        control[:lead, slot] = ramp * drive[0]
        control[lead:, slot] = drive
    return control
