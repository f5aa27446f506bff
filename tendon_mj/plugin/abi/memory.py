"""C memory from compiled code, and whole numbers that wrap around at 2⁶⁴."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.core import cgutils
from numba.extending import intrinsic

from tendon_mj.compilation import compiled
from tendon_mj.typing import FloatArray


@intrinsic
def word(typing_context: Any, address: Any) -> Any:
    """The eight bytes at ``address`` as an int64; they may begin anywhere."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = context.get_value_type(signature.return_type)
        value = builder.load(builder.inttoptr(arguments[0], kind.as_pointer()))
        value.align = 1
        return value

    return numba.int64(address), build


def _as_pointer(item: Any) -> Any:
    @intrinsic
    def cast(typing_context: Any, address: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

        return types.CPointer(item)(address), build

    return cast


def text(content: str) -> Any:
    """Function without arguments that gives the address of a text as C has it."""

    @intrinsic
    def address(typing_context: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            constant = context.insert_const_string(builder.module, content)
            return builder.ptrtoint(constant, context.get_value_type(types.intp))

        return types.intp(), build

    return address


def local_doubles(count: int) -> Any:
    """Function without arguments that gives the address of ``count`` mjtNum on the stack.

    They are there until the function that asks for them returns.
    """

    @intrinsic
    def address(typing_context: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            numbers = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), count))
            return builder.ptrtoint(numbers, context.get_value_type(types.intp))

        return types.intp(), build

    return address


_f32 = _as_pointer(numba.float32)
_f64 = _as_pointer(numba.float64)
_i32 = _as_pointer(numba.int32)
_i64 = _as_pointer(numba.int64)
_u8 = _as_pointer(numba.uint8)


@compiled
def pointer(address: int) -> int:
    """The pointer stored at ``address``."""
    return _i64(address)[0]


@compiled
def doubles(address: int, count: int) -> FloatArray:
    """``count`` mjtNum at ``address`` as an array that shares the memory."""
    numbers: FloatArray = carray(_f64(address), (count,))
    return numbers


@compiled
def coordinates(address: int) -> FloatArray:
    """The mjtNum at ``address``, however many: a C pointer, whose indices do not wrap around."""
    numbers: FloatArray = _f64(address)
    return numbers


def record_at(dtype: np.dtype[Any]) -> Any:
    """Function of an address that gives the record there, sharing the memory.

    It is an intrinsic, as a compiled function would return a copy of the record.
    """
    kind = numba.from_dtype(dtype)

    @intrinsic
    def record(typing_context: Any, address: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], context.get_value_type(kind))

        return kind(address), build

    return record


def records_pointer(dtype: np.dtype[Any]) -> Any:
    """Function of an address that gives a pointer to records, which `carray` makes an array of."""
    return _as_pointer(numba.from_dtype(dtype))


@compiled
def double(address: int, index: int) -> float:
    """The mjtNum number ``index`` of the array at ``address``."""
    return _f64(address)[index]


@compiled
def integer(address: int, index: int) -> int:
    """The int number ``index`` of the array at ``address``."""
    return numba.int64(_i32(address)[index])


@compiled
def single(address: int, index: int) -> float:
    """The float number ``index`` of the array at ``address``."""
    return numba.float64(_f32(address)[index])


@compiled
def set_single(address: int, index: int, value: float) -> None:
    """Write the float number ``index`` of the array at ``address``."""
    _f32(address)[index] = value


@compiled
def set_integer(address: int, value: int) -> None:
    """Write the int at ``address``."""
    _i32(address)[0] = value


@compiled
def size(address: int) -> int:
    """The mjtSize at ``address``."""
    return _i64(address)[0]


@compiled
def set_byte(address: int, value: int) -> None:
    """Write the byte at ``address``."""
    _u8(address)[0] = value


@compiled
def byte(address: int, index: int) -> int:
    """The byte number ``index`` at ``address``."""
    return numba.int64(_u8(address)[index])


def _wrapping(instruction: str) -> Any:
    """An operation of int64s mod 2⁶⁴.

    Where Numba's `*` and `+` of whole numbers overflow, the compiler may take any result.
    """

    @intrinsic
    def operation(typing_context: Any, a: Any, b: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return getattr(builder, instruction)(*arguments)

        return numba.int64(numba.int64, numba.int64), build

    return operation


times, plus = _wrapping("mul"), _wrapping("add")
