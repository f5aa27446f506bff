"""Names of what was set anew for each recording: ``<parameter> @ <recording>``."""

from __future__ import annotations

from collections.abc import Collection, Mapping

_AT = " @ "


def name_in_session(parameter: str, recording: str) -> str:
    """Name of a parameter's value in one recording."""
    return f"{parameter}{_AT}{recording}"


def parameter_of(name: str) -> str:
    """The parameter that a name is of, in one recording or in all."""
    return name.partition(_AT)[0]


def recording_of(name: str) -> str:
    """The recording that a name is for; empty where it is for all."""
    return name.partition(_AT)[2]


def value_in(values: Mapping[str, float], name: str) -> float:
    """Value of a name, in one recording that of the parameter in all where it has none there."""
    return values.get(name, values[parameter_of(name)])


def values_in(
    recordings: Collection[str], values: Mapping[str, float], parameters: Collection[str]
) -> dict[str, float]:
    """The values but for those that parameters have in other recordings than these.

    What is no name of a parameter stays, for the simulator to refuse.
    """

    def holds(name: str) -> bool:
        own = _AT in name and parameter_of(name) in parameters
        return not own or recording_of(name) in recordings

    return {name: value for name, value in values.items() if holds(name)}


def values_for(recording: str, values: Mapping[str, float]) -> dict[str, float]:
    """Parameter → value that holds in one recording, its own before what holds in all."""
    common = {name: value for name, value in values.items() if _AT not in name}
    own = {
        parameter_of(name): value
        for name, value in values.items()
        if _AT in name and recording_of(name) == recording
    }
    return common | own
