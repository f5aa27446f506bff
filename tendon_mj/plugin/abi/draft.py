"""The model at an address, as checks in Python read it through its C structure."""

from __future__ import annotations

from typing import Any, SupportsIndex

from tendon_mj.plugin.abi.layout import field_at
from tendon_mj.plugin.abi.library import C


class Draft:
    """The model at an address, with its fields as `mujoco.MjModel` has them."""

    def __init__(self, address: int) -> None:
        self.address = address

    def __getattr__(self, field: str) -> Any:
        """A field."""
        value = self.__dict__[field] = field_at("mjModel", self.address, field)
        return value

    def name(self, kind: Any, index: SupportsIndex) -> str:
        """Name of an element, empty if it has none."""
        return (C.mj_id2name(self.address, kind.value, int(index)) or b"").decode()
