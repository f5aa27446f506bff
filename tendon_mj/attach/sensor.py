"""Adds a sensor that shows something of a sheath."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from tendon_mj.attach.instance import add_instance
from tendon_mj.attach.names import TakenNames, free_name
from tendon_mj.attach.sheathed import is_shared, sheaths_by_tendon
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import KINDS, NAME, is_one_number


def check_kinds(kinds: Sequence[str]) -> None:
    """Refuse a list of kinds with an unknown or a repeated one.

    Raises:
        UnknownNameError, InvalidValueError: names the kind.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownNameError("sensor", kind, KINDS)
        if list(kinds).count(kind) > 1:
            raise InvalidValueError(f"sensor {kind!r} is asked for more than once")


class Sensors:
    """Adds sensors of sheaths to a model.

    Those with one number share an instance of their kind, and have the tendon as their object: in
    each step MuJoCo goes through all sensors for every instance. One with as many numbers as its
    sheath has guides has an instance of its own, as MuJoCo asks for their number before it knows
    the object.

    Args:
        spec: read once, changed in place.
    """

    def __init__(self, spec: mujoco.MjSpec) -> None:
        self._spec = spec
        self._shared = {
            config["sensor"]: plugin
            for plugin in spec.plugins
            if plugin.plugin_name == NAME and plugin.name
            if is_shared(config := plugin.config)
        }

    def add(self, tendon: str, kind: str, name: str, instance: str) -> mujoco.MjsSensor:
        """Add a sensor of a known kind.

        Args:
            tendon: that runs in the sheath.
            kind: one of ``tendon_mj.plugin.KINDS``.
            name, instance: that are free, of the sensor and of a plugin instance of its own.
        """
        sensor = add_plugin_sensor(self._spec, name, tendon)
        if not is_one_number(kind):
            config = {"tendon": tendon, "sensor": kind}
            sensor.plugin = add_instance(self._spec, instance, config, NAME)
            return sensor
        if kind not in self._shared:
            taken = {plugin.name for plugin in self._spec.plugins}
            shared = free_name(taken, kind, f"{kind}_sensors")
            self._shared[kind] = add_instance(self._spec, shared, {"sensor": kind}, NAME)
        sensor.plugin = self._shared[kind]
        sensor.plugin.active = True  # which instances that were read from a file do not pass on
        return sensor


def add_plugin_sensor(spec: mujoco.MjSpec, name: str, tendon: str) -> mujoco.MjsSensor:
    """Add a sensor that a plugin is to fill, with the tendon as its object.

    MuJoCo copies a sensor without an object in every `replicate`, wherever that is, and where it
    refers to a plugin instance it crashes.
    """
    return spec.add_sensor(
        name=name,
        type=mujoco.mjtSensor.mjSENS_PLUGIN,
        objtype=mujoco.mjtObj.mjOBJ_TENDON,
        objname=tendon,
    )


def add_sensor(
    spec: mujoco.MjSpec, sheath: str, kind: str, name: str | None = None
) -> mujoco.MjsSensor:
    """Add a sensor that shows something of a sheath.

    Args:
        spec: changed in place.
        sheath: name of the plugin instance.
        kind: one of ``tendon_mj.plugin.KINDS``.
        name: of the sensor; default: the kind, or ``<sheath>_<kind>`` where that is taken.

    Raises:
        UnknownNameError: no such sheath or kind.
        InvalidValueError: the name is another sensor's.
    """
    sheaths = {plugin.name: tendon for tendon, plugin in sheaths_by_tendon(spec).items()}
    if sheath not in sheaths:
        raise UnknownNameError("sheath", sheath, sheaths)
    check_kinds([kind])
    taken = TakenNames(spec)
    if name is not None and name in taken.sensors:
        raise InvalidValueError(f"the model already has a sensor {name!r}")
    free = free_name(taken.sensors, kind, f"{sheath}_{kind}")
    instance = free_name(taken.instances, f"{sheath}.{kind}")
    return Sensors(spec).add(sheaths[sheath], kind, free if name is None else name, instance)
