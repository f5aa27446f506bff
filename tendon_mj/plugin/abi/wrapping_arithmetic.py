"""Whole numbers that wrap around at 2⁶⁴.

Where `*` and `+` of whole numbers overflow, Numba leaves the result to the compiler, which then may
take any.
"""

from __future__ import annotations

from typing import Any

import numba
from numba.extending import intrinsic


@intrinsic
def times(typing_context: Any, a: Any, b: Any) -> Any:
    """a · b mod 2⁶⁴, as an int64."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.mul(*arguments)

    return numba.int64(numba.int64, numba.int64), build


@intrinsic
def plus(typing_context: Any, a: Any, b: Any) -> Any:
    """a + b mod 2⁶⁴, as an int64."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.add(*arguments)

    return numba.int64(numba.int64, numba.int64), build
