"""Marks of what is compiled: functions, and values that have a meaning in machine code only.

Nothing here imports Numba. To Python, a marked function is a plain function; `compiler` makes
machine code of the functions with `entry` and of all that they call.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Mark a function of numbers and arrays that is compiled into each function that calls it.

    Arrays and offsets would otherwise travel to it as dozens of arguments, a fifth of the time that
    a sheath takes in a step.
    """
    function.__dict__["is_inlined"] = True
    return function


def apart(function: _F) -> _F:
    """Mark a function that most steps do without, and that is compiled once, on its own.

    The loops that every step runs through stay short then.
    """
    function.__dict__["is_inlined"] = False
    return function


class Entry(NamedTuple):
    """A function of the library that C can call."""

    function: Callable[..., Any]
    signature: str


ENTRIES: Final[dict[str, Entry]] = {}  # symbol → function
ARRAYS: Final[dict[str, int]] = {}  # symbol of int64s in the library → how many
ENGINE: Final[list[str]] = []  # functions of MuJoCo, in the order of the array of their addresses
ENGINE_ARRAY: Final = "tendon_mj_engine"
_MOST = 32  # functions of MuJoCo
ARRAYS[ENGINE_ARRAY] = _MOST
CONSTRUCTOR: Final = "tendon_mj_load"  # entry that runs when the library is loaded


def entry(symbol: str, signature: str) -> Callable[[_F], _F]:
    """Mark a function as one of the library's, with a symbol and a signature in C.

    Args:
        symbol: name in the library.
        signature: result and arguments, each ``void``, ``i32``, ``i64``, ``f64``, ``bool``,
            ``ptr``, or the symbol of a struct by its address, such as ``"i32(mjModel, i32)"``.
    """

    def mark(function: _F) -> _F:
        ENTRIES[symbol] = Entry(function, signature)
        return function

    return mark


class _Mark:
    """A value that only compiled functions can use."""

    def __call__(self, *arguments: Any) -> Any:
        raise TypeError(f"{self} exists in machine code only")


class External(_Mark):
    """A function of the C library, by its symbol; pointers travel as integers."""

    def __init__(self, symbol: str, signature: str) -> None:
        self.symbol = symbol
        self.signature = signature


class EngineFunction(External):
    """A function of MuJoCo, called by its address, which a loader writes into an array.

    A program may have loaded MuJoCo where a library that it loads later does not see its symbols.
    """

    def __init__(self, symbol: str, signature: str) -> None:
        super().__init__(symbol, signature)
        ENGINE.append(symbol)


class Word(_Mark):
    """Function of an address: the eight bytes there as int64; they may begin anywhere."""


class Wrapping(_Mark):
    """An operation of int64s mod 2⁶⁴, ``add`` or ``mul``.

    If Numba's `*` and `+` of whole numbers overflow, the compiler may take any result.
    """

    def __init__(self, instruction: str) -> None:
        self.instruction = instruction


class Text(_Mark):
    """Function without arguments: the address of a constant string that ends with a zero."""

    def __init__(self, content: str) -> None:
        self.content = content


class LocalDoubles(_Mark):
    """Function without arguments: the address of so many float64 on the stack.

    They are there until the function that asks for them returns.
    """

    def __init__(self, count: int) -> None:
        self.count = count


class Pointer(_Mark):
    """Function of an address: the numbers there, however many, as a field of a struct has them."""

    def __init__(self, kind: str) -> None:
        self.kind = kind


class Record(_Mark):
    """Function of an address: the record there, sharing the memory."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype


class Array(_Mark):
    """Function of an address and a count: an array of numbers or records, sharing the memory."""

    def __init__(self, dtype: Any) -> None:
        self.dtype = np.dtype(dtype)


class Called(_Mark):
    """Function of the address of a C function, and of its arguments."""

    def __init__(self, signature: str) -> None:
        self.signature = signature


class Addresses(_Mark):
    """Function of an index: the address of one of some entries, by their symbols."""

    def __init__(self, *symbols: str) -> None:
        self.symbols = symbols


class Shared(_Mark):
    """Function without arguments: the address of int64s of the library, which begin as 0.

    Args:
        symbol: name in the library.
        count: how many there are.
    """

    def __init__(self, symbol: str, count: int) -> None:
        self.symbol = symbol
        self.count = ARRAYS[symbol] = count


class Address(_Mark):
    """Function of a struct, or of an array that is a field of one: its address."""


class Constants:
    """Numbers that a loader writes once, before any function runs, such as offsets of fields.

    Args:
        symbol: of their array in the library.
        names: of the numbers, in order.
    """

    def __init__(self, symbol: str, names: Sequence[str]) -> None:
        self.symbol = symbol
        self.names = names
        ARRAYS[symbol] = len(self.names)
        CONSTANTS.append(self)


CONSTANTS: Final[list[Constants]] = []


class Field(NamedTuple):
    """A field of a C struct: a number, another struct, or an array of either."""

    kind: str  # of NumPy, or the symbol of a struct
    dimensions: int = 0  # of an array
    row: int | str = 0  # bytes from one of its rows to the next, or the constant that has them
    is_inline: bool = False  # whether the struct holds the array itself, not its address

    def part(self, dimensions: int) -> Field:
        """What one finds in it with so many dimensions: a number, a struct, or numbers in a row."""
        if dimensions == self.dimensions:
            return self
        return Field(self.kind, dimensions, np.dtype(self.kind).itemsize if dimensions else 0)


class Struct:
    """A C struct, of which compiled code uses fields by name.

    Arrays are indexed as NumPy's in Python: ``m.tendon_range[tendon, 1]``, ``d.xpos[body]`` for a
    row, ``d.wrap_xpos.flat[k]``. They have no length, and no index below 0.

    Args:
        symbol: name, also in signatures.
        prefix: of the constants that have the bytes from its address to each field; of a struct
            within it, to each of that one's fields.
        field: description of each field, None if it has no such field.
    """

    def __init__(self, symbol: str, prefix: str, field: Callable[[str], Field | None]) -> None:
        self.symbol = symbol
        self.prefix = prefix
        self.field = field
        STRUCTS[symbol] = self


STRUCTS: Final[dict[str, Struct]] = {}  # by symbol
