"""Adds a sensor that shows something of a sheath."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from tendon_mj.attach.instance import add_instance
from tendon_mj.attach.names import TakenNames, free_name
from tendon_mj.attach.sheathed import sheaths_by_tendon
from tendon_mj.engine import KINDS, NAME
from tendon_mj.errors import InvalidValueError, UnknownNameError


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


def show(spec: mujoco.MjSpec, tendon: str, kind: str, name: str, instance: str) -> mujoco.MjsSensor:
    """Add a sensor of a known kind, and its plugin instance, under names that are free."""
    view = add_instance(spec, instance, {"tendon": tendon, "sensor": kind}, NAME)
    sensor = spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_PLUGIN)
    sensor.plugin = view
    return sensor


def add_sensor(
    spec: mujoco.MjSpec, sheath: str, kind: str, name: str | None = None
) -> mujoco.MjsSensor:
    """Add a sensor that shows something of a sheath.

    Args:
        spec: changed in place.
        sheath: name of the plugin instance.
        kind: one of ``tendon_mj.engine.KINDS``.
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
    return show(spec, sheaths[sheath], kind, free if name is None else name, instance)
