"""Keyword arguments that are the fields of a dataclass of parameters.

A function takes them as ``**parameters``; its signature and its docstring name each one.
"""

from __future__ import annotations

import inspect
import operator
from collections.abc import Callable, Iterable, Mapping
from typing import Any, SupportsIndex, TypeVar

import numpy as np

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath import Parameter

_F = TypeVar("_F", bound=Callable[..., object])
MARK = "<parameters>"  # line of a docstring that the parameters' lines replace


def takes(known: Mapping[str, Parameter]) -> Callable[[_F], _F]:
    """Decorator of a function with ``**parameters``: `help` and `inspect.signature` show each."""

    def decorate(function: _F) -> _F:
        signature = inspect.signature(function)
        stated = [p for p in signature.parameters.values() if p.kind != p.VAR_KEYWORD]
        named = {p.name for p in stated}
        derived = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if p.required else p.default,
                annotation="float" if p.required or p.default is not None else "float | None",
            )
            for name, p in known.items()
            if name not in named
        ]
        split = next(k for k, p in enumerate(stated) if p.kind == p.KEYWORD_ONLY)
        # first required ones, then the other parameters, then the function's own keywords
        keywords = sorted(
            [*stated[split:], *derived],
            key=lambda p: (p.default is not p.empty, p.name not in known),
        )
        shown = signature.replace(parameters=[*stated[:split], *keywords])
        vars(function)["__signature__"] = shown
        if function.__doc__:  # python -OO has none
            head, _, tail = function.__doc__.partition(MARK)
            indent = head[head.rfind("\n") + 1 :]  # Python 3.13 takes some of it away
            lines = [f"{name}: {known[name].line()}" for name in known]
            function.__doc__ = head + f"\n{indent}".join(lines) + tail
        return function

    return decorate


def check_names(known: Mapping[str, Parameter], values: Mapping[str, object], where: str) -> None:
    """Refuse names of unknown parameters."""
    for name in values:
        if name not in known:
            raise UnknownNameError("parameter", name, known, where)


def one_of(keyword: str, value: object, known: Iterable[str], where: str) -> str:
    """A keyword's value, which must be one of the known words."""
    if not isinstance(value, str) or value not in known:
        raise UnknownNameError(keyword, str(value), known, where)
    return value


def checked_number(name: str, value: Any, unit: str = "") -> float:
    """A keyword's value as a number, which no bool or text is; ``unit`` ends messages, as " [N]".

    Raises:
        InvalidValueError: not a number, several, or one that no float can hold.
    """
    try:
        if isinstance(value, bool | np.bool_ | str | bytes) or np.ndim(value):
            raise TypeError  # NumPy's text converts itself
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise InvalidValueError(f"{name} = {value!r} is not a number{unit}") from None


def as_count(name: str, value: SupportsIndex, least: int) -> int:
    """A keyword's value as a whole number ≥ ``least``."""
    try:
        count = -1 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        count = -1
    if count < least:
        raise InvalidValueError(f"{name} = {value!r} must be a whole number ≥ {least}")
    return count
