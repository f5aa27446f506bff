"""Configuration of an instance in a model with the names as the elements have them now."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin.abi.library import C
from tendon_mj.plugin.abi.model_in_compilation import Draft
from tendon_mj.plugin.sheath_plugin.binding.own_names import (
    NONE,
    Affixes,
    around_tendon,
    around_written,
    prefix_and_suffix,
)

_OBJ, _WRAP = mujoco.mjtObj, mujoco.mjtWrap
_NAMES = ("tendon", "reel_joint", "output_joint")  # attributes that name an element
_ON_PATH = {
    _WRAP.mjWRAP_SITE.value: _OBJ.mjOBJ_SITE,
    _WRAP.mjWRAP_SPHERE.value: _OBJ.mjOBJ_GEOM,
    _WRAP.mjWRAP_CYLINDER.value: _OBJ.mjOBJ_GEOM,
    _WRAP.mjWRAP_JOINT.value: _OBJ.mjOBJ_JOINT,
}


def own_config(model: Draft, instance: int) -> dict[str, str]:
    """Attributes of a plugin instance, each name with the prefix and suffix of the instance.

    Raises:
        InvalidValueError: several tendons may be meant.
    """
    config = model.config(instance)
    affixes = _affixes(model, instance, config)
    return {k: affixes.around(v) if k in _NAMES else v for k, v in config.items()}


def check_own_names(model: Draft, instances: Iterable[int]) -> None:
    """Refuse what is meant to the letter or not, where nothing says which; the model is complete.

    Raises:
        InvalidValueError: a tendon of the name as written, and one with the instance's prefix.
        UnknownNameError: the tendon only seems to share a prefix with the instance.
    """
    for instance in instances:
        own, tendon = _own_name(model, instance), _read(model, instance, "tendon")
        if around_written(own, _read(model, instance, "instance")):
            continue
        chosen = _affixes(model, instance, {"tendon": tendon, "instance": ""})
        if chosen != NONE:
            if not _carries(model, model.tendons[chosen.around(tendon)], chosen):
                raise UnknownNameError("tendon", tendon, model.tendons, model.where(instance))
            continue
        for affixes in around_tendon(own, tendon, model.tendons):
            other = affixes.around(tendon)
            if other != tendon and _carries(model, model.tendons[other], affixes):
                raise _ambiguous(model, instance, [tendon, other])


def _affixes(model: Draft, instance: int, config: Mapping[str, str]) -> Affixes:
    """Prefix and suffix of an instance, from what its configuration says."""
    own = _own_name(model, instance)
    written, tendon = (
        config[name] if name in config else _read(model, instance, name)
        for name in ("instance", "tendon")
    )
    found = prefix_and_suffix(own, written, tendon, model.tendons)
    if len({affixes.around(tendon) for affixes in found}) > 1:
        raise _ambiguous(model, instance, [affixes.around(tendon) for affixes in found])
    return found[0]


def _read(model: Draft, instance: int, attribute: str) -> str:
    return (C.mj_getPluginConfig(model.address, instance, attribute.encode()) or b"").decode()


def _ambiguous(model: Draft, instance: int, tendons: Iterable[str]) -> InvalidValueError:
    meant = " or ".join(repr(name) for name in tendons)
    return InvalidValueError(
        f"{model.where(instance)}: its tendon may be {meant}, as `attach` renames an instance and "
        'not what it names; say what the instance was called before, <config key="instance" '
        'value="…"/>, or what it is called now if the tendon is meant to the letter'
    )


def _own_name(model: Draft, instance: int) -> str:
    """Name of an instance, or of the first sensor or actuator that has it."""
    name = model.name(_OBJ.mjOBJ_PLUGIN, instance)
    if name:
        return name
    for kind, field, count in (
        (_OBJ.mjOBJ_SENSOR, "sensor_plugin", int(model.fields.nsensor)),
        (_OBJ.mjOBJ_ACTUATOR, "actuator_plugin", int(model.fields.nactuator)),
    ):
        if count:
            owners = np.ctypeslib.as_array(model.ints(field), (count,))
            for first in np.flatnonzero(owners == instance)[:1]:
                return model.name(kind, int(first))
    return ""


def _carries(model: Draft, tendon: int, affixes: Affixes) -> bool:
    """Whether all that is named on a tendon's path has a prefix and a suffix."""
    start, count = model.ints("tendon_adr")[tendon], model.ints("tendon_num")[tendon]
    names = []
    for k in range(start, start + count):
        kind = _ON_PATH.get(model.ints("wrap_type")[k])
        if kind is not None:
            names.append(model.name(kind, model.ints("wrap_objid")[k]))
    return all(n.startswith(affixes.prefix) and n.endswith(affixes.suffix) for n in names if n)
