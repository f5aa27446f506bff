"""Units of recorded and simulated quantities: columns, joints, live parameters of the plugins."""

from __future__ import annotations

from typing import Final

import mujoco

from tendon_mj.lab.recordings import UNITS
from tendon_mj.lab.replay.live_parameters import DRAWN_BEND
from tendon_mj.plugin import GAINS, KINDS, PARAMETERS, sensor_kind, servos

_PLACE, _RATE = 1, 2  # MuJoCo's `ctrlspec` of a servo
UNKNOWN: Final = "1"  # of a reading or a control that no column names
_WRITTEN = {"Nm": "N m", "rad_per_s": "rad/s", "m_per_s": "m/s"}

# parameter -> (unit on a hinge, unit on a slide)
JOINT: Final[dict[str, tuple[str, str]]] = {
    "stiffness": ("N m/rad", "N/m"),
    "damping": ("N m s/rad", "N s/m"),
    "frictionloss": ("N m", "N"),
    "armature": ("kg m²", "kg"),
    "springref": ("rad", "m"),
}
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


def column_unit(column: str) -> str:
    """The unit that a column's name ends in: ``joint_rad`` is in `rad`; empty without one."""
    unit = _ending(column).removeprefix("_")
    return _WRITTEN.get(unit, unit)


def column_name(column: str) -> str:
    """A column's name in words, without its unit: ``tip_speed_m_per_s`` is `tip speed`."""
    return column.removesuffix(_ending(column)).replace("_", " ")


def reading_unit(model: mujoco.MjModel, sensor: int) -> str:
    """The unit of a sensor's reading; ``UNKNOWN`` where its kind does not say."""
    kind = sensor_kind(model, sensor)
    if kind:
        return KINDS[kind][1]
    seen, now = int(model.sensor_objid[sensor]), mujoco.mjtSensor(int(model.sensor_type[sensor]))
    if now in _OF_JOINT:
        return _OF_JOINT[now][int(model.jnt_type[seen] == mujoco.mjtJoint.mjJNT_SLIDE.value)]
    if now in _OF_TENDON:
        first = model.wrap_type[model.tendon_adr[seen]]
        return UNKNOWN if first == mujoco.mjtWrap.mjWRAP_JOINT.value else _OF_TENDON[now]
    return "N" if now == mujoco.mjtSensor.mjSENS_TOUCH else UNKNOWN


def control_unit(model: mujoco.MjModel, actuator: int) -> str:
    """The unit of an actuator's control; ``UNKNOWN`` where its kind does not say.

    A reel's is tendon wound in, a servo of the package takes a tension, a motor a force or torque,
    MuJoCo's servos a place or a rate. Of other gains nobody knows, nor of tendons of joints.
    """
    plugin = int(model.actuator_plugin[actuator])
    if plugin >= 0:
        servo = model.plugin_stateadr[plugin] in {found.state for found in servos(model).values()}
        return "N" if servo else "m"
    on = int(model.actuator_trntype[actuator])
    if on in (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value):
        joint = int(model.actuator_trnid[actuator, 0])
        slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE.value
        force, place, rate_of = ("N", "m", "m/s") if slides else ("N m", "rad", "rad/s")
    elif on == mujoco.mjtTrn.mjTRN_TENDON.value and _through_sites(model, actuator):
        force, place, rate_of = "N", "m", "m/s"
    else:
        return UNKNOWN
    if model.actuator_gaintype[actuator] != mujoco.mjtGain.mjGAIN_FIXED.value:
        return UNKNOWN  # a muscle's activation
    if model.actuator_ctrlspec[actuator]:  # the shortcuts say what they take
        return {_PLACE: place, _RATE: rate_of}.get(int(model.actuator_ctrlspec[actuator]), UNKNOWN)
    if model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_INTEGRATOR.value:
        return UNKNOWN
    if model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE.value:
        return force
    gain, bias = model.actuator_gainprm[actuator, 0], model.actuator_biasprm[actuator]
    if gain == -bias[1]:
        return place
    return rate_of if bias[1] == 0.0 and gain == -bias[2] else UNKNOWN


def _through_sites(model: mujoco.MjModel, actuator: int) -> bool:
    """Whether an actuator's tendon is spatial, and none of joints."""
    tendon = int(model.actuator_trnid[actuator, 0])
    first = model.wrap_type[model.tendon_adr[tendon]]
    return bool(first != mujoco.mjtWrap.mjWRAP_JOINT.value)


def ending_of(unit: str) -> str:
    """How the name of a column in a unit of SI ends; empty where names have no such unit."""
    return {column_unit(ending): ending for ending in UNITS}.get(unit, "")


def name_in(unit: str, column: str) -> str:
    """A column's name as it would be in another unit; empty where names have no such unit."""
    ending = ending_of(unit)
    return column.removesuffix(_ending(column)) + ending if ending else ""


def _ending(column: str) -> str:
    """The longest unit, as names have it, that a column ends in."""
    return max((ending for ending in UNITS if column.endswith(ending)), key=len, default="")


def live_unit(parameter: str) -> str:
    """The unit of a sheath's parameter or a servo's gain."""
    if parameter == DRAWN_BEND:
        return "rad"
    known = PARAMETERS | GAINS
    return known[parameter].unit if parameter in known else UNKNOWN


def rate(unit: str) -> str:
    """A unit per second; one already per second is told with a square."""
    return f"{unit}²" if unit.endswith("/s") else f"{unit}/s"
