"""Compilation of functions to machine code by Numba: cached, and rounding as written.

No `fastmath`: results must not depend on how the compiler reorders sums, since a resumed
simulation has to repeat itself bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable[..., object])


def compiled(function: _F) -> _F:
    """Compile a function of numbers and arrays to machine code, kept on disk between runs.

    What one compiled function calls is inlined: arrays and offsets would otherwise travel to every
    callee as dozens of arguments, a fifth of the time that a sheath takes in a step.
    """
    return cast(
        _F, numba.njit(cache=True, error_model="numpy", nogil=True, forceinline=True)(function)
    )


def apart(function: _F) -> _F:
    """Compile what most steps do without, and leave it out of line.

    The loops that every step runs through stay short then, and compiling them takes half as long.
    """
    return cast(_F, numba.njit(cache=True, error_model="numpy", nogil=True)(function))


def checked(function: _F) -> _F:
    """Compile a function in which a division by zero raises, as in Python."""
    return cast(_F, numba.njit(cache=True)(function))
