"""From a check in Python to a C function that MuJoCo can call while it compiles a model.

MuJoCo leaves a failed check by a long jump, which must not cross a Python frame: the check leaves a
count or a message in memory of the C function, which raises it after Python has returned. Where
Python could not even begin, as when Ctrl-C comes just then, nothing is left there.

MuJoCo does not free all that it holds when it is left so. Where it asks for the size of a state it
holds a few small lists, between which the heap would fall to pieces: a refusal is a size of 0, and
`init` says why. Where it asks `init` it holds the data, which is deleted here.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from numba import types

from tendon_mj.compilation import callback, compiled
from tendon_mj.errors import TendonError
from tendon_mj.plugin.abi.layout import mirror
from tendon_mj.plugin.abi.library import C, mju_error
from tendon_mj.plugin.abi.memory import integer, local_doubles, set_integer, text

_SIZE = 2048  # of a message, with the zero that ends it
_HEAD = 8  # bytes before it, for the count
_REFUSED, _SILENT = -1, -2  # counts
_reply = local_doubles((_HEAD + _SIZE) // 8)
_interrupted = text("tendon_mj: interrupted while the model was compiled")

_i32, _ptr = types.int32, types.intp


def _replying(plugin: str, function: Callable[..., int]) -> Callable[..., None]:
    """Leave what a function returns at an address, or −1 and the message of its exception."""

    def reply(address: int, *arguments: int) -> None:
        try:
            count = function(*arguments)
        except Exception as error:
            said = str(error) if isinstance(error, TendonError) else f"{plugin}: {error!r}"
            fits = said.encode()[: (_SIZE - 1) // 2].decode(errors="ignore")
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
        except Exception:
            mirror("mjData").from_address(d).nplugin = instance  # only those before it have begun
            C.mj_deleteData(d)
            raise

    return check


@compiled
def _count_at(reply: int) -> int:
    """The count in a reply; raises its message in MuJoCo where there is none."""
    count = integer(reply, 0)
    if count == _SILENT:
        mju_error(_interrupted())
    if count < 0:
        mju_error(reply + _HEAD)
    return count


class Check:
    """A C function `int (const mjModel*, …)` that asks Python and raises what Python refuses.

    That of `nstate`, with one int and no data, returns 0 instead.

    Args:
        plugin: whose check it is.
        function: Python, takes an address and a number of ints, returns a count ≥ 0 or raises.
        integers: how many ints follow the address.
        data: whether the C function takes the `mjData*` of `init`, which is deleted on a refusal.
    """

    def __init__(
        self, plugin: str, function: Callable[..., int], integers: int = 1, data: bool = False
    ) -> None:
        count = 3 if data else 2
        addresses, ints = [ctypes.c_void_p] * count, [ctypes.c_int] * integers
        asked = _with_data(function) if data else function
        self._python = ctypes.CFUNCTYPE(None, *addresses, *ints)(_replying(plugin, asked))
        # by name, not by address, so that compiled code holds in every process
        symbol = f"{plugin}.{function.__name__}"
        llvm.add_symbol(symbol, ctypes.cast(self._python, ctypes.c_void_p).value)
        ask = types.ExternalFunction(symbol, types.void(*[_ptr] * count, *[_i32] * integers))
        self._compiled = _init(ask) if data else _count(ask) if integers == 1 else _sensor(ask)
        self.address: int = self._compiled.address


def _count(ask: Any) -> Any:
    @callback(_i32(_ptr, _i32))
    def nstate(m: int, instance: int) -> int:
        reply = _reply()
        set_integer(reply, _SILENT)
        ask(reply, m, instance)
        return 0 if integer(reply, 0) == _REFUSED else _count_at(reply)

    return nstate


def _sensor(ask: Any) -> Any:
    @callback(_i32(_ptr, _i32, _i32))
    def nsensordata(m: int, instance: int, sensor: int) -> int:
        reply = _reply()
        set_integer(reply, _SILENT)
        ask(reply, m, instance, sensor)
        return _count_at(reply)

    return nsensordata


def _init(ask: Any) -> Any:
    @callback(_i32(_ptr, _ptr, _i32))
    def init(m: int, d: int, instance: int) -> int:
        reply = _reply()
        set_integer(reply, _SILENT)
        ask(reply, m, d, instance)
        _count_at(reply)
        return 0

    return init
