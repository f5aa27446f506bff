"""Sheaths and actuators on the tendons of a spec."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco

from tendon_mj.attach.instance import own_configs
from tendon_mj.engine import NAME


def instances(spec: mujoco.MjSpec) -> list[tuple[mujoco.MjsPlugin, dict[str, str]]]:
    """Plugin instances of sheaths and of their sensors, each with its configuration.

    Names are those that the elements have now; of an instance without a name they are as written.
    """
    own = own_configs(spec, NAME)
    return [
        (plugin, own[plugin.name] if plugin.name else plugin.config)
        for plugin in spec.plugins
        if plugin.plugin_name == NAME
    ]


def sheaths_by_tendon(spec: mujoco.MjSpec) -> dict[str, mujoco.MjsPlugin]:
    """Tendon → the plugin instance of the sheath that it runs in."""
    return {c.get("tendon", ""): plugin for plugin, c in instances(spec) if "sensor" not in c}


def is_shared(config: Mapping[str, str]) -> bool:
    """Whether an instance is one of sensors that say by their object whose sheath they show."""
    return "sensor" in config and "tendon" not in config


def name_of(actuator: mujoco.MjsActuator) -> str:
    """An actuator for messages: its name, or its number where it has none."""
    return repr(actuator.name) if actuator.name else f"actuator {actuator.id}, which has no name"


def actuators_by_tendon(spec: mujoco.MjSpec) -> dict[str, list[mujoco.MjsActuator]]:
    """Tendon → the actuators on it."""
    found: dict[str, list[mujoco.MjsActuator]] = {}
    for actuator in spec.actuators:
        if actuator.trntype == mujoco.mjtTrn.mjTRN_TENDON:
            found.setdefault(actuator.target, []).append(actuator)
    return found
