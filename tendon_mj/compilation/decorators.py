"""Decorators that compile.

No `fastmath`: results must not depend on how the compiler reorders sums, since a resumed
simulation has to repeat itself bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import llvmlite.binding as llvm
import numba
from numba import types
from numba.core.ccallback import CFunc
from numba.core.sigutils import normalize_signature

from tendon_mj.compilation.cache import Cache, announced

_F = TypeVar("_F", bound=Callable[..., object])
_callbacks: list[Any] = []  # whose machine code stays where it is as long as they do


def compiled(function: _F) -> _F:
    """Compile a function of numbers and arrays to machine code, kept on disk between runs.

    Its callees are inlined: arrays and offsets would otherwise travel to every callee as dozens of
    arguments, a fifth of the time that a sheath takes in a step.
    """
    return _kept(function, error_model="numpy", nogil=True, forceinline=True)


def apart(function: _F) -> _F:
    """Compile a function that most steps do without, and leave it out of line.

    The loops that every step runs through stay short then, and compiling them takes half as long.
    """
    return _kept(function, error_model="numpy", nogil=True)


def checked(function: _F) -> _F:
    """Compile a function in which a division by zero raises, as in Python."""
    return _kept(function)


def callback(signature: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function that C calls, at once and for one signature of `numba.cfunc`.

    The decorated function has its ``address``.
    """

    def compile_callback(function: Callable[..., Any]) -> Any:
        made: Any = CFunc(function, normalize_signature(signature), locals={}, options={})
        made._cache = Cache(function, wrapped=False)
        made.compile()
        return made

    return compile_callback


def by_symbol(symbol: str, signature: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function that compiled code calls by a symbol, and contains none of its code."""

    def compile_callback(function: Callable[..., Any]) -> Any:
        if numba.core.config.DISABLE_JIT:
            return function
        with announced():
            made = callback(signature)(function)
        _callbacks.append(made)
        llvm.add_symbol(symbol, made.address)
        return types.ExternalFunction(symbol, signature)

    return compile_callback


def _kept(function: _F, **options: Any) -> _F:
    made: Any = numba.njit(**options)(function)
    if made is not function:  # as it is where NUMBA_DISABLE_JIT is set
        # not `cache=True`: Numba's own cache does not notice a changed callee
        made._cache = Cache(function)
    return cast(_F, made)
