"""Adds a sensor that shows something of a sheath."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from tendon_mj.attach.instance import add_instance
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


def free_name(spec: mujoco.MjSpec, *candidates: str) -> str:
    """The first candidate that no sensor of the model has."""
    taken = [sensor.name for sensor in spec.sensors]
    return next((name for name in candidates if name not in taken), candidates[-1])


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
    """
    sheaths = {
        p.name: p for p in spec.plugins if p.plugin_name == NAME and "sensor" not in p.config
    }
    if sheath not in sheaths:
        raise UnknownNameError("sheath", sheath, sheaths)
    check_kinds([kind])
    if name is None:
        name = free_name(spec, kind, f"{sheath}_{kind}")
    view = add_instance(
        spec,
        f"{sheath}.{kind}",
        {"tendon": sheaths[sheath].config["tendon"], "sensor": kind},
        NAME,
    )
    sensor = spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_PLUGIN)
    sensor.plugin = view
    return sensor
