"""Puts a tension servo on the motor that winds a sheathed tendon in."""

from __future__ import annotations

import mujoco

from tendon_mj.attach.instance import add_instance
from tendon_mj.engine import FEEDBACKS, NAME, SERVO, check_gain
from tendon_mj.errors import InvalidValueError, UnknownNameError


def add_servo(
    spec: mujoco.MjSpec,
    tendon: str,
    *,
    tension_gain: float,
    velocity_gain: float,
    loosening_tension_gain: float | None = None,
    loosening_velocity_gain: float | None = None,
    motor_inertia: float | None = None,
    torque_limit: float | None = None,
    speed_limit: float | None = None,
    period: float | None = None,
    delay: float | None = None,
    feedback: str = "sensor",
    observer_friction: float | None = None,
    output_stiffness: float | None = None,
    backlash_feedforward: float | None = None,
    rate_feedforward: float | None = None,
    reversal_band: float | None = None,
    backdrive: bool = False,
    name: str = "servo",
) -> mujoco.MjsActuator:
    """Let a motor servo the output tension of a tendon, its control the reference T_r [N].

    J_m θ̈ + G_v θ̇ = G_t r (T_r − T_out), with r the sheath's reel radius and θ its reel joint.

    Args:
        spec: changed in place.
        tendon: name of a tendon in a sheath with a ``reel_joint``.
        tension_gain: G_t [-].
        velocity_gain: G_v [N m s/rad].
        loosening_tension_gain, loosening_velocity_gain: gains while the motor pays out; default:
            the same as while it pulls.
        motor_inertia: J_m [kg m²]; default: the joint's armature.
        torque_limit: [N m]; default: none.
        speed_limit: [rad/s]; default: none.
        period: between samples of the controller [s]; default: every time step.
        delay: from a sample to its torque [s].
        feedback: ``sensor``, T_out itself, or ``observer``, T̂_out computed from T_in.
        observer_friction: μ that observer and feed-forward go by [-]; default: the sheath's.
        output_stiffness: k_se that the feed-forward goes by [N/m]; default: rigid.
        backlash_feedforward: 1 crosses the backlash at once when T_r turns back, 0 does not [-].
        rate_feedforward: 1 lends the motor the speed that a changing T_r asks for, 0 does not [-].
        reversal_band: by how much T_r has to go back to count as turned [N].
        backdrive: whether the tendon can turn the motor through its gear.
        name: of the actuator and of the plugin instance.

    Returns:
        The actuator.

    Raises:
        UnknownNameError: no such tendon, or it has no sheath; no such feedback.
        InvalidValueError: a value outside its range, or a sheath without a reel joint.
    """
    sheaths = {
        p.config["tendon"]: p.config
        for p in spec.plugins
        if p.plugin_name == NAME and "sensor" not in p.config
    }
    if tendon not in sheaths:
        raise UnknownNameError("sheathed tendon", tendon, sheaths, f"servo {name!r}")
    joint = sheaths[tendon].get("reel_joint")
    if not joint:
        raise InvalidValueError(
            f"servo {name!r}: the sheath on tendon {tendon!r} has no reel_joint for it to turn"
        )
    if feedback not in FEEDBACKS:
        raise UnknownNameError("feedback", feedback, FEEDBACKS, f"servo {name!r}")
    config: dict[str, str | float | None] = {
        "tension_gain": tension_gain,
        "velocity_gain": velocity_gain,
        "loosening_tension_gain": loosening_tension_gain,
        "loosening_velocity_gain": loosening_velocity_gain,
        "motor_inertia": motor_inertia,
        "torque_limit": torque_limit,
        "speed_limit": speed_limit,
        "period": period,
        "delay": delay,
        "observer_friction": observer_friction,
        "output_stiffness": output_stiffness,
        "backlash_feedforward": backlash_feedforward,
        "rate_feedforward": rate_feedforward,
        "reversal_band": reversal_band,
    }
    for gain, value in config.items():
        if isinstance(value, int | float):
            check_gain(gain, value, f"servo {name!r}")
    words = {"tendon": tendon, "feedback": feedback, "backdrive": "true" if backdrive else "false"}
    spec.activate_plugin(SERVO)
    instance = add_instance(spec, name, config | words, SERVO)
    actuator = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
    actuator.plugin = instance
    return actuator
