"""Adds a named, configured instance of a plugin to a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco

from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import prefix_and_suffix


def add_instance(
    spec: mujoco.MjSpec, name: str, config: Mapping[str, str | float | None], plugin_name: str
) -> Any:
    """Add a plugin instance whose configuration leaves out what is None.

    It keeps its name in the configuration, by which it finds what it names after `attach`.

    Raises:
        InvalidValueError: the name is taken or empty.
    """
    if not name or name in [plugin.name for plugin in spec.plugins]:
        raise InvalidValueError(f"{name!r} cannot be the name of a plugin instance: empty or taken")
    plugin = spec.add_plugin(name=name, plugin_name=plugin_name, active=True)
    plugin.config = {
        k: v if isinstance(v, str) else repr(float(v)) for k, v in config.items() if v is not None
    } | {"instance": name}
    return plugin


def own_configs(spec: mujoco.MjSpec, plugin_name: str) -> dict[str, dict[str, str]]:
    """Configuration of each named instance, its names with what `attach` put around them."""
    tendons = {tendon.name for tendon in spec.tendons}
    found = {}
    for plugin in spec.plugins:
        if plugin.plugin_name == plugin_name:
            config = dict(plugin.config)
            affixes, *_ = prefix_and_suffix(
                plugin.name,
                config.get("instance", ""),
                config.get("tendon", ""),
                tendons,
            )
            found[plugin.name] = {
                k: affixes.around(v) if k in ("tendon", "reel_joint", "output_joint") else v
                for k, v in config.items()
            }
    return found
