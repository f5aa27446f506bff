"""Puts a tension servo on the motor that winds a sheathed tendon in."""

from __future__ import annotations

from typing import Unpack

import mujoco
import numpy as np

from tendon_mj.attach.instances import add_instance, instances
from tendon_mj.attach.keywords import check_names, checked_number, one_of, takes
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import FEEDBACKS, GAINS, SERVO, OptionalGains, check_gain


@takes(GAINS)
def add_servo(
    spec: mujoco.MjSpec,
    tendon: str,
    *,
    tension_gain: float,
    velocity_gain: float,
    feedback: str = "sensor",
    backdrive: bool = False,
    name: str = "servo",
    **gains: Unpack[OptionalGains],
) -> mujoco.MjsActuator:
    """Let a motor servo the output tension of a tendon, its control the reference T_r [N].

    J_m θ̈ + G_v θ̇ = G_t r (T_r − T_out), with r the sheath's reel radius and θ its reel joint.

    Args:
        spec: changed in place.
        tendon: name of a tendon in a sheath with a ``reel_joint``.
        <parameters>
        feedback: ``sensor``, T_out itself, or ``observer``, T̂_out computed from T_in.
        backdrive: whether the tendon can turn the motor through its gear.
        name: of the actuator and of the plugin instance.

    Returns:
        The actuator.

    Raises:
        UnknownNameError: no such tendon, or it has no sheath; no such gain or feedback.
        InvalidValueError: a value that is not a number, outside its range, or not True or False; a
            sheath without a reel joint. Bounds that depend on the whole model, such as the damping
            that a `period` allows, are checked when it is compiled.
    """
    sheaths = {c.get("tendon", ""): (p, c) for p, c in instances(spec) if "sensor" not in c}
    if not isinstance(tendon, str) or tendon not in sheaths:
        raise UnknownNameError("sheathed tendon", str(tendon), sheaths, f"servo {name!r}")
    where, (sheath, wound) = f"servo {name!r}", sheaths[tendon]
    joint = wound.get("reel_joint")
    if not joint:
        raise InvalidValueError(
            f"{where}: the sheath on tendon {tendon!r} has no reel_joint for it to turn"
        )
    check_names(GAINS, gains, where)
    one_of("feedback", feedback, FEEDBACKS, where)
    if not isinstance(backdrive, bool | np.bool_):
        raise InvalidValueError(f"{where}: backdrive = {backdrive!r} must be True or False")
    values = {"tension_gain": tension_gain, "velocity_gain": velocity_gain, **gains}
    config: dict[str, str | float | None] = {}
    for key, value in values.items():
        if value is not None:
            gain = checked_number(f"{where}: {key}", value, f" [{GAINS[key].unit}]")
            check_gain(key, gain, where)
            config[key] = gain
    words = {"tendon": sheath.config.get("tendon", ""), "feedback": feedback}
    words["backdrive"] = "true" if backdrive else "false"
    spec.activate_plugin(SERVO)
    instance = add_instance(spec, name, config | words, SERVO)
    actuator = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
    actuator.plugin = instance
    return actuator
