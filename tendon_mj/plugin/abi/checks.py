"""Checks in Python of a model while MuJoCo compiles it.

`Draft` reads the model through its C structure. `asking` makes a C function of a check.

MuJoCo leaves a failed check by a long jump, which must not cross a Python frame: the check leaves a
count or a message in memory of the C function, which raises it after Python has returned. Where
Python could not even begin, as when Ctrl-C comes just then, nothing is left there.

MuJoCo does not free all that it holds at such a jump. Where it asks for the size of a state it
holds a few small lists, between which the heap would fall to pieces: a refusal is a size of 0, and
`init` says why. Where it asks `init` it holds the data, which is deleted here.
"""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, SupportsIndex

import mujoco
import numpy as np

from tendon_mj.errors import INTERRUPTED, InvalidValueError, TendonError, UnknownNameError
from tendon_mj.native import Called, LocalDoubles, Shared, Text, compiled
from tendon_mj.plugin.abi.layout import field_at, mirror
from tendon_mj.plugin.abi.library import C, mju_error
from tendon_mj.plugin.abi.memory import integers, word

_TENDON = mujoco.mjtObj.mjOBJ_TENDON
# Text that Python and the C library read alike as a number.
_NUMBER = re.compile(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|inf|nan)")


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

    def plugin_name(self, instance: int) -> str:
        """Name of the plugin of an instance."""
        slot = int(self.plugin[instance])
        return bytes(C.mjp_getPluginAtSlot(slot).contents.name).decode()

    def siblings(self, instance: int) -> list[int]:
        """All instances of the same plugin, this one among them."""
        return np.flatnonzero(self.plugin == self.plugin[instance]).tolist()

    def first(self, instance: int) -> int:
        """First instance of the same plugin.

        MuJoCo asks about every instance in turn. A check that looks at all of them when it is asked
        about the first looks at each once, and has nothing to keep from one call to the next.
        """
        return self.siblings(instance)[0]

    def is_refused(self, instance: int) -> bool:
        """Whether an instance was refused when MuJoCo asked for the size of its state."""
        return not self.plugin_statenum[instance]

    def actuators(self) -> dict[int, list[int]]:
        """Plugin instance to its actuators, in their order."""
        actuators: dict[int, list[int]] = {}
        for k, owner in enumerate(self.actuator_plugin.tolist()):
            actuators.setdefault(owner, []).append(k)
        return actuators

    def where(self, instance: int) -> str:
        """Name of an instance in error messages."""
        name = self.name(mujoco.mjtObj.mjOBJ_PLUGIN, instance)
        plugin = f"plugin {self.plugin_name(instance)}"
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
        return [name for name in self._model.names_of(_TENDON, self._model.ntendon) if name]


def find(model: Draft, kind: Any, count: int, what: str, name: str, where: str) -> int:
    """Index of a named element.

    Raises:
        UnknownNameError: there is none.
    """
    index: int = C.mj_name2id(model.address, kind.value, name.encode()) if name else -1
    if index < 0:
        raise UnknownNameError(what, name, model.names_of(kind, count), where)
    return index


def read_number(config: dict[str, str], name: str, where: str) -> float | None:
    """An attribute as a number, None where it is not given.

    Raises:
        InvalidValueError: it is not a number.
    """
    raw = config[name]
    if not raw:
        return None
    if not _NUMBER.fullmatch(raw):
        raise InvalidValueError(f"{where}: {name} = {raw!r} is not a number")
    return float(raw)


_SIZE = 2048  # of a message, with the zero that ends it
_HEAD = 8  # bytes before it, for the count
_REFUSED, _SILENT = -1, -2  # counts
_reply = LocalDoubles((_HEAD + _SIZE) // 8)
_interrupted = Text(f"tendon_mj: {INTERRUPTED}")
CHECKS: Final = ("sheath_nstate", "sheath_nsensordata", "sheath_init", "servo_nstate", "servo_init")
SHEATH_NSTATE, SHEATH_NSENSORDATA, SHEATH_INIT, SERVO_NSTATE, SERVO_INIT = range(len(CHECKS))
_checks = Shared("tendon_mj_checks", len(CHECKS))  # addresses of the functions that ask Python


def _replying(plugin: str, function: Callable[..., int]) -> Callable[..., None]:
    """Leave what a function returns at an address, or −1 and the message of its exception."""

    def reply(address: int, *arguments: int) -> None:
        try:
            count = function(*arguments)
        except KeyboardInterrupt:
            return  # ctypes would print it; the count says that there was no reply
        except Exception as error:
            text = str(error) if isinstance(error, TendonError) else f"{plugin}: {error!r}"
            fits = text.encode()[: (_SIZE - 1) // 2].decode(errors="ignore")
            message = fits.replace("%", "%%").encode()  # mju_error takes a format
            ctypes.memmove(address + _HEAD, message + b"\0", len(message) + 1)
            count = _REFUSED
        ctypes.c_int.from_address(address).value = count

    return reply


def _with_data(function: Callable[[int, int], int]) -> Callable[[int, int, int], int]:
    """A check of `init`, which deletes the data of a model that it refuses."""

    @functools.wraps(function)
    def check(m: int, d: int, instance: int) -> int:
        try:
            return function(m, instance)
        except BaseException:
            mirror("mjData").from_address(d).nplugin = instance  # only those before it have begun
            C.mj_deleteData(d)
            raise

    return check


@compiled
def _count_at(reply: int) -> int:
    """The count in a reply; raises its message in MuJoCo where there is none."""
    count = integers(reply)[0]
    if count == _SILENT:
        mju_error(_interrupted())
    if count < 0:
        mju_error(reply + _HEAD)
    return count


_ask_of_instance, _ask_of_sensor = Called("void(ptr, ptr, i32)"), Called("void(ptr, ptr, i32, i32)")
_ask_of_data = Called("void(ptr, ptr, ptr, i32)")


@compiled
def asks(which: int) -> bool:
    """Whether a check is one in Python."""
    return word(_checks() + 8 * which) != 0


@compiled
def ask_size(which: int, m: int, instance: int) -> int:
    """Numbers of state of an instance, 0 where it was refused."""
    reply = _reply()
    integers(reply)[0] = _SILENT
    _ask_of_instance(word(_checks() + 8 * which), reply, m, instance)
    return 0 if integers(reply)[0] == _REFUSED else _count_at(reply)


@compiled
def ask_complete(which: int, m: int, d: int, instance: int) -> None:
    """Raise what `init` refuses."""
    reply = _reply()
    integers(reply)[0] = _SILENT
    _ask_of_data(word(_checks() + 8 * which), reply, m, d, instance)
    _count_at(reply)


@compiled
def ask_sensor_size(which: int, m: int, instance: int, sensor: int) -> int:
    """Numbers of a sensor."""
    reply = _reply()
    integers(reply)[0] = _SILENT
    _ask_of_sensor(word(_checks() + 8 * which), reply, m, instance, sensor)
    return _count_at(reply)


def asking(plugin: str, function: Callable[..., int], integers: int = 1, data: bool = False) -> Any:
    """A C function that asks a check in Python, for `CHECKS`; it has to be kept.

    Args:
        plugin: name of the plugin.
        function: takes an address and a number of ints, returns a count ≥ 0 or raises.
        integers: number of ints after the address.
        data: whether the C function takes the `mjData*` of `init`, which is deleted on a refusal.
    """
    addresses = [ctypes.c_void_p] * (3 if data else 2)
    asked = _with_data(function) if data else function
    kind = ctypes.CFUNCTYPE(None, *addresses, *[ctypes.c_int] * integers)
    return kind(_replying(plugin, asked))
