"""Units of the sensors and controls of a model."""

from __future__ import annotations

from typing import Final

import mujoco

from tendon_mj.lab.units import UNKNOWN
from tendon_mj.plugin import KINDS, sensor_kind, servos

_PLACE, _RATE = 1, 2  # MuJoCo's `ctrlspec` of a servo

# sensor -> (unit of its reading on a hinge, on a slide)
_OF_JOINT: Final = {
    mujoco.mjtSensor.mjSENS_JOINTPOS: ("rad", "m"),
    mujoco.mjtSensor.mjSENS_JOINTVEL: ("rad/s", "m/s"),
    mujoco.mjtSensor.mjSENS_JOINTACTFRC: ("N m", "N"),
}
_OF_TENDON: Final = {  # through sites; one of joints is in whatever its coefficients say
    mujoco.mjtSensor.mjSENS_TENDONPOS: "m",
    mujoco.mjtSensor.mjSENS_TENDONVEL: "m/s",
    mujoco.mjtSensor.mjSENS_TENDONACTFRC: "N",
}


def reading_unit(model: mujoco.MjModel, sensor: int) -> str:
    """The unit of a sensor's reading; ``UNKNOWN`` where its kind does not say."""
    kind = sensor_kind(model, sensor)
    if kind:
        return KINDS[kind][1]
    seen, now = int(model.sensor_objid[sensor]), mujoco.mjtSensor(int(model.sensor_type[sensor]))
    if now in _OF_JOINT:
        return _OF_JOINT[now][int(model.jnt_type[seen] == mujoco.mjtJoint.mjJNT_SLIDE.value)]
    if now in _OF_TENDON:
        return UNKNOWN if _of_joints(model, seen) else _OF_TENDON[now]
    if now == mujoco.mjtSensor.mjSENS_ACTUATORFRC:
        force, *_ = _of_transmission(model, seen)
        return force if abs(model.actuator_gear[seen, 0]) == 1.0 else UNKNOWN  # others have a unit
    return "N" if now == mujoco.mjtSensor.mjSENS_TOUCH else UNKNOWN


def control_unit(model: mujoco.MjModel, actuator: int) -> str:
    """The unit of an actuator's control; ``UNKNOWN`` where its kind does not say.

    A reel's is tendon wound in, a servo of the package takes a tension, a motor a force or torque,
    MuJoCo's servos a place or a rate. Of other gains nobody knows, nor of tendons of joints.
    """
    plugin = int(model.actuator_plugin[actuator])
    if plugin >= 0:
        servo = model.plugin_stateadr[plugin] in servos(model).values()
        return "N" if servo else "m"
    force, place, rate_of = _of_transmission(model, actuator)
    if model.actuator_gaintype[actuator] != mujoco.mjtGain.mjGAIN_FIXED.value:
        return UNKNOWN  # a muscle's activation
    if model.actuator_ctrlspec[actuator]:  # of the shortcuts
        return {_PLACE: place, _RATE: rate_of}.get(int(model.actuator_ctrlspec[actuator]), UNKNOWN)
    if model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_INTEGRATOR.value:
        return UNKNOWN
    if model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE.value:
        return force
    gain, bias = model.actuator_gainprm[actuator, 0], model.actuator_biasprm[actuator]
    if gain == -bias[1]:
        return place
    return rate_of if bias[1] == 0.0 and gain == -bias[2] else UNKNOWN


def _of_transmission(model: mujoco.MjModel, actuator: int) -> tuple[str, str, str]:
    """Units of the force of an actuator, of a place and of a rate where it acts."""
    on, seen = int(model.actuator_trntype[actuator]), int(model.actuator_trnid[actuator, 0])
    if on in (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value):
        of_joint = {
            mujoco.mjtJoint.mjJNT_SLIDE.value: ("N", "m", "m/s"),
            mujoco.mjtJoint.mjJNT_HINGE.value: ("N m", "rad", "rad/s"),
        }
        return of_joint.get(int(model.jnt_type[seen]), (UNKNOWN,) * 3)
    if on == mujoco.mjtTrn.mjTRN_TENDON.value and not _of_joints(model, seen):
        return "N", "m", "m/s"
    return UNKNOWN, UNKNOWN, UNKNOWN


def _of_joints(model: mujoco.MjModel, tendon: int) -> bool:
    first = model.wrap_type[model.tendon_adr[tendon]]
    return bool(first == mujoco.mjtWrap.mjWRAP_JOINT.value)
