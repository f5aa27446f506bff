"""What friction costs the finger per step, over the same finger with MuJoCo's own tendons."""

from __future__ import annotations

import time

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.builders.finger import TENDONS, Finger, spool_angles
from tendon_mj.builders.finger_spec import build_finger
from tendon_mj.finger.control import OUT_OF_REACH
from tendon_mj.finger.trajectories import Trajectory
from tendon_mj.replay.rollout import full_state, rollout_sensors

Array = NDArray[np.float64]


def frictionless_spec(finger: Finger) -> mujoco.MjSpec:
    """The finger with MuJoCo's spatial tendons in place of sheaths.

    A tendon of MuJoCo knows no spool, so its first site rides on a slide with the spool's inertia,
    damping and servo, all carried over by its radius: ξ = r θ. The tension sensors go.
    """
    spec = build_finger(finger)
    lengths = dict(zip(TENDONS, spec.compile().tendon_length0, strict=True))
    for sensor in [s for s in spec.sensors if s.type == mujoco.mjtSensor.mjSENS_PLUGIN]:
        spec.delete(sensor)
    for plugin in list(spec.plugins):
        spec.delete(plugin)
    r = finger.spool_radius
    for name, length in lengths.items():
        unstretched = length / (1.0 + finger.pretension / finger.axial_stiffness)
        tendon = spec.tendon(name)
        tendon.stiffness[0] = finger.axial_stiffness / unstretched
        tendon.springlength = [0.0, unstretched]
        body, joint = spec.body(f"{name}_motor"), spec.joint(f"{name}_motor")
        body.mass = 1e-9  # a spool's does not move
        body.inertia = np.full(3, 1e-12)
        joint.type, joint.axis = mujoco.mjtJoint.mjJNT_SLIDE, [-1.0, 0.0, 0.0]
        joint.armature, joint.damping[0] = joint.armature / r**2, joint.damping[0] / r**2
        site = spec.site(f"{name}_sheath_0")
        place = np.array(site.pos) - np.array(body.pos)
        spec.delete(site)
        body.add_site(name=f"{name}_sheath_0", pos=place)
        servo = spec.actuator(f"{name}_angle")
        servo.gainprm[0] /= r
        servo.biasprm[:3] = np.array(servo.biasprm[:3]) / [r, r**2, r**2]
        servo.forcerange = np.array(servo.forcerange) / r
        spec.actuator(f"{name}_torque").gear[0] = finger.gear / r
    return spec


def without_tension_sensors(finger: Finger) -> mujoco.MjSpec:
    """The finger with its friction, without sensors that the frictionless one cannot have.

    The one that refers to a sheath stays: MuJoCo would delete the sheath with it.
    """
    spec = build_finger(finger)
    views = [s for s in spec.sensors if s.name.endswith("_tension")]
    for sensor in views:
        spec.delete(sensor)
    for view in [p for p in spec.plugins if "sensor" in p.config]:
        spec.delete(view)
    return spec


def spool_commands(model: mujoco.MjModel, finger: Finger, trajectory: Trajectory) -> Array:
    """(steps, nu) controls of a model's position servos for a trajectory of joint angles."""
    time = np.arange(0.0, trajectory.time[-1], model.opt.timestep)
    columns = [np.interp(time, trajectory.time, c) for c in trajectory.columns.values()]
    control = np.zeros((len(time), model.nu))
    for tendon, turned in spool_angles(finger, np.stack(columns, axis=-1)).items():
        control[:, model.actuator(f"{tendon}_angle").id] = turned
    return control


def step_cost(finger: Finger, trajectory: Trajectory, *, rounds: int = 7) -> tuple[float, float]:
    """Time of a step with friction and without, along one trajectory, taken in turns.

    Args:
        finger: its numbers.
        trajectory: of joint angles.
        rounds: of which the median counts.

    Returns:
        Seconds per step of the finger, and of the frictionless one.
    """
    models = [without_tension_sensors(finger).compile(), frictionless_spec(finger).compile()]
    spent: list[list[float]] = [[], []]
    for _ in range(rounds):
        for k, model in enumerate(models):
            data = mujoco.MjData(model)
            if trajectory.aside:
                model.qpos_spring[model.joint("object").qposadr[0]] = OUT_OF_REACH
            start = full_state(model, data)[None]
            control = spool_commands(model, finger, trajectory)
            before = time.perf_counter()
            rollout_sensors(model, [data], start, control[None])
            spent[k].append((time.perf_counter() - before) / len(control))
    return float(np.median(spent[0])), float(np.median(spent[1]))
