"""Options that take several values and are given more than once."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from tendon_mj.cli.help import Command


def options_of_several(commands: Collection[Command]) -> set[str]:
    """Options that take any number of values, like ``--hold-out``."""
    return {
        f"--{name.replace('_', '-')}"
        for command in commands
        for name, kind in command.__annotations__.items()
        if str(kind).startswith("tuple[")
    }


def gathered(arguments: Sequence[str], options: Collection[str]) -> list[str]:
    """Arguments in which each of the options stands once, at the end, with all its values.

    ``--change a b --out o --change=c`` becomes ``--out o --change a b c``; the last place alone
    would count otherwise. Behind a ``=`` stands one value, and what follows is no other.
    """
    rest: list[str] = []
    values: dict[str, list[str]] = {}
    place = rest  # of what follows
    for argument in arguments:
        if argument.startswith("--"):
            typed, equals, value = argument.partition("=")
            name = typed.replace("_", "-")
            place = rest
            if name in options:
                given = values.setdefault(name, [])
                if equals:
                    given.append(value)
                else:
                    place = given
                continue
        place.append(argument)
    return [*rest, *(word for name, given in values.items() for word in (name, *given))]
