"""From a check in Python to a C function that MuJoCo can call while it compiles a model.

MuJoCo leaves a failed check by a long jump, which must not cross a Python frame: the check leaves a
message behind, and compiled code raises it after Python has returned. Python may let another thread
compile its model in between, so every thread has a message of its own.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from numba import types

from tendon_mj.abi.library import mju_error
from tendon_mj.compilation import callback
from tendon_mj.errors import TendonError

_SIZE = 2048
_messages: dict[int, Any] = {}  # by thread; kept, as a thread that C started has no Python object


def _message_of_thread() -> Any:
    """The calling thread's message."""
    thread = threading.get_ident()
    if thread not in _messages:
        _messages[thread] = ctypes.create_string_buffer(_SIZE)
    return _messages[thread]


_i32, _ptr = types.int32, types.intp
# By name, not by address, so that compiled code holds in every process.
_address = ctypes.CFUNCTYPE(ctypes.c_void_p)(lambda: ctypes.addressof(_message_of_thread()))
llvm.add_symbol("tendon_mj.message", ctypes.cast(_address, ctypes.c_void_p).value)
_message = types.ExternalFunction("tendon_mj.message", _ptr())


def _guarded(plugin: str, function: Callable[..., int]) -> Callable[..., int]:
    """Turn an exception into −1 and a message, for the C side to raise after Python has left."""

    def call(*arguments: int) -> int:
        try:
            return function(*arguments)
        except Exception as error:
            said = str(error) if isinstance(error, TendonError) else f"{plugin}: {error!r}"
            text = said.replace("%", "%%").encode()
            _message_of_thread().value = text[: _SIZE - 1]
            return -1

    return call


class Check:
    """A C function `int (const mjModel*, …)` that asks Python and raises what Python refuses.

    Args:
        plugin: whose check it is.
        function: Python, takes an address and a number of ints, returns a count ≥ 0 or raises.
        integers: how many ints follow the address.
        data: whether the C function takes the `mjData*` of `init`, which the check does not see.
    """

    def __init__(
        self, plugin: str, function: Callable[..., int], integers: int = 1, data: bool = False
    ) -> None:
        ints = [ctypes.c_int] * integers
        self._python = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, *ints)(
            _guarded(plugin, function)
        )
        symbol = f"{plugin}.{function.__name__}"
        llvm.add_symbol(symbol, ctypes.cast(self._python, ctypes.c_void_p).value)
        ask = types.ExternalFunction(symbol, _i32(_ptr, *[_i32] * integers))
        self._compiled = _init(ask) if data else _count(ask) if integers == 1 else _sensor(ask)
        self.address: int = self._compiled.address


def _count(ask: Any) -> Any:
    @callback(_i32(_ptr, _i32))
    def nstate(m: int, instance: int) -> int:
        count = ask(m, instance)
        if count < 0:
            mju_error(_message())
        return count

    return nstate


def _sensor(ask: Any) -> Any:
    @callback(_i32(_ptr, _i32, _i32))
    def nsensordata(m: int, instance: int, sensor: int) -> int:
        count = ask(m, instance, sensor)
        if count < 0:
            mju_error(_message())
        return count

    return nsensordata


def _init(ask: Any) -> Any:
    @callback(_i32(_ptr, _ptr, _i32))
    def init(m: int, d: int, instance: int) -> int:
        if ask(m, instance) < 0:
            mju_error(_message())
        return 0

    return init
