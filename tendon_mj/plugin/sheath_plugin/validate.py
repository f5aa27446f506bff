"""Checks of the configurations of sheaths and of their sensors, while MuJoCo compiles the model.

This is the plugin's only Python, and it never runs in a step.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin.abi.checks import Draft, find, read_number
from tendon_mj.plugin.sheath_plugin.attributes import (
    ATTRIBUTES,
    ENDS,
    INPUT_ENDS,
    KINDS,
    SPRINGS,
    is_one_number,
    numbers_of,
)
from tendon_mj.plugin.sheath_plugin.names import (
    by_tendon,
    check_own_names,
    own_config,
    sheath_on,
    sheaths_of,
)
from tendon_mj.plugin.sheath_plugin.path import NOT_GIVEN, capacity
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS, size_of
from tendon_mj.plugin.sheath_plugin.validate_tendon import (
    DRIVE,
    UNDRAWN,
    check_alone,
    check_awake,
    check_counts,
    check_drive,
    check_elastic,
    check_reels,
    kinds_on,
    misplaced_input,
    read_drive,
    sleeps,
    unsuited,
)
from tendon_mj.plugin.sheath_plugin.visualize import check_tension_scale
from tendon_mj.sheath import LAW, check_range, check_scales, check_static

NAME = "tendon_mj.sheath"
_OBJ, _JNT = mujoco.mjtObj, mujoco.mjtJoint
_COUNT = re.compile(r"[0-9]+")
# numbers of state of all sheaths: 128 MiB in each mjData, a third of a million guides
_MOST = 2**24
# Attributes that all but the first check of an instance read.
_PLACE = ("tendon", "sensor", "guides", "arc_guides", "inner_guides")
_COMPLETE = (*_PLACE, "input_end", *DRIVE, *UNDRAWN)
SPOOL_ATTRIBUTES = ("tendon", "reel_joint", "sensor")  # which a servo reads


def _check_sensor(
    config: Mapping[str, str], sheaths: Mapping[str, Sequence[int]], where: str
) -> None:
    """Check the configuration of an instance with `sensor`; ``sheaths`` are those of each tendon.

    Raises:
        InvalidValueError, UnknownNameError: name the place, the value and the nearest valid one.
    """
    kind, tendon = config["sensor"], config["tendon"]
    if kind not in KINDS:
        raise UnknownNameError("sensor", kind, KINDS, where)
    extra = [k for k, v in config.items() if v and k not in ("sensor", "tendon", "instance")]
    if extra:
        raise InvalidValueError(f"{where}: a sensor takes no {extra[0]}; the sheath has it")
    if tendon and tendon not in sheaths:
        raise UnknownNameError("sheathed tendon", tendon, sheaths, where)
    if not tendon and not is_one_number(kind):
        raise InvalidValueError(
            f"{where}: tendon is missing, on whose sheath the size of a sensor of {kind} depends"
        )


def _check_objects(model: Draft, instance: int, config: Mapping[str, str]) -> None:
    """Check that each sensor of an instance shows the sheath on one tendon; the model is complete.

    Raises:
        InvalidValueError: a sensor without a tendon, or with two.
        UnknownNameError: its tendon has no sheath.
    """
    sheathed = [] if config["tendon"] else list(sheaths_of(model, NAME))
    for sensor in np.flatnonzero(model.sensor_plugin == instance):
        where = f"{model.where(instance)}: sensor {model.name(_OBJ.mjOBJ_SENSOR, sensor)!r}"
        kind, shown = model.sensor_objtype[sensor], model.sensor_objid[sensor]
        on_tendon = kind == _OBJ.mjOBJ_TENDON.value
        tendon = model.name(_OBJ.mjOBJ_TENDON, shown) if on_tendon else ""
        if config["tendon"]:
            if kind != _OBJ.mjOBJ_UNKNOWN.value and tendon != config["tendon"]:
                raise InvalidValueError(
                    f"{where} has another object than tendon {config['tendon']!r}, which its "
                    "configuration names; remove one of them"
                )
        elif not on_tendon:
            raise InvalidValueError(
                f'{where} shows {config["sensor"]} of no tendon: give it objtype="tendon" and '
                "the tendon's name as objname, or its configuration the attribute tendon"
            )
        elif tendon not in sheathed:
            raise UnknownNameError("sheathed tendon", tendon, sheathed, where)


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
        # a sheath that is driven does without a stiffness; which are is not known yet
        if parameter.required and numbers[name] is None and name != "axial_stiffness":
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


def _count(config: dict[str, str], name: str, default: int, where: str) -> int:
    if not config[name]:
        return default
    if not _COUNT.fullmatch(config[name]):
        raise InvalidValueError(f"{where}: {name} = {config[name]!r} is not a count")
    if len(config[name]) > 6:
        raise InvalidValueError(f"{where}: {name} = {config[name]} is more than 999999")
    return int(config[name])


def _capacity(model: Draft, config: dict[str, str], where: str) -> tuple[int, int]:
    """Numbers of guides and of arcs to allocate."""
    each = _count(config, "arc_guides", NOT_GIVEN, where)
    if each == 0:
        raise InvalidValueError(f"{where}: arc_guides = {each} must be 1 or more")
    guides = _count(config, "guides", NOT_GIVEN, where)
    return capacity(model, guides, each, _count(config, "inner_guides", 0, where))


def _find_spool(model: Draft, name: str, where: str) -> None:
    joints = model.njnt
    joint = find(model, _OBJ.mjOBJ_JOINT, joints, "joint", name, where)
    if model.jnt_type[joint] not in (_JNT.mjJNT_HINGE.value, _JNT.mjJNT_SLIDE.value):
        raise InvalidValueError(f"{where} {name!r} is not a hinge or slide")


def state_size(address: int, instance: int) -> int:
    """Numbers of state of an instance; with the first instance all are checked.

    Raises:
        InvalidValueError, UnknownNameError: name the place, the value and the nearest valid one.
    """
    model = Draft(address, ATTRIBUTES)
    if model.first(instance) == instance:
        configs = {k: own_config(model, k) for k in model.siblings(instance)}
        sheaths = by_tendon(configs)
        for k, config in configs.items():
            _check_instance(model, k, config, sheaths)
        _check_size(model, {k: c for k, c in configs.items() if not c["sensor"]})
    model = Draft(address, _PLACE)
    config = model.config(instance)
    if config["sensor"]:
        return 1  # none is used
    return _state_size(model, config, instance)


def _state_size(model: Draft, config: dict[str, str], instance: int) -> int:
    first = next(k for k in model.siblings(instance) if not model.config(k)["sensor"])
    dofs = model.nv if first == instance else 0
    return size_of(*_capacity(model, config, model.where(instance)), dofs)


def _check_instance(
    model: Draft, instance: int, config: dict[str, str], sheaths: Mapping[str, Sequence[int]]
) -> None:
    """Check the configuration of one instance; ``sheaths`` are those of each tendon."""
    where = model.where(instance)
    tendons = model.ntendon
    if config["tendon"] or not config["sensor"]:
        find(model, _OBJ.mjOBJ_TENDON, tendons, "tendon", config["tendon"], where)
    rivals = [k for k in sheaths.get(config["tendon"], ()) if k != instance]
    if config["sensor"]:
        _check_sensor(config, sheaths, where)
        return
    if rivals:
        raise InvalidValueError(
            f"{where}: tendon {config['tendon']!r} already runs in sheath "
            f"{model.name(_OBJ.mjOBJ_PLUGIN, rivals[0])!r}; a tendon has one sheath"
        )
    _check_numbers(config, where)
    if config["input_end"] not in ("", *INPUT_ENDS):
        raise UnknownNameError("input_end", config["input_end"], INPUT_ENDS, where)
    if config["spring"] not in ("", *SPRINGS):
        raise UnknownNameError("spring", config["spring"], SPRINGS, where)
    for end in ("reel", "output"):
        if config[f"{end}_joint"]:
            _find_spool(model, config[f"{end}_joint"], f"{where}: {end}_joint")
    _capacity(model, config, where)


def _check_size(model: Draft, configs: Mapping[int, dict[str, str]]) -> None:
    """Refuse sheaths that would fill memory: MuJoCo counts all numbers of state in 32 bits."""
    guides = {k: _capacity(model, config, model.where(k)) for k, config in configs.items()}
    sizes = {k: size_of(*counts, model.nv) for k, counts in guides.items()}
    total = sum(sizes.values())
    if total > _MOST:
        largest = max(sizes, key=sizes.__getitem__)
        given = " ".join(
            f"{name} = {configs[largest][name]}"
            for name in ("guides", "arc_guides", "inner_guides")
            if configs[largest][name]
        )
        raise InvalidValueError(
            f"{model.where(largest)}: {given or 'its path'} allocates {guides[largest][0]} guides,"
            f" and all sheaths {total} numbers of state, more than {_MOST}; give `guides`, or fewer"
        )


def reading_size(address: int, instance: int, sensor: int) -> int:
    """Numbers of a sensor on an instance; 0 where the sheaths were refused, which `init` raises."""
    model = Draft(address, _PLACE)
    if model.is_refused(model.first(instance)):
        return 0
    config = own_config(model, instance)
    if not config["sensor"]:
        return ENDS
    sheath = None if is_one_number(config["sensor"]) else sheath_on(model, config["tendon"], NAME)
    if sheath is None:
        return 1
    guides, _ = _capacity(model, model.config(sheath), model.where(sheath))
    return numbers_of(list(KINDS).index(config["sensor"]), guides)


def check_tendon(address: int, instance: int) -> int:
    """Check all instances of a complete model, with the first one.

    Raises:
        InvalidValueError: names a tendon, a reel or the tension scale.
    """
    model = Draft(address, _COMPLETE)
    if model.first(instance) == instance:
        check_tension_scale(model)
        reels = model.actuators()
        check_own_names(model, model.siblings(instance))
        for k in model.siblings(instance):
            _check_complete(model, k, reels.get(k, []))
    return 0


def _check_complete(model: Draft, instance: int, reels: Sequence[int]) -> None:
    """Check that a sheath can act on its tendon, and that a sensor has a sheath."""
    config = own_config(model, instance)
    check_reels(model, instance, config, reels)
    _check_objects(model, instance, config)
    if config["sensor"]:
        return
    where, name = model.where(instance), config["tendon"]
    if model.plugin_statenum[instance] < (needed := _state_size(model, config, instance)):
        raise InvalidValueError(
            f"{where}: the model keeps {model.plugin_statenum[instance]} numbers of its state, and"
            f" this release of tendon-mj needs {needed}: compile it from its MJCF again"
        )
    tendons = model.ntendon
    tendon = find(model, _OBJ.mjOBJ_TENDON, tendons, "tendon", name, where)
    drive = read_drive(model, config, tendon, reels)
    check_drive(config, drive, where, name)
    kinds = kinds_on(model, tendon)
    problem = unsuited(kinds, drive.is_given) or misplaced_input(model, tendon, config["input_end"])
    if problem:
        raise InvalidValueError(f"{where}: tendon {name!r} {problem}")
    check_alone(model, drive, where, name)
    check_elastic(model, tendon, where, name)
    check_counts(model, config, tendon, where)
    if sleeps(model):
        check_awake(model, tendon, (config["reel_joint"], config["output_joint"]), where)
