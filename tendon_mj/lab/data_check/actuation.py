"""Warnings about actuators: a drive beyond its range, and forces that a motor cannot bear."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np

from tendon_mj.lab.data_check.warning import DataWarning
from tendon_mj.lab.recordings import Recording, noise_levels
from tendon_mj.lab.replay import Adjustable, Schedule, column_unit, quantity
from tendon_mj.plugin import sensor_kind
from tendon_mj.typing import FloatArray

_APART = 3.0  # noises, rms, by which a column and the joint that another prescribes differ
_NEAR = 1e-6  # of a control range: a control this near to an end is at it
_MOST = 0.01  # of the samples that may be at an end
_PULL = 1.05  # times the largest pull, above which a tension is beyond it
_HELD = 0.5  # of a load, below which an actuator counts as bearing it
_JOINT = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value


def actuation_warnings(schedule: Schedule, adjustable: Adjustable) -> list[DataWarning]:
    """Warn of a saturated drive, and of joints and tendons whose load is beyond their actuators.

    Args:
        schedule: of a recording.
        adjustable: its model at the numbers that its description states; not stepped.
    """
    return [
        *_saturated(schedule, adjustable),
        *_cannot_hold(schedule, adjustable),
        *_lets_go(schedule, adjustable),
        *_cannot_pull(schedule.recording, adjustable.model),
    ]


def prescribed_warnings(
    schedule: Schedule, simulated: Recording, model: mujoco.MjModel
) -> list[DataWarning]:
    """Warn of a joint that one column prescribes and another measures, where the two differ."""
    found, recording = [], schedule.recording
    prescribed, noise = (
        {joint: column for column, joint in schedule.joints},
        noise_levels(recording),
    )
    for column, measured in recording.measured.items():
        sensor = model.sensor(measured.sensor).id
        joint = int(model.sensor_objid[sensor])
        of_joint = model.sensor_type[sensor] == mujoco.mjtSensor.mjSENS_JOINTPOS.value
        off = float(np.sqrt(np.mean((recording.columns[column] - simulated.columns[column]) ** 2)))
        if of_joint and joint in prescribed and off > _APART * noise[column]:
            found.append(
                DataWarning(
                    "prescribed",
                    f"{recording.name}, [measured] {recording.written(column)!r}",
                    f"is off by {quantity(off, column_unit(column))} rms from joint"
                    f" {model.joint(joint).name!r}, which [drive]"
                    f" {recording.written(prescribed[joint])!r} prescribes: the two columns differ,"
                    " and no friction can make that up",
                    "this residual is no test of the model: check unit, sign and zero of both"
                    " columns, and leave this one out of [measured]",
                )
            )
    return found


def _saturated(schedule: Schedule, adjustable: Adjustable) -> list[DataWarning]:
    found, model, recording = [], adjustable.model, schedule.recording
    for column, actuator in schedule.actuators:
        if not model.actuator_ctrllimited[actuator]:
            continue
        name = model.actuator(actuator).name
        low, high = model.actuator_ctrlrange[actuator].tolist()
        scale, offset = adjustable.commands[actuator, :2].tolist()
        control = scale * recording.columns[column] + offset
        slack = _NEAR * (high - low)
        share = float(np.mean((control <= low + slack) | (control >= high - slack)))
        if share > _MOST:
            found.append(
                DataWarning(
                    "saturated",
                    f"{recording.name}, [drive] {recording.written(column)!r}",
                    f"{share:.0%} of the samples are at or beyond the control range of actuator"
                    f" {name!r}, {low:g} to {high:g}; the column goes from {control.min():.4g} to"
                    f" {control.max():.4g}",
                    "the model clips what lies beyond: check the column's unit, widen the"
                    " actuator's ctrlrange if the rig went there, or record a smaller motion",
                )
            )
    return found


def _cannot_hold(schedule: Schedule, adjustable: Adjustable) -> list[DataWarning]:
    """Joints whose actuators are too weak for what pulls on them in the reference pose."""
    model, found = adjustable.model, []
    load, _ = _forces_at_start(adjustable, {})
    for joint in {*range(model.njnt)} - {joint for _, joint in schedule.joints}:
        on = np.isin(model.actuator_trntype, _JOINT) & (model.actuator_trnid[:, 0] == joint)
        dof = int(model.jnt_dofadr[joint])
        slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE.value
        if not on.any() or (
            not slides and model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE.value
        ):
            continue
        least = sum(
            _largest_force(model, int(k)) * abs(float(model.actuator_gear[k, 0]))
            for k in np.flatnonzero(on)
        )
        if abs(load[dof]) > least:
            unit = "N" if slides else "N m"
            found.append(
                DataWarning(
                    "weak_motor",
                    f"{schedule.recording.name}, joint {model.joint(joint).name!r}",
                    f"pretension, springs and weight pull it with {abs(load[dof]):.3g} {unit} where"
                    f" it starts, its actuators hold {least:.3g} {unit} at most",
                    "check the pretension in [known] or [uncertain], the radius at which the joint"
                    " winds the tendon, and the actuator's gear and forcerange",
                )
            )
    return found


def _lets_go(schedule: Schedule, adjustable: Adjustable) -> list[DataWarning]:
    """Actuators that bear a load with the first drive value, and none with the control of 0.

    A replay that comes to the first value from 0 lets the load go first, which friction remembers.
    """
    model, recording = adjustable.model, schedule.recording
    if recording.settle == 0.0:
        return []
    found: list[DataWarning] = []
    none = np.add(*_forces_at_start(adjustable, {}))
    for column, actuator in schedule.actuators:
        if model.actuator_trntype[actuator] not in _JOINT:
            continue
        dof = int(model.jnt_dofadr[model.actuator_trnid[actuator, 0]])
        scale, offset = adjustable.commands[actuator, :2].tolist()
        first = float(scale * recording.columns[column][0] + offset)
        held = np.add(*_forces_at_start(adjustable, {actuator: first}))
        if abs(held[dof]) < _HELD * abs(none[dof]):
            found.append(
                DataWarning(
                    "lets_go",
                    f"{recording.name}, [drive] {recording.written(column)!r}",
                    f"actuator {model.actuator(actuator).name!r} bears a load at rest with the"
                    f" first drive value, and a replay comes to it in {recording.settle:g} s from a"
                    " control of 0, which lets go",
                    "write settle = 0.0 (or try --settle 0): the replay then begins with the first"
                    " drive value",
                )
            )
    return found


def _forces_at_start(
    adjustable: Adjustable, controls: Mapping[int, float]
) -> tuple[FloatArray, FloatArray]:
    """Loads and actuators' forces on the degrees of freedom in the reference pose [N or N m]."""
    model, data = adjustable.model, adjustable.data
    state = mujoco.mjtState.mjSTATE_INTEGRATION
    kept = np.empty(mujoco.mj_stateSize(model, state))
    mujoco.mj_getState(model, data, kept, state)
    for actuator, control in controls.items():
        data.ctrl[actuator] = control
    mujoco.mj_forward(model, data)
    forces = data.qfrc_passive - data.qfrc_bias, data.qfrc_actuator.copy()
    mujoco.mj_setState(model, data, kept, state)
    return forces


def _cannot_pull(recording: Recording, model: mujoco.MjModel) -> list[DataWarning]:
    """Tendons whose measured tension is beyond the pull of the motors or muscles on them."""
    found = []
    for column, measured in recording.measured.items():
        sensor = model.sensor(measured.sensor).id
        if sensor_kind(model, sensor) != "input_tension":
            continue
        tendon = int(model.sensor_objid[sensor])
        on = (model.actuator_trntype == _TENDON) & (model.actuator_trnid[:, 0] == tendon)
        on &= model.actuator_plugin < 0
        if not on.any():
            continue
        most = sum(
            _largest_force(model, int(k)) * abs(float(model.actuator_gear[k, 0]))
            for k in np.flatnonzero(on)
        )
        tension = float(np.max(recording.columns[column]))
        if tension > _PULL * most:
            found.append(
                DataWarning(
                    "weak_motor",
                    f"{recording.name}, [measured] {recording.written(column)!r}",
                    f"reaches {tension:.4g} N, the actuators of tendon"
                    f" {model.tendon(tendon).name!r} pull with {most:.4g} N at most",
                    "check the column's unit, and gear, gain and forcerange of the actuators",
                )
            )
    return found


def _largest_force(model: mujoco.MjModel, actuator: int) -> float:
    """Largest force of an actuator before its gear [N or N m]; inf where nothing limits it."""
    if model.actuator_forcelimited[actuator]:
        return float(np.abs(model.actuator_forcerange[actuator]).max())
    gain = model.actuator_gainprm[actuator]
    if model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_MUSCLE.value:
        return float(gain[2] if gain[2] > 0.0 else gain[3] / model.actuator_acc0[actuator])
    plain = (
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED.value
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE.value
    )
    if plain and model.actuator_ctrllimited[actuator]:
        return float(abs(gain[0]) * np.abs(model.actuator_ctrlrange[actuator]).max())
    return math.inf
