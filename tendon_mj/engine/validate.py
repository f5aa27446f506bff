"""Is a sheath's configuration sound? Asked once, while MuJoCo compiles the model.

This is the plugin's only Python, and it never runs in a step.
"""

from __future__ import annotations

import ctypes
import math
import re
from typing import Any

import mujoco

from tendon_mj.engine import state
from tendon_mj.engine.attributes import ATTRIBUTES
from tendon_mj.engine.callbacks import VIEW_SIZE
from tendon_mj.engine.layout import mirror
from tendon_mj.engine.library import C
from tendon_mj.engine.measure import ENDS, KINDS, width
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath.law import RANGES, check_range, check_static

NAME = "tendon_mj.sheath"
_OBJ, _WRAP, _JNT = mujoco.mjtObj, mujoco.mjtWrap, mujoco.mjtJoint
# What Python and the C library read alike.
_NUMBER = re.compile(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|inf|nan)")
_COUNT = re.compile(r"[0-9]+")
_REQUIRED = ("axial_stiffness", "friction")


class _Model:
    """The model under construction, read through its C structure."""

    def __init__(self, address: int) -> None:
        self.address = address
        self.fields = mirror("mjModel").from_address(address)

    def ints(self, field: str) -> Any:
        return ctypes.cast(getattr(self.fields, field), ctypes.POINTER(ctypes.c_int))

    def doubles(self, field: str) -> Any:
        return ctypes.cast(getattr(self.fields, field), ctypes.POINTER(ctypes.c_double))

    def name(self, kind: Any, index: int) -> str:
        return (C.mj_id2name(self.address, kind.value, index) or b"").decode()

    def names(self, kind: Any, count: int) -> list[str]:
        return [self.name(kind, k) for k in range(count)]

    def config(self, instance: int) -> dict[str, str]:
        values = {}
        for attribute in ATTRIBUTES:
            raw = C.mj_getPluginConfig(self.address, instance, attribute.encode())
            values[attribute] = (raw or b"").decode()
        return values

    def siblings(self, instance: int) -> list[int]:
        slots = self.ints("plugin")
        return [k for k in range(self.fields.nplugin) if slots[k] == slots[instance]]


def _where(model: _Model, instance: int) -> str:
    name = model.name(_OBJ.mjOBJ_PLUGIN, instance)
    return f"plugin {NAME} instance {name!r}" if name else f"plugin {NAME}"


def _read_number(config: dict[str, str], name: str, where: str) -> float | None:
    raw = config[name]
    if not raw:
        return None
    if not _NUMBER.fullmatch(raw):
        raise InvalidValueError(f"{where}: {name} = {raw!r} is not a number")
    value = float(raw)
    if name in RANGES:
        check_range(name, value, where)
    elif not math.isfinite(value) or value == 0.0:
        raise InvalidValueError(f"{where}: {name} = {value:g} [m] must be finite and not 0")
    return value


def _check_numbers(config: dict[str, str], where: str) -> None:
    numbers = {name: _read_number(config, name, where) for name in state.PARAMETERS}
    for name in _REQUIRED:
        if numbers[name] is None:
            raise InvalidValueError(f"{where}: {name} is missing (its unit is {RANGES[name][2]})")
    friction, static = numbers["friction"], numbers["static_friction"]
    if friction is not None and static is not None:
        check_static(friction, static, where)
    for end in ("reel", "output"):
        if bool(config[f"{end}_joint"]) != bool(config[f"{end}_radius"]):
            raise InvalidValueError(
                f"{where}: {end}_joint and {end}_radius go together, one of them is missing"
            )


def _capacity(model: _Model, config: dict[str, str], where: str) -> int:
    """Guides to make room for.

    MuJoCo asks before it has told its tendons which points they run through, so without `guides`
    all points of the model that other tendons need not have are counted.
    """
    if not config["guides"]:
        return max(0, int(model.fields.nwrap) - int(model.fields.ntendon) - 1)
    if not _COUNT.fullmatch(config["guides"]):
        raise InvalidValueError(f"{where}: guides = {config['guides']!r} is not a count")
    return int(config["guides"])


def _find(model: _Model, kind: Any, count: int, what: str, name: str, where: str) -> int:
    names = model.names(kind, count)
    if not name or name not in names:
        raise UnknownNameError(what, name, names, where)
    return names.index(name)


def _find_spool(model: _Model, name: str, where: str) -> None:
    joints = int(model.fields.njnt)
    joint = _find(model, _OBJ.mjOBJ_JOINT, joints, "joint", name, where)
    if model.ints("jnt_type")[joint] not in (_JNT.mjJNT_HINGE.value, _JNT.mjJNT_SLIDE.value):
        raise InvalidValueError(f"{where} {name!r} is no hinge or slide")


def state_size(address: int, instance: int) -> int:
    """Check an instance and say how many numbers of state it needs.

    Raises:
        InvalidValueError, UnknownNameError: what is wrong, where, and the nearest valid choice.
    """
    model = _Model(address)
    where = _where(model, instance)
    config = model.config(instance)
    tendons = int(model.fields.ntendon)
    _find(model, _OBJ.mjOBJ_TENDON, tendons, "tendon", config["tendon"], where)
    others = {k: model.config(k) for k in model.siblings(instance) if k != instance}
    rivals = [k for k, c in others.items() if c["tendon"] == config["tendon"] and not c["sensor"]]
    if config["sensor"]:
        if config["sensor"] not in KINDS:
            raise UnknownNameError("sensor", config["sensor"], KINDS, where)
        extra = [k for k, v in config.items() if v and k not in ("sensor", "tendon")]
        if extra:
            raise InvalidValueError(f"{where}: a sensor takes no {extra[0]}; the sheath has it")
        if not rivals:
            sheathed = {c["tendon"] for c in others.values() if not c["sensor"]}
            raise UnknownNameError("sheathed tendon", config["tendon"], sheathed, where)
        return VIEW_SIZE
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
    return state.size(_capacity(model, config, where))


def sensor_size(address: int, instance: int, sensor: int) -> int:
    """How many numbers a sensor shows; one on a sheath's own instance has T_in and T_out."""
    model = _Model(address)
    config = model.config(instance)
    if not config["sensor"]:
        return ENDS
    for other in model.siblings(instance):
        sheath = model.config(other)
        if sheath["tendon"] == config["tendon"] and not sheath["sensor"]:
            return width(config["sensor"], _capacity(model, sheath, _where(model, other)))
    return 1


def check_tendon(address: int, instance: int) -> int:
    """Check that a sheath can act on its tendon, now that the model is complete.

    Raises:
        InvalidValueError: what is wrong with the tendon.
    """
    model = _Model(address)
    config = model.config(instance)
    _check_reels(model, instance, bool(config["sensor"]))
    if config["sensor"]:
        return 0
    where, name = _where(model, instance), config["tendon"]
    tendon = model.names(_OBJ.mjOBJ_TENDON, int(model.fields.ntendon)).index(name)
    start, count = model.ints("tendon_adr")[tendon], model.ints("tendon_num")[tendon]
    for k in range(start, start + count):
        problem = _unsuited(model, model.ints("wrap_type")[k], model.ints("wrap_objid")[k])
        if problem:
            raise InvalidValueError(f"{where}: tendon {name!r} {problem}")
    stiffness = model.doubles("tendon_stiffness")[tendon]
    if stiffness != 0.0:
        raise InvalidValueError(
            f"{where}: tendon {name!r} has stiffness = {stiffness:g} [N/m] of its own, which would "
            "act beside the sheath's axial_stiffness; remove it"
        )
    if config["guides"] and int(config["guides"]) != count - 2:
        raise InvalidValueError(
            f"{where}: guides = {config['guides']}, but tendon {name!r} runs over {count - 2} "
            "between its ends; remove the attribute or correct it"
        )
    return 0


def _check_reels(model: _Model, instance: int, view: bool) -> None:
    owners = model.ints("actuator_plugin")
    reels = [k for k in range(model.fields.nactuator) if owners[k] == instance]
    names = ", ".join(repr(model.name(_OBJ.mjOBJ_ACTUATOR, k)) for k in reels)
    if view and reels:
        raise InvalidValueError(
            f"{_where(model, instance)}: actuator {names} belongs on the sheath's instance, not on "
            "that of a sensor"
        )
    if len(reels) > 1:
        raise InvalidValueError(
            f"{_where(model, instance)}: a sheath has one reel, not {len(reels)}: {names}"
        )


def _unsuited(model: _Model, kind: int, index: int) -> str:
    """Why a tendon with such a point on its path cannot run in a sheath; empty if it can."""
    if kind == _WRAP.mjWRAP_SITE.value:
        return ""
    if kind == _WRAP.mjWRAP_JOINT.value:
        return "is a fixed tendon; only a spatial one runs in a sheath"
    if kind == _WRAP.mjWRAP_PULLEY.value:
        return "branches at a pulley; give each branch a tendon of its own"
    geom = model.name(_OBJ.mjOBJ_GEOM, index)
    return f"wraps around geom {geom!r}, which a sheath does not support yet; route it over sites"
