"""Help of the commands: the text of their docstrings, and an example of each at the end."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from types import FunctionType
from typing import cast

Command = Callable[..., object]
_EXAMPLE = re.compile(r"\n+ *Example:\n((?: +.*\n?)+?)(?=\n|\Z)")
_CONTINUED = re.compile(r"\n {8,}")  # a line that goes on the description of an argument


def example(command: Command) -> str:
    """The line below `Example:` in a command's docstring; empty where it has none."""
    found = _EXAMPLE.search(inspect.getdoc(command) or "")
    return found[1].strip() if found else ""


def documented(command: Command) -> Command:
    """A command whose docstring has each argument in one line, for the terminal to wrap.

    The example is left out; `example` has it.
    """

    given = cast(FunctionType, command)
    same = FunctionType(given.__code__, given.__globals__, given.__name__, given.__defaults__)
    same.__annotations__, same.__kwdefaults__ = given.__annotations__, given.__kwdefaults__
    same.__doc__ = _CONTINUED.sub(" ", _EXAMPLE.sub("", inspect.getdoc(given) or ""))
    return same
