"""A command as it can be typed again."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping


def typed_command(name: str, words: Iterable[object], options: Mapping[str, object]) -> str:
    """Name, words and options of a command, quoted for a shell.

    Args:
        name: of the command of `tendon-mj`.
        words: that follow it.
        options: option → its value, or a tuple of all that follow it. One that is None, False or
            empty is left out, and True stands for the option alone.
    """
    typed = ["tendon-mj", name, *map(str, words)]
    for option, given in options.items():
        values = given if isinstance(given, tuple) else (given,)
        if values and given is not None and given is not False:
            typed += [option, *(str(value) for value in values if value is not True)]
    return shlex.join(typed)
