"""Plugin instances of sheaths in a spec, their names, and the sensors that show them.

A sheath is called ``<tendon>_sheath``. Sensors of one tendon that is given by its name have short
names where they are free: the kind of each. Those of several, or of a list of one, are called
``<tendon>_<kind>``, which depends neither on the rest of the model nor on the order of calls. So do
those of one where the short names are taken. Nothing is ever renamed.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Mapping, Sequence
from itertools import count
from typing import Any

import mujoco

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import (
    KINDS,
    NAME,
    TENSION_SCALE,
    check_limits,
    is_one_number,
)

_TENDON, _ON_TENDON = mujoco.mjtObj.mjOBJ_TENDON, mujoco.mjtTrn.mjTRN_TENDON


def free_name(taken: Container[str], *candidates: str) -> str:
    """The first candidate that is not taken; if all are, the last one and a number."""
    for name in candidates:
        if name not in taken:
            return name
    return next(name for k in count(2) if (name := f"{candidates[-1]}_{k}") not in taken)


def take_name(taken: set[str], *candidates: str) -> str:
    """`free_name`, which is taken from then on."""
    name = free_name(taken, *candidates)
    taken.add(name)
    return name


def taken_names(spec: mujoco.MjSpec) -> tuple[set[str], set[str]]:
    """Names of a model's plugin instances, and of its sensors."""
    return {plugin.name for plugin in spec.plugins}, {sensor.name for sensor in spec.sensors}


def add_instance(
    spec: mujoco.MjSpec, name: str, config: Mapping[str, str | float | None], plugin_name: str
) -> Any:
    """Add a plugin instance, without the attributes that are None."""
    check_instance_name(name, {plugin.name for plugin in spec.plugins})
    plugin = spec.add_plugin(name=name, plugin_name=plugin_name, active=True)
    plugin.config = {
        k: v if isinstance(v, str) else repr(float(v)) for k, v in config.items() if v is not None
    }
    return plugin


def check_instance_name(name: object, taken: Container[str]) -> None:
    """Refuse a name that no new plugin instance can have."""
    if not isinstance(name, str) or not name or name in taken:
        raise InvalidValueError(
            f"{name!r} cannot be the name of a plugin instance: empty or taken, or not a text"
        )


def instances(spec: mujoco.MjSpec) -> list[tuple[mujoco.MjsPlugin, dict[str, str]]]:
    """Instances of the sheaths' plugin, each with its configuration.

    A tendon is called in it as the object of the instance's sensor or the target of its reel, and
    joints as that tendon after `attach`; of an instance without a name they are as written.
    """
    on_tendons = [(a.plugin.name, a.target) for a in spec.actuators if a.trntype == _ON_TENDON]
    on_tendons += [(s.plugin.name, s.objname) for s in spec.sensors if s.objtype == _TENDON]
    joints, tendons = {joint.name for joint in spec.joints}, dict(on_tendons)
    configs = []
    for plugin in spec.plugins:
        if plugin.plugin_name == NAME:
            config = dict(plugin.config)
            written = config.get("tendon", "")
            if plugin.name and plugin.name in tendons and (written or "sensor" not in config):
                config["tendon"] = now = tendons[plugin.name]
                places = [k for k in range(len(now)) if now.startswith(written, k)]
                for key in config.keys() & {"reel_joint", "output_joint"}:
                    names = (now[:k] + config[key] + now[k + len(written) :] for k in places)
                    config[key] = next((name for name in names if name in joints), config[key])
            configs.append((plugin, config))
    return configs


def sheaths_by_tendon(spec: mujoco.MjSpec) -> dict[str, mujoco.MjsPlugin]:
    """Tendon → the plugin instance of the sheath that it runs in."""
    return {c.get("tendon", ""): plugin for plugin, c in instances(spec) if "sensor" not in c}


def is_shared(config: Mapping[str, str]) -> bool:
    """Return whether the sensors of an instance state by their object which sheath they show."""
    return "sensor" in config and "tendon" not in config


def check_kinds(kinds: Sequence[str]) -> None:
    """Refuse an unknown or a repeated kind of sensor, and one that is not in a sequence."""
    if isinstance(kinds, str) or not isinstance(kinds, Collection):
        raise InvalidValueError(f"sensors = {kinds!r} must be a sequence of kinds, or ()")
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownNameError("sensor", kind, KINDS)
        if list(kinds).count(kind) > 1:
            raise InvalidValueError(f"sensor {kind!r} is given more than once")


def note_of(spec: mujoco.MjSpec, element: str, suffix: str) -> mujoco.MjsText | None:
    """Custom text ``<element><suffix>``, of which `attach` renames both parts alike."""
    for text in spec.texts:
        if suffix in text.name and text.name.replace(suffix, "", 1) == element:
            return text
    return None


def add_sensor_of(
    spec: mujoco.MjSpec, sheath: Mapping[str, str], kind: str, name: str, instance: str
) -> mujoco.MjsSensor:
    """Add a sensor of a sheath with this configuration; ``name`` and ``instance`` are free names.

    Sensors with one number share an instance of their kind, and have the tendon as their object: in
    each step MuJoCo goes through all sensors for every instance. One with as many numbers as its
    sheath has guides has its own instance, as MuJoCo asks for their number before it knows the
    object.
    """
    sensor = add_plugin_sensor(spec, name, sheath["tendon"])
    if not is_one_number(kind):
        config = {"tendon": sheath["tendon"], "sensor": kind, "guides": sheath.get("guides")}
        sensor.plugin = add_instance(spec, instance, config, NAME)
        return sensor
    ours = [p for p in spec.plugins if p.plugin_name == NAME and p.name]
    shared = [p for p in ours if is_shared(p.config) and p.config["sensor"] == kind]
    if not shared:
        taken = {plugin.name for plugin in spec.plugins}
        own = free_name(taken, kind, f"{kind}_sensors")
        shared = [add_instance(spec, own, {"sensor": kind}, NAME)]
    sensor.plugin = shared[-1]
    sensor.plugin.active = True  # which instances that were read from a file do not pass on
    return sensor


def add_plugin_sensor(spec: mujoco.MjSpec, name: str, tendon: str) -> mujoco.MjsSensor:
    """Add a sensor for a plugin to fill, with the tendon as its object.

    MuJoCo copies a sensor without an object in every `replicate`, wherever that is, and where it
    refers to a plugin instance it crashes.
    """
    kind, on = mujoco.mjtSensor.mjSENS_PLUGIN, mujoco.mjtObj.mjOBJ_TENDON
    return spec.add_sensor(name=name, type=kind, objtype=on, objname=tendon)


def add_sensor(
    spec: mujoco.MjSpec, sheath: str, kind: str, name: str | None = None
) -> mujoco.MjsSensor:
    """Add a sensor of a sheath.

    Args:
        spec: changed in place.
        sheath: name of the plugin instance.
        kind: one of ``tendon_mj.plugin.KINDS``.
        name: of the sensor; default: the kind, or ``<sheath>_<kind>`` if that is taken.

    Raises:
        UnknownNameError: no such sheath or kind.
        InvalidValueError: another sensor already has this name.
    """
    sheaths = {plugin.name: config for plugin, config in instances(spec) if "sensor" not in config}
    if sheath not in sheaths:
        raise UnknownNameError("sheath", sheath, sheaths)
    check_kinds([kind])
    taken, sensors = taken_names(spec)
    if name is not None and name in sensors:
        raise InvalidValueError(f"the model already has a sensor {name!r}")
    free = free_name(sensors, kind, f"{sheath}_{kind}")
    instance = free_name(taken, f"{sheath}.{kind}")
    own = free if name is None else name
    return add_sensor_of(spec, sheaths[sheath], kind, own, instance)


def show_tension(spec: mujoco.MjSpec, low: float, high: float) -> mujoco.MjSpec:
    """Let MuJoCo draw every sheathed tendon of a model in the colours of its tension.

    It writes the custom numeric `tendon_mj.tension_scale`, which viewers, renderers and clips
    follow. A compiled model takes new numbers live, in `model.numeric(…).data`.

    Args:
        spec: changed in place.
        low, high: tensions at the ends of the colour bar, from dark blue to yellow [N].

    Returns:
        ``spec``.

    Raises:
        InvalidValueError: not two finite tensions, the lower one first.
    """
    check_limits(low, high)
    numeric = spec.numeric(TENSION_SCALE) or spec.add_numeric(name=TENSION_SCALE)
    numeric.size, numeric.data = 2, [low, high]
    return spec
