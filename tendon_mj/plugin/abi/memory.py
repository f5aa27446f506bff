"""C memory from compiled code, and whole numbers that wrap around at 2⁶⁴."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tendon_mj.native import Address, Array, Pointer, Word, Wrapping, compiled
from tendon_mj.typing import FloatArray

# address of a struct, or of an array in it: address_of(m.plugin_attr)
address_of: Callable[[Any], int] = Address()
# ``count`` mjtNum as an array that shares the memory: doubles(address, count)
doubles: Callable[[int, int], FloatArray] = Array("float64")
# numbers at an address, however many: mjtNum, int, eight bytes, bytes
coordinates: Callable[[int], FloatArray] = Pointer("float64")
integers: Callable[[int], Any] = Pointer("int32")
words: Callable[[int], Any] = Pointer("int64")
letters: Callable[[int], Any] = Pointer("uint8")
# the eight bytes at an address, which may begin anywhere: word(address)
word: Callable[[int], int] = Word()
times: Callable[[int, int], int] = Wrapping("mul")
plus: Callable[[int, int], int] = Wrapping("add")


@compiled
def copy_doubles(target: int, source: int, count: int) -> None:
    """Copy ``count`` mjtNum from one address to another."""
    copied, kept = doubles(target, count), doubles(source, count)
    for k in range(count):
        copied[k] = kept[k]
