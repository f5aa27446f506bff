"""The catalogue: every effect that a diagnosis can name unless it is given other ones."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Final

from tendon_mj.diagnosis.effects.effect import Candidate, Effect, SystemDescription
from tendon_mj.diagnosis.effects.joints import JOINTS
from tendon_mj.diagnosis.effects.parameters import PARAMETERS
from tendon_mj.diagnosis.effects.sensors import SENSORS
from tendon_mj.diagnosis.effects.transmission import TRANSMISSION
from tendon_mj.errors import InvalidValueError, UnknownNameError

Effects = Mapping[str, Effect] | Iterable[Effect]  # of a mapping the values count


def by_identifier(effects: Effects) -> dict[str, Effect]:
    """Identifier → effect, in the given order.

    Raises:
        InvalidValueError: two effects have the same identifier.
    """
    found: dict[str, Effect] = {}
    for effect in effects.values() if isinstance(effects, Mapping) else effects:
        if effect.identifier in found:
            raise InvalidValueError(f"two effects are called {effect.identifier!r}")
        found[effect.identifier] = effect
    return found


CATALOGUE: Final = by_identifier((*TRANSMISSION, *JOINTS, *SENSORS, *PARAMETERS))


def candidates(
    system: SystemDescription,
    exclude: Collection[str] = (),
    catalogue: Mapping[str, Effect] = CATALOGUE,
) -> list[Candidate]:
    """Every effect of a catalogue bound to a model, but those excluded.

    Raises:
        UnknownNameError: an excluded identifier that is not in the catalogue.
    """
    for identifier in exclude:
        if identifier not in catalogue:
            raise UnknownNameError("effect", identifier, catalogue)
    return [
        candidate
        for identifier, effect in catalogue.items()
        if identifier not in exclude
        for candidate in effect.bind(system)
    ]
