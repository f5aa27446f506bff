"""Warnings about actuators: drives beyond their range, loads that no motor bears, soft play.

The drum's flank of a play is a spring of k_b = J/(4 r² h²) that gives way by T/k_b (docs/theory.md,
section 7), and a servo is behind its command by a time k_v/k_p. A fit takes both for a part of the
play.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import mujoco
import numpy as np

from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.column import Column, columns_of
from tendon_mj.lab.data_check.faults import DataWarning
from tendon_mj.lab.parameter_names import expand
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Adjustable, Schedule
from tendon_mj.lab.units import JOINT, quantity
from tendon_mj.plugin import sensor_kind, sheath_arrays, sheaths
from tendon_mj.typing import BoolArray, FloatArray

_JOINT = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value


def actuation_warnings(schedule: Schedule, adjustable: Adjustable) -> Iterator[DataWarning]:
    """Warn of a saturated drive, and of joints and tendons whose load is beyond their actuators."""
    yield from _saturated(schedule, adjustable)
    yield from _cannot_hold(schedule, adjustable)
    yield from _lets_go(schedule, adjustable)
    yield from _cannot_pull(schedule.recording, adjustable.model)


def prescribed_warnings(
    schedule: Schedule, simulated: Recording, model: mujoco.MjModel
) -> Iterator[DataWarning]:
    """Warn of a joint that one column prescribes and another measures, where the two differ."""
    recording = schedule.recording
    prescribed = {joint: column for column, joint in schedule.joints}
    for column in columns_of(recording, simulated):
        sensor = None if column.driven else model.sensor(column.sensor).id
        if sensor is None or model.sensor_type[sensor] != mujoco.mjtSensor.mjSENS_JOINTPOS.value:
            continue
        joint = int(model.sensor_objid[sensor])
        off = float(np.sqrt(np.mean((column.read - column.model) ** 2)))
        if joint in prescribed and off > limits.SIGMAS * column.noise:
            yield column.warn(
                "prescribed",
                f"is off by {column.say(off)} rms from joint {model.joint(joint).name!r}, which"
                f" [drive] {recording.written(prescribed[joint])!r} prescribes: the two columns"
                " differ, and no friction can make that up",
                "this residual does not test the model: check unit, sign and zero of both"
                " columns, and leave this one out of [measured]",
            )


def _commands(
    schedule: Schedule, adjustable: Adjustable
) -> Iterator[tuple[Column, int, FloatArray]]:
    """Driven column, its actuator, and (n,) controls."""
    for name, actuator in schedule.actuators:
        column = Column(schedule.recording, name)
        scale, offset = adjustable.commands[actuator, :2].tolist()
        yield column, actuator, scale * column.read + offset


def _saturated(schedule: Schedule, adjustable: Adjustable) -> Iterator[DataWarning]:
    model = adjustable.model
    for column, actuator, control in _commands(schedule, adjustable):
        low, high = model.actuator_ctrlrange[actuator].tolist()
        rounding = limits.ROUNDING * (high - low)
        share = float(np.mean((control <= low + rounding) | (control >= high - rounding)))
        if model.actuator_ctrllimited[actuator] and share > limits.OUTER:
            yield column.warn(
                "saturated",
                f"{share:.0%} of the samples are at or beyond the control range of actuator"
                f" {model.actuator(actuator).name!r}, {low:g} to {high:g}; the column goes from"
                f" {control.min():.4g} to {control.max():.4g}",
                "the model clips controls beyond it: check the column's unit, widen the"
                " actuator's ctrlrange if the rig went there, or record a smaller motion",
            )


def _cannot_hold(schedule: Schedule, adjustable: Adjustable) -> Iterator[DataWarning]:
    """Joints whose actuators are too weak for the load in the reference pose."""
    model = adjustable.model
    load, _ = _forces_at_start(adjustable, {})
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
    for joint in {*range(model.njnt)} - {joint for _, joint in schedule.joints}:
        on = np.isin(model.actuator_trntype, _JOINT) & (model.actuator_trnid[:, 0] == joint)
        if not on.any() or model.jnt_type[joint] not in (hinge, slide):
            continue
        pull, least = abs(load[int(model.jnt_dofadr[joint])]), _largest_sum(model, on)
        if pull > least:
            unit = "N" if model.jnt_type[joint] == slide else "N m"
            yield DataWarning(
                "weak_motor",
                f"{schedule.recording.name}, joint {model.joint(joint).name!r}",
                f"pretension, springs and weight pull it with {pull:.3g} {unit} where it starts,"
                f" its actuators hold {least:.3g} {unit} at most",
                "check the pretension in [known] or [uncertain], the radius at which the joint"
                " winds the tendon, and the actuator's gear and forcerange",
            )


def _lets_go(schedule: Schedule, adjustable: Adjustable) -> Iterator[DataWarning]:
    """Actuators that bear a load with the first drive value, and none with the control of 0.

    A replay that comes to the first value from 0 lets the load go first, which friction remembers.
    """
    model, settle = adjustable.model, schedule.recording.settle
    if settle == 0.0:
        return
    none = np.add(*_forces_at_start(adjustable, {}))
    for column, actuator, control in _commands(schedule, adjustable):
        if model.actuator_trntype[actuator] not in _JOINT:
            continue
        dof = int(model.jnt_dofadr[model.actuator_trnid[actuator, 0]])
        held = np.add(*_forces_at_start(adjustable, {actuator: float(control[0])}))
        if abs(held[dof]) < 0.5 * abs(none[dof]):  # bears most of it
            yield column.warn(
                "lets_go",
                f"actuator {model.actuator(actuator).name!r} bears a load at rest with the first"
                f" drive value, and a replay comes to it in {settle:g} s from a control of 0, which"
                " lets go",
                "write settle = 0.0 (or try --settle 0): the replay then begins with the first"
                " drive value",
            )


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


def _cannot_pull(recording: Recording, model: mujoco.MjModel) -> Iterator[DataWarning]:
    """Tendons whose measured tension is beyond the pull of the motors or muscles on them."""
    for name, measured in recording.measured.items():
        column, sensor = Column(recording, name), model.sensor(measured.sensor).id
        tendon = int(model.sensor_objid[sensor])
        on = (model.actuator_trntype == _TENDON) & (model.actuator_trnid[:, 0] == tendon)
        on &= model.actuator_plugin < 0
        if sensor_kind(model, sensor) != "input_tension" or not on.any():
            continue
        most, tension = _largest_sum(model, on), float(column.read.max())
        if tension > (1.0 + limits.LITTLE) * most:
            yield column.warn(
                "weak_motor",
                f"reaches {tension:.4g} N, the actuators of tendon {model.tendon(tendon).name!r}"
                f" pull with {most:.4g} N at most",
                "check the column's unit, and gear, gain and forcerange of the actuators",
            )


def _largest_sum(model: mujoco.MjModel, on: BoolArray) -> float:
    """Sum of the largest forces of actuators, by their gears [N or N m]."""
    return sum(
        _largest_force(model, int(k)) * abs(float(model.actuator_gear[k, 0]))
        for k in np.flatnonzero(on)
    )


def _largest_force(model: mujoco.MjModel, actuator: int) -> float:
    """Largest force of an actuator before its gear [N or N m]; inf if nothing limits it."""
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


def stated_play(schedule: Schedule, adjustable: Adjustable) -> dict[str, tuple[float, float]]:
    """Sheath → play that a description states, or holds possible [m], and no further limit."""
    uncertain = expand(schedule.recording.uncertain, adjustable.names())
    plays = {}
    for name in sheaths(adjustable.model):
        guess = uncertain.get(f"{name}.backlash")
        plays[name] = adjustable.live.get(f"{name}.backlash", 0.0) or (guess.high if guess else 0.0)
    return {name: (play, math.inf) for name, play in plays.items() if play > 0.0}


def play_warnings(
    schedule: Schedule,
    adjustable: Adjustable,
    plays: Mapping[str, tuple[float, float]],
    *,
    with_servo: bool = False,
) -> Iterator[DataWarning]:
    """Warn of drums that stand off by more than 3 % of the play, the noise, or its limit.

    The noise of a tension counts as a length by the cable's stiffness EA/L, that of the joint at
    the output by its radius. Of several sheaths on one joint the first is named. ``adjustable`` is
    at the numbers that are stated or fitted, and not stepped.

    ``plays``: sheath → its play, and a limit, as half the interval of a fitted play [m];
    ``with_servo``: whether the lag of a servo counts if its joint was not measured. It is the
    motor's own where its command was recorded, and an error where the angle was.
    """
    model, recording = adjustable.model, schedule.recording
    mujoco.mj_forward(model, adjustable.data)
    done = {joint for _, joint in schedule.joints}
    for name, sheath in sheaths(model).items():
        state = sheath_arrays(model, adjustable.data.plugin_state, name, sheath.state).state
        joint, radius = int(state["reel_joint"]), float(state["reel_radius"])
        if name not in plays or joint < 0 or joint in done:
            continue
        play, limit = plays[name]
        tendon = model.tendon(sheath.tendon).id
        output = int(state["output_joint"]), abs(float(state["output_radius"]))
        pull, noise, measured = _pull_and_noise(recording, adjustable, name, tendon, output, joint)
        with_servo = with_servo and not measured
        inertia = 1.0 / float(model.dof_invweight0[model.jnt_dofadr[joint]])
        step = schedule.clock.timestep
        flank = 4.0 * pull * (radius * step) ** 2 / inertia
        late = abs(radius) * _servo_lag(schedule, adjustable, joint) if with_servo else 0.0
        most = min(limits.FLANK * play, noise, limit)
        if flank + late <= most:
            continue
        done.add(joint)
        parts = [f"the drum's flank gives way by {quantity(flank, 'm', 2)} at {pull:.3g} N"]
        ways = ["if its angle was measured, prescribe it by that: name the joint in [drive]"]
        if late:
            parts.append(f"the servo is {quantity(late, 'm', 2)} behind its command")
        if flank > most:
            step *= math.sqrt(most / flank)
            slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE.value
            unit = JOINT["armature"][int(slides)]
            ways.append(f"give it an armature of {inertia * flank / most:.2g} {unit}")
            ways.append(f"simulate in steps of {quantity(step, 's', 2)}")
        yield DataWarning(
            "soft_flank",
            f"{recording.name}, joint {model.joint(joint).name!r}",
            f"{' and '.join(parts)}, of a play of {quantity(play, 'm')}; more than"
            f" {quantity(most, 'm', 2)} is taken for a part of it",
            ", or ".join(ways),
        )


def _pull_and_noise(
    recording: Recording,
    adjustable: Adjustable,
    name: str,
    tendon: int,
    output: tuple[int, float],
    reel: int,
) -> tuple[float, float, bool]:
    """Largest tension of a sheath [N], noise as a length [m], and if its reel's angle was measured.

    ``output``: joint and radius.
    """
    model = adjustable.model
    stiffness = adjustable.live[f"{name}.axial_stiffness"] / float(model.tendon_length0[tendon])
    pull, noise, reel_measured = adjustable.live[f"{name}.pretension"], math.inf, False
    for column, measured in recording.measured.items():
        sensor = model.sensor(measured.sensor).id
        on, level = int(model.sensor_objid[sensor]), measured.noise or math.inf
        if on == tendon and sensor_kind(model, sensor) == "input_tension":
            pull = float(recording.columns[column].max())
            noise = min(noise, level / stiffness)
        elif model.sensor_type[sensor] == mujoco.mjtSensor.mjSENS_JOINTPOS.value:
            reel_measured |= on == reel
            if on == output[0]:
                noise = min(noise, level * output[1])
    return pull, noise, reel_measured


def _servo_lag(schedule: Schedule, adjustable: Adjustable, joint: int) -> float:
    """Angle or length by which the servos that a recording drives are behind on a joint."""
    model, lag = adjustable.model, 0.0
    for column, k in schedule.actuators:
        on_joint = model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_JOINT.value
        kp, kv = -model.actuator_biasprm[k, 1], -model.actuator_biasprm[k, 2]
        if on_joint and model.actuator_trnid[k, 0] == joint and kp > 0.0:
            series = adjustable.commands[k, 0] * schedule.recording.columns[column]
            speed = np.percentile(np.abs(np.diff(series) / np.diff(schedule.recording.time)), 90.0)
            lag += float(kv * speed / kp)
    return lag
