"""Parts of a rig in which an effect has its cause, for who wants to be rid of it."""

from __future__ import annotations

from typing import Final

_LINING, _CABLE = "the sheath and its lining", "the cable"
_JOINT, _SENSOR = "the bearings of the joint", "the sensor, its amplifier and its filter"
# identifier of an effect → where to look
PARTS: Final = {
    "sheath_friction": _LINING,
    "static_friction": _LINING,
    "velocity_weakening": _LINING,
    "viscous_friction": f"{_LINING}, and what lubricates it",
    "constant_friction": f"{_LINING}, seals and pulleys",
    "direction_asymmetry": f"{_LINING}, and where the cable enters and leaves it",
    "position_dependent_friction": "where the cable rubs most: a kink, a worn or dirty place",
    "friction_drift": f"{_LINING}, for heat and wear",
    "backlash": "the spool on its shaft, the coupling and the gear before the cable, and its ends",
    "stiffening": _CABLE,
    "creep": _CABLE,
    "sheath_compliance": "the brackets that hold the sheath",
    "joint_damping": _JOINT,
    "joint_friction": _JOINT,
    "sensor_bias": "the sensor's zero",
    "sensor_gain": "the sensor's calibration",
    "sensor_delay": _SENSOR,
    "sensor_lag": _SENSOR,
    "sensor_drift": "the sensor's zero, for heat",
    "gear_efficiency": "the gear before the motor whose current is read; a load cell has none",
    "slip": "where the cable is held on its drum, the coupling, and lost counts of the encoder",
    "command_delay": "the drive and its clock",
}
