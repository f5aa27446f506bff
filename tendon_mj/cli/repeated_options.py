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
    """Arguments in which each of the options stands once, with the values of all its places.

    ``--change a b --change c`` becomes ``--change a b c``; the last place alone would count
    otherwise.
    """
    groups: list[list[str]] = [[]]  # each begins with an option, but for the first
    places: dict[str, list[str]] = {}
    for argument in arguments:
        if argument.startswith("--"):
            name = argument.replace("_", "-")
            if name in places:
                groups.append(places[name])  # goes on where it stood first
                continue
            groups.append([argument])
            if name in options:
                places[name] = groups[-1]
        else:
            groups[-1].append(argument)
    unique = {id(group): group for group in groups}
    return [argument for group in unique.values() for argument in group]
