"""Checks of a sheath's configuration, once, while MuJoCo compiles the model.

This is the plugin's only Python, and it never runs in a step.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import mujoco

from tendon_mj.engine.abi.library import C
from tendon_mj.engine.abi.model_in_compilation import Draft, find, read_number
from tendon_mj.engine.sheath_plugin.attributes import ATTRIBUTES
from tendon_mj.engine.sheath_plugin.sensors import ENDS, KINDS, width
from tendon_mj.engine.sheath_plugin.sheath_of_tendon import by_tendon, sheath_on
from tendon_mj.engine.sheath_plugin.state import PARAMETERS, SENSOR_SIZE, size
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath.law import LAW, check_range, check_scales, check_static

NAME = "tendon_mj.sheath"
_OBJ, _WRAP, _JNT = mujoco.mjtObj, mujoco.mjtWrap, mujoco.mjtJoint
_COUNT = re.compile(r"[0-9]+")
SPOOL_ATTRIBUTES = ("tendon", "reel_joint", "sensor")  # what a servo asks about


def _read_number(config: dict[str, str], name: str, where: str) -> float | None:
    value = read_number(config, name, where)
    if value is None:
        return None
    if name in LAW:
        check_range(name, value, where)
    elif not math.isfinite(value) or value == 0.0:
        raise InvalidValueError(f"{where}: {name} = {value:g} [m] must be finite and not 0")
    return value


def _check_numbers(config: dict[str, str], where: str) -> None:
    numbers = {name: _read_number(config, name, where) for name in PARAMETERS}
    for name, parameter in LAW.items():
        if parameter.required and numbers[name] is None:
            raise InvalidValueError(f"{where}: {name} is missing (its unit is {parameter.unit})")
    friction, static = numbers["friction"], numbers["static_friction"]
    if friction is not None and static is not None:
        check_static(friction, static, where)
    check_scales(numbers, where)
    for end in ("reel", "output"):
        if bool(config[f"{end}_joint"]) != bool(config[f"{end}_radius"]):
            raise InvalidValueError(
                f"{where}: {end}_joint and {end}_radius go together, one of them is missing"
            )


def _capacity(model: Draft, config: dict[str, str], where: str) -> int:
    """Number of guides to allocate.

    MuJoCo asks before it has told its tendons which points they run through, so without `guides`
    all points of the model that other tendons need not have are counted.
    """
    if not config["guides"]:
        return max(0, int(model.fields.nwrap) - int(model.fields.ntendon) - 1)
    if not _COUNT.fullmatch(config["guides"]):
        raise InvalidValueError(f"{where}: guides = {config['guides']!r} is not a count")
    if len(config["guides"]) > 6:
        raise InvalidValueError(f"{where}: guides = {config['guides']} is more than 999999")
    return int(config["guides"])


def _find_spool(model: Draft, name: str, where: str) -> None:
    joints = int(model.fields.njnt)
    joint = find(model, _OBJ.mjOBJ_JOINT, joints, "joint", name, where)
    if model.ints("jnt_type")[joint] not in (_JNT.mjJNT_HINGE.value, _JNT.mjJNT_SLIDE.value):
        raise InvalidValueError(f"{where} {name!r} is no hinge or slide")


def state_size(address: int, instance: int) -> int:
    """Number of numbers of state that an instance needs; the first of all has all checked.

    Raises:
        InvalidValueError, UnknownNameError: what is wrong, where, and the nearest valid choice.
    """
    model = Draft(address, ATTRIBUTES)
    if model.is_first(instance):
        configs = {k: model.config(k) for k in model.siblings(instance)}
        sheaths = by_tendon(configs)
        for k, config in configs.items():
            _check_instance(model, k, config, sheaths)
    config = model.config(instance)
    if config["sensor"]:
        return SENSOR_SIZE
    return size(_capacity(model, config, model.where(instance)))


def _check_instance(
    model: Draft, instance: int, config: dict[str, str], sheaths: Mapping[str, Sequence[int]]
) -> None:
    """Check the configuration of one instance; ``sheaths`` are those of each tendon."""
    where = model.where(instance)
    tendons = int(model.fields.ntendon)
    find(model, _OBJ.mjOBJ_TENDON, tendons, "tendon", config["tendon"], where)
    rivals = [k for k in sheaths.get(config["tendon"], ()) if k != instance]
    if config["sensor"]:
        if config["sensor"] not in KINDS:
            raise UnknownNameError("sensor", config["sensor"], KINDS, where)
        extra = [k for k, v in config.items() if v and k not in ("sensor", "tendon")]
        if extra:
            raise InvalidValueError(f"{where}: a sensor takes no {extra[0]}; the sheath has it")
        if not rivals:
            raise UnknownNameError("sheathed tendon", config["tendon"], sheaths, where)
        return
    if rivals:
        raise InvalidValueError(
            f"{where}: tendon {config['tendon']!r} already runs in sheath "
            f"{model.name(_OBJ.mjOBJ_PLUGIN, rivals[0])!r}; a tendon has one sheath"
        )
    _check_numbers(config, where)
    for end in ("reel", "output"):
        if config[f"{end}_joint"]:
            _find_spool(model, config[f"{end}_joint"], f"{where}: {end}_joint")
    if C.strtod(b"0.5", None) != 0.5:
        raise InvalidValueError(f"{where}: the process's LC_NUMERIC has no decimal point")
    _capacity(model, config, where)


def sensor_size(address: int, instance: int, sensor: int) -> int:
    """Size of a sensor's reading; one on a sheath's own instance has T_in and T_out."""
    model = Draft(address, ATTRIBUTES)
    config = model.config(instance)
    if not config["sensor"]:
        return ENDS
    sheath = sheath_on(model, config["tendon"], NAME)
    if sheath is None:
        return 1
    return width(config["sensor"], _capacity(model, model.config(sheath), model.where(sheath)))


def check_tendon(address: int, instance: int) -> int:
    """Check, at the first instance, that all act on what they can, now that the model is complete.

    Raises:
        InvalidValueError: what is wrong with a tendon or a reel.
    """
    model = Draft(address, ATTRIBUTES)
    if model.is_first(instance):
        reels = model.actuators()
        for k in model.siblings(instance):
            _check_complete(model, k, reels.get(k, []))
    return 0


def _check_complete(model: Draft, instance: int, reels: Sequence[int]) -> None:
    """Check that a sheath can act on its tendon."""
    config = model.config(instance)
    _check_reels(model, instance, config, reels)
    if config["sensor"]:
        return
    where, name = model.where(instance), config["tendon"]
    tendons = int(model.fields.ntendon)
    tendon = find(model, _OBJ.mjOBJ_TENDON, tendons, "tendon", name, where)
    start, count = model.ints("tendon_adr")[tendon], model.ints("tendon_num")[tendon]
    for k in range(start, start + count):
        problem = _unsuited(model, model.ints("wrap_type")[k], model.ints("wrap_objid")[k])
        if problem:
            raise InvalidValueError(f"{where}: tendon {name!r} {problem}")
    stiffness = model.doubles("tendon_stiffness")[tendon]
    higher = model.doubles("tendon_stiffnesspoly")[2 * tendon : 2 * tendon + 2]
    if stiffness != 0.0 or any(higher):
        raise InvalidValueError(
            f"{where}: tendon {name!r} has a stiffness of its own, "
            f"{' '.join(f'{k:g}' for k in (stiffness, *higher))}, which would "
            "act beside the sheath's axial_stiffness; remove it"
        )
    if config["guides"] and int(config["guides"]) != count - 2:
        raise InvalidValueError(
            f"{where}: guides = {config['guides']}, but tendon {name!r} runs over {count - 2} "
            "between its ends; remove the attribute or correct it"
        )


def _check_reels(model: Draft, instance: int, config: dict[str, str], reels: Sequence[int]) -> None:
    """One reel at most, on the sheath and on its tendon."""
    names = ", ".join(repr(model.name(_OBJ.mjOBJ_ACTUATOR, k)) for k in reels)
    if config["sensor"] and reels:
        raise InvalidValueError(
            f"{model.where(instance)}: actuator {names} belongs on the sheath's instance, not on "
            "that of a sensor"
        )
    if len(reels) > 1:
        raise InvalidValueError(
            f"{model.where(instance)}: a sheath has one reel, not {len(reels)}: {names}"
        )
    for reel in reels:
        if model.ints("actuator_trntype")[reel] != mujoco.mjtTrn.mjTRN_TENDON.value:
            continue
        acts_on = model.name(_OBJ.mjOBJ_TENDON, model.ints("actuator_trnid")[2 * reel])
        if acts_on != config["tendon"]:
            raise InvalidValueError(
                f"{model.where(instance)}: reel {names} acts on tendon {acts_on!r}, the sheath "
                f"on {config['tendon']!r}; a config is not renamed when its model "
                "is attached to another: attach first, then add friction"
            )


def _unsuited(model: Draft, kind: int, index: int) -> str:
    """Why a tendon with such a point on its path cannot run in a sheath; empty if it can."""
    if kind == _WRAP.mjWRAP_SITE.value:
        return ""
    if kind == _WRAP.mjWRAP_JOINT.value:
        return "is a fixed tendon; only a spatial one runs in a sheath"
    if kind == _WRAP.mjWRAP_PULLEY.value:
        return "branches at a pulley; give each branch a tendon of its own"
    geom = model.name(_OBJ.mjOBJ_GEOM, index)
    return f"wraps around geom {geom!r}, which a sheath does not support yet; route it over sites"
