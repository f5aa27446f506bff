"""Replay: simulation of a recording, returned in the same columns."""

from __future__ import annotations

import copy
from collections.abc import Mapping

import mujoco

from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay.frames import FrameRecorder
from tendon_mj.lab.replay.misfit import Misfit as Misfit
from tendon_mj.lab.replay.misfit import replay_error as replay_error
from tendon_mj.lab.replay.open_loop import Progress, run_open_loop
from tendon_mj.lab.replay.parameters import Adjustable
from tendon_mj.lab.replay.schedule import Schedule, stated_values
from tendon_mj.models import load_model
from tendon_mj.typing import FloatArray


def replay_recording(
    recording: Recording,
    model: mujoco.MjModel | None = None,
    *,
    parameters: Mapping[str, float] | None = None,
    described: bool | None = None,
    settle: float | None = None,
    progress: Progress | None = None,
    recorder: FrameRecorder | None = None,
) -> Recording:
    """Drive a model with a recording's driven columns and read off its measured ones.

    Between samples the drive is linear in time, or held where the recording says so. The step is
    uniform, no longer than the model's and a whole fraction of the sampling interval (see
    `replay.clock`); readings belong to the pose and the control at the sample's time. Before the
    first sample the model, from its reference pose, is brought to the first drive value by a linear
    ramp over half of ``settle`` and held there for the other half. Actuators that are not driven
    stay at 0.

    Args:
        recording: what was driven and measured.
        model: to drive in place of the one that ``recording.model`` names; not changed.
        parameters: ``<element>.<parameter>`` to value (see `replay.parameters`), over
            ``recording.known`` and the values of ``recording.uncertain`` and ``recording.session``.
        described: whether those three are applied; default: all but what a diagnosis fitted, if
            ``model`` is one that it wrote (see `stated_values`).
        settle: time before the first sample [s]; with 0 the model starts in its reference pose.
            Default: as the recording says.
        progress: called with the share that is done, 0 … 1, every 2000 steps.
        recorder: keeps frames of the run from the first sample on, to be drawn.

    Returns:
        The driven columns as they were and the measured ones as simulated, at the same times;
        ``known`` holds every parameter that was applied.

    Raises:
        RecordingError: the model lacks an actuator or sensor, or the sensor is not one number.
        UnknownNameError: no such model or parameter, with the nearest.
        InvalidValueError: a parameter or ``settle`` outside its range.
        TendonError: the simulation failed; the message says when.
    """
    if model is None:
        model = load_model(recording.model, beside=recording.beside)
    adjustable = Adjustable(copy.copy(model))
    schedule = Schedule(recording, adjustable.model, settle)
    stated = stated_values(recording, model, adjustable.names(), described)
    values = {**stated, **(parameters or {})}
    adjustable.set(values)
    schedule.prepare(adjustable)
    control = schedule.control(adjustable)
    readings = run_open_loop(
        adjustable.model,
        adjustable.data,
        control,
        schedule.where,
        schedule.when,
        progress,
        recorder,
        schedule.rests(adjustable),
    )
    return as_recording(recording, schedule.read_out(adjustable, readings), values)


def as_recording(
    recording: Recording, series: Mapping[str, FloatArray], applied: Mapping[str, float]
) -> Recording:
    """Simulated series as a recording in the columns of the one that drove them.

    Args:
        recording: that drove the simulation.
        series: measured column → (n,) simulated at the samples.
        applied: every parameter that the simulation was given.
    """
    columns = {column: recording.columns[column] for column in recording.drive} | dict(series)
    return Recording(
        name=f"{recording.name}_simulated",
        model=recording.model,
        source=f"simulated by tendon-mj, driven by {recording.name!r} ({recording.source})",
        time=recording.time,
        columns={c: columns[c] for c in recording.columns if c in columns},
        drive=recording.drive,
        measured={c: Measured(m.sensor) for c, m in recording.measured.items()},
        known=applied,
        settling_time=recording.settling_time,
    )
