"""Names that stand for several parameters, such as ``sheath_*.friction``."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from typing import TypeVar

from tendon_mj.errors import UnknownNameError

Entry = TypeVar("Entry")

_WILD = frozenset("*?[")


def matching(name: str, names: Collection[str]) -> list[str]:
    """Parameters that a name stands for: itself, or all that fit its `*`, `?` and `[…]`.

    Raises:
        UnknownNameError: wildcards that no parameter fits.
    """
    if name in names or not _WILD & set(name):
        return [name]
    found = sorted(n for n in names if fnmatchcase(n, name))
    if not found:
        raise UnknownNameError("parameter", name, names)
    return found


def expand(table: Mapping[str, Entry], names: Collection[str]) -> dict[str, Entry]:
    """Parameter → entry of a table whose names may stand for several; a plain name goes first."""
    expanded = {n: entry for name, entry in table.items() for n in matching(name, names)}
    return expanded | {name: entry for name, entry in table.items() if name in expanded}
