"""The model at an address, as checks in Python read it through its C structure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, SupportsIndex

import mujoco
import numpy as np

from tendon_mj.plugin.abi.layout import field_at
from tendon_mj.plugin.abi.library import C


class Draft:
    """The model at an address, and the attributes that are read of its plugins' instances."""

    def __init__(self, address: int, attributes: Sequence[str]) -> None:
        self.address = address
        self.attributes = attributes

    def __getattr__(self, field: str) -> Any:
        """A field, as `mujoco.MjModel` has it."""
        value = self.__dict__[field] = field_at("mjModel", self.address, field)
        return value

    def name(self, kind: Any, index: SupportsIndex) -> str:
        """Name of an element, empty if it has none."""
        return (C.mj_id2name(self.address, kind.value, int(index)) or b"").decode()

    def names_of(self, kind: Any, count: int) -> list[str]:
        """Names of the first ``count`` elements of a kind."""
        return [self.name(kind, k) for k in range(count)]

    def config(self, instance: int) -> dict[str, str]:
        """Attributes of a plugin instance, empty where they are not given."""
        values = {}
        for attribute in self.attributes:
            raw = C.mj_getPluginConfig(self.address, instance, attribute.encode())
            values[attribute] = (raw or b"").decode()
        return values

    def plugin_name(self, instance: int) -> str:
        """Name of the plugin of an instance."""
        slot = int(self.plugin[instance])
        return bytes(C.mjp_getPluginAtSlot(slot).contents.name).decode()

    def siblings(self, instance: int) -> list[int]:
        """All instances of the same plugin, this one among them."""
        return np.flatnonzero(self.plugin == self.plugin[instance]).tolist()

    def where(self, instance: int) -> str:
        """Name of an instance in error messages."""
        name = self.name(mujoco.mjtObj.mjOBJ_PLUGIN, instance)
        plugin = f"plugin {self.plugin_name(instance)}"
        return f"{plugin} instance {name!r}" if name else plugin
