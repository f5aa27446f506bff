"""C memory from compiled code, and whole numbers that wrap around at 2⁶⁴."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tendon_mj.native import Address, Array, Load, Pointer, Store, Word, Wrapping, compiled
from tendon_mj.typing import FloatArray

# address of a struct, or of an array in it: address_of(m.plugin_attr)
address_of: Callable[[Any], int] = Address()
# number ``index`` of an array of mjtNum, float, int or bytes: double(address, index)
double: Callable[[int, int], float] = Load("float64")
single: Callable[[int, int], float] = Load("float32")
integer: Callable[[int, int], int] = Load("int32")
byte: Callable[[int, int], int] = Load("uint8")
_int64: Callable[[int, int], int] = Load("int64")
set_single: Callable[[int, int, float], None] = Store("float32")
_set_int64: Callable[[int, int, int], None] = Store("int64")
_set_int32: Callable[[int, int, int], None] = Store("int32")
_set_uint8: Callable[[int, int, int], None] = Store("uint8")

# ``count`` mjtNum as an array that shares the memory: doubles(address, count)
doubles: Callable[[int, int], FloatArray] = Array("float64")
# the mjtNum at an address, however many: coordinates(address)
coordinates: Callable[[int], FloatArray] = Pointer("float64")
# the eight bytes at an address, which may begin anywhere: word(address)
word: Callable[[int], int] = Word()
times: Callable[[int, int], int] = Wrapping("mul")
plus: Callable[[int, int], int] = Wrapping("add")


@compiled
def pointer(address: int) -> int:
    """The pointer stored at ``address``."""
    return _int64(address, 0)


@compiled
def size(address: int) -> int:
    """The mjtSize at ``address``."""
    return _int64(address, 0)


@compiled
def set_integer(address: int, value: int) -> None:
    """Write the int at ``address``."""
    _set_int32(address, 0, value)


@compiled
def set_byte(address: int, value: int) -> None:
    """Write the byte at ``address``."""
    _set_uint8(address, 0, value)


@compiled
def set_pointer(address: int, value: int) -> None:
    """Write the pointer at ``address``."""
    _set_int64(address, 0, value)


@compiled
def set_word(address: int, value: int) -> None:
    """Write the eight bytes at ``address``."""
    _set_int64(address, 0, value)


@compiled
def copy_doubles(target: int, source: int, count: int) -> None:
    """Copy ``count`` mjtNum from one address to another."""
    copied, kept = doubles(target, count), doubles(source, count)
    for k in range(count):
        copied[k] = kept[k]
