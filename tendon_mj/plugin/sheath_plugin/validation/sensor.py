"""Checks of a sensor's configuration, once, while MuJoCo compiles the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import mujoco

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin.abi.model_in_compilation import Draft
from tendon_mj.plugin.sheath_plugin.binding.own_config import own_config
from tendon_mj.plugin.sheath_plugin.binding.sheath_of_tendon import sheath_on, sheathed_tendons
from tendon_mj.plugin.sheath_plugin.sensors import ENDS, KINDS, is_one_number, width

_OBJ = mujoco.mjtObj


def check_sensor(
    config: Mapping[str, str], sheaths: Mapping[str, Sequence[int]], where: str
) -> None:
    """Check the configuration of an instance with `sensor`; ``sheaths`` are those of each tendon.

    Raises:
        InvalidValueError, UnknownNameError: what is wrong, where, and the nearest valid choice.
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
            f"{where}: how many numbers a sensor of {kind} has depends on the sheath, so that the "
            "configuration has to name its tendon: tendon is missing"
        )


def reading_width(model: Draft, instance: int, plugin: str, guides_of: Callable[[int], int]) -> int:
    """Numbers of a sensor on an instance; on a sheath's own they are T_in and T_out.

    Args:
        model: that MuJoCo compiles, read with `sensor` and `tendon` at least.
        instance: of the sensor.
        plugin: name of the sheaths' plugin.
        guides_of: number of guides of the sheath of an instance.
    """
    config = own_config(model, instance)
    if not config["sensor"]:
        return ENDS
    if is_one_number(config["sensor"]):
        return 1
    sheath = sheath_on(model, config["tendon"], plugin)
    return 1 if sheath is None else width(config["sensor"], guides_of(sheath))


def check_objects(model: Draft, instance: int, config: Mapping[str, str], plugin: str) -> None:
    """Check that each sensor of an instance shows the sheath on one tendon; the model is complete.

    Raises:
        InvalidValueError: a sensor without a tendon, or with two.
        UnknownNameError: its tendon has no sheath.
    """
    owners, types = model.ints("sensor_plugin"), model.ints("sensor_objtype")
    objects = model.ints("sensor_objid")
    mine = [k for k in range(int(model.fields.nsensor)) if owners[k] == instance]
    sheathed = [] if config["tendon"] else sheathed_tendons(model, plugin)
    for sensor in mine:
        where = f"{model.where(instance)}: sensor {model.name(_OBJ.mjOBJ_SENSOR, sensor)!r}"
        on_tendon = types[sensor] == _OBJ.mjOBJ_TENDON.value
        tendon = model.name(_OBJ.mjOBJ_TENDON, objects[sensor]) if on_tendon else ""
        if config["tendon"]:
            if types[sensor] != _OBJ.mjOBJ_UNKNOWN.value and tendon != config["tendon"]:
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
