"""Adds a named, configured instance of a plugin to a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco

from tendon_mj.errors import InvalidValueError


def add_instance(
    spec: mujoco.MjSpec, name: str, config: Mapping[str, str | float | None], plugin_name: str
) -> Any:
    """Add a plugin instance whose configuration leaves out what is None.

    Raises:
        InvalidValueError: the name is taken or empty.
    """
    if not name or name in [plugin.name for plugin in spec.plugins]:
        raise InvalidValueError(f"{name!r} cannot be the name of a plugin instance: empty or taken")
    plugin = spec.add_plugin(name=name, plugin_name=plugin_name, active=True)
    plugin.config = {
        k: v if isinstance(v, str) else repr(float(v)) for k, v in config.items() if v is not None
    }
    return plugin
