"""A model while MuJoCo compiles it, read through its C structure."""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin.abi.layout import mirror
from tendon_mj.plugin.abi.library import C

_TENDON = mujoco.mjtObj.mjOBJ_TENDON
# Text that Python and the C library read alike as a number.
_NUMBER = re.compile(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|inf|nan)")


class Draft:
    """The model under construction.

    Args:
        address: of the `mjModel`.
        attributes: that a configuration may have.
    """

    def __init__(self, address: int, attributes: Sequence[str]) -> None:
        self.address = address
        self.attributes = attributes
        self.fields = mirror("mjModel").from_address(address)

    def ints(self, field: str) -> Any:
        """An array of int."""
        return ctypes.cast(getattr(self.fields, field), ctypes.POINTER(ctypes.c_int))

    def doubles(self, field: str) -> Any:
        """An array of mjtNum."""
        return ctypes.cast(getattr(self.fields, field), ctypes.POINTER(ctypes.c_double))

    def bools(self, field: str) -> Any:
        """An array of mjtBool."""
        return ctypes.cast(getattr(self.fields, field), ctypes.POINTER(ctypes.c_bool))

    def name(self, kind: Any, index: int) -> str:
        """Name of an element, empty if it has none."""
        return (C.mj_id2name(self.address, kind.value, index) or b"").decode()

    def names(self, kind: Any, count: int) -> list[str]:
        """Names of the first ``count`` elements of a kind."""
        return [self.name(kind, k) for k in range(count)]

    @functools.cached_property
    def tendons(self) -> Mapping[str, int]:
        """Index of each tendon that has a name."""
        return _Tendons(self)

    def config(self, instance: int) -> dict[str, str]:
        """Attributes of a plugin instance, empty where they are not given."""
        values = {}
        for attribute in self.attributes:
            raw = C.mj_getPluginConfig(self.address, instance, attribute.encode())
            values[attribute] = (raw or b"").decode()
        return values

    def plugin(self, instance: int) -> str:
        """Name of the plugin of an instance."""
        slot = int(self.ints("plugin")[instance])
        return bytes(C.mjp_getPluginAtSlot(slot).contents.name).decode()

    def siblings(self, instance: int) -> list[int]:
        """All instances of the same plugin, this one among them."""
        slots = self.ints("plugin")
        return [k for k in range(self.fields.nplugin) if slots[k] == slots[instance]]

    def first(self, instance: int) -> int:
        """First instance of the same plugin."""
        slots = self.ints("plugin")
        return next(k for k in range(instance + 1) if slots[k] == slots[instance])

    def is_first(self, instance: int) -> bool:
        """Whether no instance of the same plugin comes before this one.

        MuJoCo asks about every instance in turn. A check that looks at all of them when it is asked
        about the first looks at each once, and has nothing to keep from one call to the next.
        """
        slots = self.ints("plugin")
        # backwards, so that all calls together pass every instance about once
        return all(slots[k] != slots[instance] for k in range(instance - 1, -1, -1))

    def is_refused(self, instance: int) -> bool:
        """Whether an instance was refused when MuJoCo asked for the size of its state."""
        return not self.ints("plugin_statenum")[instance]

    def actuators(self) -> dict[int, list[int]]:
        """Plugin instance to its actuators, in their order."""
        owners = self.ints("actuator_plugin")
        found: dict[int, list[int]] = {}
        for k in range(int(self.fields.nactuator)):
            found.setdefault(owners[k], []).append(k)
        return found

    def where(self, instance: int) -> str:
        """Name of an instance in error messages."""
        name = self.name(mujoco.mjtObj.mjOBJ_PLUGIN, instance)
        plugin = f"plugin {self.plugin(instance)}"
        return f"{plugin} instance {name!r}" if name else plugin


class _Tendons(Mapping[str, int]):
    """Tendons by name; all names are read only when they are gone through."""

    def __init__(self, model: Draft) -> None:
        self._model = model

    def __getitem__(self, name: str) -> int:
        index: int = C.mj_name2id(self._model.address, _TENDON.value, name.encode())
        if not name or index < 0:
            raise KeyError(name)
        return index

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    @functools.cached_property
    def _names(self) -> list[str]:
        return [name for name in self._model.names(_TENDON, self._model.fields.ntendon) if name]


def find(model: Draft, kind: Any, count: int, what: str, name: str, where: str) -> int:
    """Index of a named element.

    Raises:
        UnknownNameError: there is none.
    """
    index: int = C.mj_name2id(model.address, kind.value, name.encode()) if name else -1
    if index < 0:
        raise UnknownNameError(what, name, model.names(kind, count), where)
    return index


def read_number(config: dict[str, str], name: str, where: str) -> float | None:
    """An attribute as a number, None where it is not given.

    Raises:
        InvalidValueError: it is no number.
    """
    raw = config[name]
    if not raw:
        return None
    if not _NUMBER.fullmatch(raw):
        raise InvalidValueError(f"{where}: {name} = {raw!r} is not a number")
    return float(raw)
