"""Checks of a servo's configuration, once, while MuJoCo compiles the model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import mujoco

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin.abi.checks import Draft, find, read_number
from tendon_mj.plugin.abi.library import RK4
from tendon_mj.plugin.servo_plugin import state as sv
from tendon_mj.plugin.servo_plugin.state import GAINS, check_gain
from tendon_mj.plugin.sheath_plugin.names import check_own_names, own_config, sheath_on, sheaths_of
from tendon_mj.plugin.sheath_plugin.validate import NAME as SHEATH
from tendon_mj.plugin.sheath_plugin.validate import SPOOL_ATTRIBUTES

_RUNGE_KUTTA = 2.785293563405282  # where |1 + z + z²/2 + z³/6 + z⁴/24| = 1 on the negative axis


def largest_damping(timestep: float, integrator: int, period: float, delay: float) -> float:
    """Rate G_v/J [1/s] from which on damping makes the motor swing up instead; may be without end.

    Args:
        timestep: [s].
        integrator: MuJoCo's number of it.
        period: between samples of the controller [s]; 0: every time step.
        delay: from a sample to its torque [s].
    """
    if period > 0.0 or delay > 0.0:  # a torque changes on time steps only
        return sampled_damping(max(period, timestep), math.ceil(delay / timestep - 1e-6) * timestep)
    return _RUNGE_KUTTA / timestep if integrator == RK4 else math.inf


def sampled_damping(held: float, delay: float) -> float:
    """Like ``largest_damping`` where every torque is held for a while [1/s].

    v_{k+1} = v_k − g ((1 − m) v_{k−d} + m v_{k−d−1}) with g = held G_v/J and delay = (d + m) held:
    the least g for which a root lies on the unit circle, z = e^{iω}. That is 2/held without a delay
    and tends to π/(2 delay) with a long one.

    Args:
        held: [s].
        delay: from a sample to its torque [s].
    """
    whole = math.floor(delay / held + 1e-9)
    part = max(delay / held - whole, 0.0)

    def phase(angle: float) -> float:
        late = math.atan2(part * math.sin(angle), 1.0 - part + part * math.cos(angle))
        return (whole + 0.5) * angle + late - 0.5 * math.pi

    low, high = 0.0, math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if phase(middle) >= 0.0 else (middle, high)
    size = math.hypot(1.0 - part + part * math.cos(high), part * math.sin(high))
    return 2.0 * math.sin(0.5 * high) / (size * held)


SERVO = "tendon_mj.servo"
_OBJ = mujoco.mjtObj


def _check_word(config: dict[str, str], name: str, known: Iterable[str], where: str) -> None:
    if config[name] and config[name] not in known:
        raise UnknownNameError(name, config[name], known, where)


def _sheath_of(model: Draft, tendon: str, where: str) -> dict[str, str]:
    """Configuration of the sheath on a tendon."""
    count = model.ntendon
    find(model, _OBJ.mjOBJ_TENDON, count, "tendon", tendon, where)
    sheath = sheath_on(model, tendon, SHEATH)
    if sheath is None:
        raise UnknownNameError("sheathed tendon", tendon, sheaths_of(model, SHEATH), where)
    return own_config(Draft(model.address, SPOOL_ATTRIBUTES), sheath)


def state_size(address: int, instance: int) -> int:
    """Check an instance and return how many numbers of state it needs.

    Raises:
        InvalidValueError, UnknownNameError: name the place, the value and the nearest valid one.
    """
    model = Draft(address, sv.ATTRIBUTES)
    where, config = model.where(instance), own_config(model, instance)
    values = {name: read_number(config, name, where) for name in GAINS}
    for name, value in values.items():
        if value is not None:
            check_gain(name, value, where)
        elif GAINS[name].required:
            raise InvalidValueError(f"{where}: {name} is missing (its unit is {GAINS[name].unit})")
    _check_word(config, "feedback", sv.FEEDBACKS, where)
    _check_word(config, "backdrive", sv.SWITCH, where)
    sheath = _sheath_of(model, config["tendon"], where)
    if not sheath["reel_joint"]:
        raise InvalidValueError(
            f"{where}: the sheath on tendon {config['tendon']!r} has no reel_joint that a motor "
            "could turn; give it reel_joint and reel_radius"
        )
    period, delay = values["period"] or 0.0, values["delay"] or 0.0
    commands = sv.capacity(period, delay, model.opt.timestep)
    if commands > sv.MOST_COMMANDS:
        raise InvalidValueError(
            f"{where}: delay = {delay:g} [s] is more than {sv.MOST_COMMANDS} samples to remember"
        )
    return sv.size_of(commands)


def check_joint(address: int, instance: int) -> int:
    """Check, at the first servo, that each drives its tendon's motor; the model is complete.

    Raises:
        InvalidValueError: names the actuator or joint.
    """
    model = Draft(address, sv.ATTRIBUTES)
    if model.first(instance) == instance:
        actuators = model.actuators()
        servos: dict[str, list[int]] = {}  # that have an actuator, of each tendon
        instances = model.siblings(instance)
        check_own_names(model, instances)
        for k in sorted(instances, key=lambda k: actuators.get(k, [0])[0]):
            if k in actuators:
                servos.setdefault(own_config(model, k)["tendon"], []).append(k)
        for k in instances:
            _check_servo(model, k, actuators.get(k, []), servos)
    return 0


def _check_servo(
    model: Draft, instance: int, mine: Sequence[int], servos: Mapping[str, Sequence[int]]
) -> None:
    """Check a servo; ``mine`` are its actuators, ``servos`` those of each tendon."""
    where, config = model.where(instance), own_config(model, instance)
    wanted = _sheath_of(model, config["tendon"], where)["reel_joint"]
    if len(mine) > 1:
        raise InvalidValueError(
            f"{where}: {len(mine)} actuators share it; a servo drives one motor"
        )
    for actuator in mine:
        _check_actuator(model, actuator, wanted, where)
        _check_rivals(model, instance, config["tendon"], servos, where)
    joints = model.njnt
    joint = find(model, _OBJ.mjOBJ_JOINT, joints, "joint", wanted, where)
    armature = model.dof_armature[model.jnt_dofadr[joint]]
    if not config["motor_inertia"] and not armature > 0.0:
        raise InvalidValueError(
            f"{where}: motor_inertia [kg m²] is missing, and joint {wanted!r} has no armature "
            "to take its place"
        )
    _check_damping(model, instance, read_number(config, "motor_inertia", where) or armature)


def _check_damping(model: Draft, instance: int, inertia: float) -> None:
    """Damping that is not taken implicitly has a largest value."""
    where, config = model.where(instance), model.config(instance)
    step, integrator = model.opt.timestep, model.opt.integrator
    period, delay = (read_number(config, name, where) or 0.0 for name in ("period", "delay"))
    most = inertia * largest_damping(step, integrator, period, delay)
    how = f"period = {period:g} s and delay = {delay:g} s" if period or delay else "RK4"
    for name in ("velocity_gain", "loosening_velocity_gain"):
        value = read_number(config, name, where) or 0.0
        if value >= most:
            raise InvalidValueError(
                f"{where}: {name} = {value:g} [N m s/rad] makes the motor swing up instead of "
                f"damping it: with {how}, a time step of {step:g} s and motor_inertia = "
                f"{inertia:g} kg m² it must be < {most:.3g}"
            )


def _check_rivals(
    model: Draft, instance: int, tendon: str, servos: Mapping[str, Sequence[int]], where: str
) -> None:
    """Two servos would both hold the gear, and the tension with it."""
    for other in servos[tendon]:
        if other != instance:
            raise InvalidValueError(
                f"{where}: tendon {tendon!r} already has servo "
                f"{model.name(_OBJ.mjOBJ_PLUGIN, other)!r}; a motor has one"
            )


def _check_actuator(model: Draft, actuator: int, wanted: str, where: str) -> None:
    name = model.name(_OBJ.mjOBJ_ACTUATOR, actuator)
    joint = ""
    if model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT.value:
        joint = model.name(_OBJ.mjOBJ_JOINT, model.actuator_trnid[actuator, 0])
    if joint != wanted:
        drives = f"joint {joint!r}" if joint else "no joint"
        raise InvalidValueError(
            f"{where}: actuator {name!r} drives {drives}, but the tendon is wound in by joint "
            f"{wanted!r}, the sheath's reel_joint"
        )
    gear = model.actuator_gear[actuator, 0]
    if gear != 1.0:
        raise InvalidValueError(
            f"{where}: actuator {name!r} has gear = {gear:g}; it must be 1, a gear belongs into "
            "motor_inertia and the gains"
        )
    if model.actuator_forcelimited[actuator]:
        raise InvalidValueError(
            f"{where}: actuator {name!r} has a forcerange, which would also limit what the gear "
            "holds; use torque_limit"
        )
