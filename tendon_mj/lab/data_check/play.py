"""Warnings of play between a motor's joint and its drum, where the model's own yielding blurs it.

The drum's flank is a spring of k_b = J/(4 r² h²) that gives way by T/k_b (docs/theory.md, section
7), and a servo is behind its command by a time k_v/k_p. A fit takes both for a part of the play.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import mujoco
import numpy as np

from tendon_mj.lab.data_check.warning import DataWarning
from tendon_mj.lab.replay import JOINT, Adjustable, Schedule, expand, quantity
from tendon_mj.plugin import sensor_kind, sheath_arrays, sheaths

_SHARE = 0.03  # of the play, by which the drum may stand off
_RIGIDITY = 4.0  # k_b = J/(4 r² h²)


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
    the output by its radius. Of several sheaths on one joint the first is named.

    Args:
        schedule: of a recording.
        adjustable: its model at the numbers that are stated or fitted; not stepped.
        plays: sheath → its play, and a limit, as half the interval of a fitted play [m].
        with_servo: whether the lag of a servo counts whose joint was not measured. It is the
            motor's own where its command was recorded, and an error where the angle was.
    """
    model, data, recording = adjustable.model, adjustable.data, schedule.recording
    mujoco.mj_forward(model, data)
    done = {joint for _, joint in schedule.joints}
    for name, found in sheaths(model).items():
        state = sheath_arrays(model, data.plugin_state, name, found.state).state
        joint, radius = int(state["reel_joint"]), float(state["reel_radius"])
        if name not in plays or joint < 0 or joint in done:
            continue
        play, limit = plays[name]
        tendon = model.tendon(found.tendon).id
        length = float(model.tendon_length0[tendon])
        stiffness = adjustable.live[f"{name}.axial_stiffness"] / length
        pull, noise = adjustable.live[f"{name}.pretension"], math.inf
        for column, measured in recording.measured.items():
            sensor = model.sensor(measured.sensor).id
            on, level = int(model.sensor_objid[sensor]), measured.noise or math.inf
            if on == tendon and sensor_kind(model, sensor) == "input_tension":
                pull = float(recording.columns[column].max())
                noise = min(noise, level / stiffness)
            elif model.sensor_type[sensor] == mujoco.mjtSensor.mjSENS_JOINTPOS.value:
                with_servo = with_servo and on != joint
                if on == state["output_joint"]:
                    noise = min(noise, level * abs(float(state["output_radius"])))
        inertia = 1.0 / float(model.dof_invweight0[model.jnt_dofadr[joint]])
        step = schedule.clock.timestep
        flank = _RIGIDITY * pull * (radius * step) ** 2 / inertia
        late = abs(radius) * _servo_lag(schedule, adjustable, joint) if with_servo else 0.0
        most = min(_SHARE * play, noise, limit)
        if flank + late <= most:
            continue
        done.add(joint)
        parts = [f"the drum's flank gives way by {quantity(flank, 'm', 2)} at {pull:.3g} N"]
        ways = ["if its angle was measured, prescribe it by that: name the joint in [drive]"]
        if late:
            parts.append(f"the servo is {quantity(late, 'm', 2)} behind its command")
        if flank > most:
            step *= math.sqrt(most / flank)
            unit = JOINT["armature"][
                int(model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE.value)
            ]
            ways.append(f"give it an armature of {inertia * flank / most:.2g} {unit}")
            ways.append(f"simulate in steps of {quantity(step, 's', 2)}")
        yield DataWarning(
            "soft_flank",
            f"{recording.name}, joint {model.joint(joint).name!r}",
            f"{' and '.join(parts)}, of a play of {quantity(play, 'm')}; more than"
            f" {quantity(most, 'm', 2)} is taken for a part of it",
            ", or ".join(ways),
        )


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
