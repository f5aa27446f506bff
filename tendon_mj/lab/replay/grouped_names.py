"""Names that stand for several parameters, such as ``sheath_*.friction``."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from typing import TypeVar

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.recordings import Recording

Entry = TypeVar("Entry")

_WILD = frozenset("*?[")


def matching(name: str, names: Collection[str], where: str = "") -> list[str]:
    """Parameters that a name stands for: itself, or all that fit its `*`, `?` and `[…]`.

    ``where`` begins the message of an error.

    Raises:
        UnknownNameError: wildcards that no parameter fits.
    """
    if name in names or not _WILD & set(name):
        return [name]
    found = sorted(n for n in names if fnmatchcase(n, name))
    if not found:
        raise UnknownNameError("parameter", name, names, where)
    return found


def expand(table: Mapping[str, Entry], names: Collection[str]) -> dict[str, Entry]:
    """Parameter → entry of a table whose names may stand for several; a plain name goes first."""
    expanded = {n: entry for name, entry in table.items() for n in matching(name, names)}
    return expanded | {name: entry for name, entry in table.items() if name in expanded}


def claims(recording: Recording, names: Collection[str]) -> dict[str, tuple[str, str]]:
    """Parameter → (table, name in it) of a recording that says what it is; a plain name goes first.

    Raises:
        InvalidValueError: two names with wildcards, or two tables, speak of one parameter alike.
        UnknownNameError: wildcards that no parameter fits.
    """
    tables: Mapping[str, Mapping[str, object]] = {
        "known": recording.known,
        "uncertain": recording.uncertain,
        "session": recording.session,
    }
    found: dict[str, tuple[str, str]] = {}
    for title, table in tables.items():
        for name in table:
            for target in matching(name, names):
                other = found.get(target)
                if other is None or (name == target and other[1] != target):
                    found[target] = title, name
                elif (name == target) == (other[1] == target):
                    raise InvalidValueError(
                        f"{target!r} is meant by {other[1]!r} in [{other[0]}] and by {name!r} in"
                        f" [{title}]; leave one of them out, or name the parameter itself"
                    )
    return found
