"""Servos of BAM, https://github.com/Rhoban/bam, whose files are JSON with the numbers of one model.

Which numbers a model has and what they mean is from bam/model.py there, and the voltage of a motor
from bam/actuator.py.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

import mujoco

from tendon_mj.attach.keywords import checked_number
from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import PARAMETERS
from tendon_mj.sheath import check_in_range

# Terms of friction → parameters of a sheath
_TERMS: Final = {
    "friction_base": ("servo_friction",),
    "friction_stribeck": ("servo_stribeck",),
    "dtheta_stribeck": ("servo_stribeck_velocity",),
    "alpha": ("servo_stribeck_exponent",),
    "load_friction_base": ("servo_motor_friction", "servo_load_friction"),
    "load_friction_stribeck": ("servo_motor_stribeck", "servo_load_stribeck"),
    "load_friction_motor": ("servo_motor_friction",),
    "load_friction_external": ("servo_load_friction",),
    "load_friction_motor_stribeck": ("servo_motor_stribeck",),
    "load_friction_external_stribeck": ("servo_load_stribeck",),
    "load_friction_motor_quad": ("servo_motor_square",),
    "load_friction_external_quad": ("servo_load_square",),
}
_STRIBECK: Final = ("friction_base", "friction_stribeck", "dtheta_stribeck", "alpha")
_LOAD = ("load_friction_motor", "load_friction_external")
_FADING, _SQUARE = ([term + end for term in _LOAD] for end in ("_stribeck", "_quad"))
_MODELS: Final = {
    "m1": ("friction_base",),
    "m2": _STRIBECK,
    "m3": ("friction_base", "load_friction_base"),
    "m4": (*_STRIBECK, "load_friction_base", "load_friction_stribeck"),
    "m5": (*_STRIBECK, *_LOAD, *_FADING),
    "m6": (*_STRIBECK, *_LOAD, *_FADING, *_SQUARE),
}
_NEEDED: Final = ("armature", "friction_viscous")
_KNOWN: Final = ("kt", "R", "q_offset", "model", "actuator")  # q_offset: the test bench's zero


class Servo(NamedTuple):
    """Numbers of a servo at its joint."""

    friction: dict[str, str]  # attributes of a sheath
    armature: float  # [kg m²]
    damping: float  # [N m s/rad]
    motor_constant: float  # [N m/A], 0 where it is not known
    resistance: float  # [Ω], likewise
    gain: float  # of its position controller [V/rad], 0 without one
    voltage: float  # largest that it gives the motor [V]


def read_servo(source: str | Path, gain: float, voltage: float) -> Servo:
    """Read a file; one is refused that has not the numbers of its model, or has others."""
    try:
        found = json.loads(Path(source).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidValueError(f"servo = '{source}' cannot be read: {error}") from None
    model = found.get("model") if isinstance(found, dict) else None
    if model not in _MODELS:
        raise InvalidValueError(f"{source}: model = {model!r} is none of {', '.join(_MODELS)}")
    needed = (*_MODELS[model], *_NEEDED)
    for problem, names in (
        ("lacks", [name for name in needed if name not in found]),
        ("has no use for", [name for name in found if name not in (*needed, *_KNOWN)]),
    ):
        if names:
            raise InvalidValueError(
                f"{source}: model {model!r} of BAM {problem} {', '.join(names)}: correct the file,"
                " and give the actuator what belongs to its controller"
            )
    friction = dict[str, str]()
    for term in _MODELS[model]:
        value = checked_number(f"{source}: {term}", found[term])
        for parameter in _TERMS[term]:
            check_in_range(PARAMETERS, parameter, value, f"{source}: {term}")
            friction |= {parameter: repr(value)} if value else {}
    motor = []
    for name in (*_NEEDED, "kt", "R"):
        motor.append(checked_number(f"{source}: {name}", found.get(name, 0.0)))
        if not 0.0 <= motor[-1] < math.inf:
            raise InvalidValueError(f"{source}: {name} = {motor[-1]:g} must be finite and ≥ 0")
    if (gain or voltage) and not min(*motor[2:], gain, voltage) > 0.0:
        raise InvalidValueError(
            f"servo_gain = {gain:g} [V/rad], servo_voltage = {voltage:g} [V], and kt = {motor[2]:g}"
            f" and R = {motor[3]:g} of {source} go together, all > 0: leave out both to keep the"
            " actuators as they are"
        )
    return Servo(friction, *[*motor, gain, voltage])


def control_by_voltage(
    spec: mujoco.MjSpec, actuators: Sequence[mujoco.MjsActuator], servo: Servo
) -> None:
    """Let actuators be DC motors, whose voltage follows from their controls, angles of joints.

    MuJoCo's controller asks for a torque, K/R of the voltage, and makes up for the motor's own
    damping K²/R, which is therefore its damping. Only a range of controls that were angles stays.
    """
    k, r = servo.motor_constant, servo.resistance
    if not hasattr(mujoco, "mjtCtrlInput"):
        raise InvalidValueError(
            f"servo_gain: mujoco {mujoco.__version__} has another controller of DC motors: install"
            " 3.12 or later, or leave it out"
        )
    for actuator in actuators:
        if abs(actuator.gear[0]) != 1.0:
            raise InvalidValueError(
                f"actuator {actuator.name!r} has gear = {actuator.gear[0]:g}, and the numbers of a"
                " servo are those at its joint: set gear to 1"
            )
    model = spec.compile()
    for actuator in actuators:
        controls_angle = actuator.biasprm[1] != 0.0
        actuator.ctrllimited = controls_angle and model.actuator_ctrllimited[actuator.id]
        actuator.ctrlrange, actuator.inheritrange = model.actuator_ctrlrange[actuator.id], 0.0
        actuator.set_to_dcmotor(
            motorconst=[k, k],
            resistance=r,
            controller=[servo.gain * k / r, 0.0, k * k / r, 0.0, 0.0, servo.voltage],
            ctrlspec=mujoco.mjtCtrlInput.mjINPUT_POS,
        )
