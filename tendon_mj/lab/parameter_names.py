"""Names of parameters, ``<element>.<parameter>``, in recordings and for single recordings.

``sheath_*.friction`` stands for several parameters, and ``<parameter> @ <recording>`` for the value
of one in a single recording.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from typing import TypeVar

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.recordings import Recording

Entry = TypeVar("Entry")

_WILD = frozenset("*?[")
_AT = " @ "


def matching(name: str, names: Collection[str], where: str = "") -> list[str]:
    """Parameters that a name stands for: itself, or all that fit its `*`, `?` and `[…]`."""
    if name in names or not _WILD & set(name):
        return [name]
    fitting = sorted(n for n in names if fnmatchcase(n, name))
    if not fitting:
        raise UnknownNameError("parameter", name, names, where)
    return fitting


def expand(table: Mapping[str, Entry], names: Collection[str]) -> dict[str, Entry]:
    """Parameter → entry of a table whose names may stand for several; a plain name goes first."""
    expanded = {n: entry for name, entry in table.items() for n in matching(name, names)}
    return expanded | {name: entry for name, entry in table.items() if name in expanded}


def claims(recording: Recording, names: Collection[str]) -> dict[str, tuple[str, str]]:
    """Parameter → (table, name in it) of a recording that describes it; a plain name goes first."""
    claimed: dict[str, tuple[str, str]] = {}
    for title in ("known", "uncertain", "session"):
        for name in getattr(recording, title):
            for target in matching(name, names):
                other = claimed.get(target)
                if other is None or (name == target and other[1] != target):
                    claimed[target] = title, name
                elif (name == target) == (other[1] == target):
                    raise InvalidValueError(
                        f"{target!r} is meant by {other[1]!r} in [{other[0]}] and by {name!r} in"
                        f" [{title}]; leave one of them out, or name the parameter itself"
                    )
    return claimed


def name_in_session(parameter: str, recording: str) -> str:
    """Name of a parameter's value in one recording."""
    return f"{parameter}{_AT}{recording}"


def parameter_of(name: str) -> str:
    """The parameter of a name, in one recording or in all."""
    return name.partition(_AT)[0]


def recording_of(name: str) -> str:
    """The recording of a name; empty where it is for all."""
    return name.partition(_AT)[2]


def value_in(values: Mapping[str, float], name: str) -> float:
    """Value of a name; without one in its recording, that of the parameter in all."""
    return values.get(name, values[parameter_of(name)])


def values_in(
    recordings: Collection[str], values: Mapping[str, float], parameters: Collection[str]
) -> dict[str, float]:
    """The values without those of parameters in other recordings than these.

    A name of no parameter stays, for the simulator to refuse.
    """
    return {
        name: value
        for name, value in values.items()
        if recording_of(name) in {"", *recordings} or parameter_of(name) not in parameters
    }


def values_for(recording: str, values: Mapping[str, float]) -> dict[str, float]:
    """Parameter → value that holds in one recording, its own before that in all."""
    common = {name: value for name, value in values.items() if _AT not in name}
    in_session = {
        parameter_of(name): value
        for name, value in values.items()
        if _AT in name and recording_of(name) == recording
    }
    return common | in_session
