"""The catalogue: every effect that a diagnosis can name unless it is given other ones."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping
from typing import Final

from tendon_mj.errors import InvalidValueError, UnknownNameError, unknown
from tendon_mj.lab.diagnosis.effects.actuators import ACTUATORS
from tendon_mj.lab.diagnosis.effects.binding import parameters_of
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, SystemDescription
from tendon_mj.lab.diagnosis.effects.joints import JOINTS
from tendon_mj.lab.diagnosis.effects.parameters import PARAMETERS
from tendon_mj.lab.diagnosis.effects.sensors import SENSORS
from tendon_mj.lab.diagnosis.effects.transmission import TRANSMISSION

Effects = Mapping[str, Effect] | Iterable[Effect]  # of a mapping the values count


def by_identifier(effects: Effects) -> dict[str, Effect]:
    """Identifier → effect, in the given order.

    Raises:
        InvalidValueError: there is no effect, something is none, or two have the same identifier.
    """
    if isinstance(effects, str | Effect) or not isinstance(effects, Iterable):
        shown = effects.identifier if isinstance(effects, Effect) else effects
        raise InvalidValueError(f"catalogue: {shown!r} is no list of effects, such as [effect]")
    found: dict[str, Effect] = {}
    for effect in effects.values() if isinstance(effects, Mapping) else effects:
        if not isinstance(effect, Effect):
            raise InvalidValueError(
                f"catalogue: {effect!r} is no tendon_mj.Effect; those of the package are the values"
                " of tendon_mj.CATALOGUE, such as CATALOGUE['backlash']"
            )
        if effect.identifier in found:
            raise InvalidValueError(f"two effects are called {effect.identifier!r}")
        found[effect.identifier] = effect
    if not found:
        raise InvalidValueError("the catalogue is empty: a diagnosis needs an effect to name")
    return found


CATALOGUE: Final = by_identifier((*TRANSMISSION, *JOINTS, *ACTUATORS, *SENSORS, *PARAMETERS))


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


def check_bindings(
    system: SystemDescription, exclude: Collection[str], catalogue: Mapping[str, Effect]
) -> None:
    """Warn of each effect of one's own, not excluded, that binds nowhere on a model.

    An effect of the package that has no place on a model is nothing to wonder at.

    Raises:
        InvalidValueError: no effect of the catalogue binds anywhere.
    """
    idle = [effect for effect in catalogue.values() if not effect.binding(system)]
    if len(idle) == len(catalogue):
        reasons = "; ".join(f"{e.identifier!r}: {_why_nowhere(e, system)}" for e in idle[:3])
        more = f"; and {len(idle) - 3} more" if len(idle) > 3 else ""
        raise InvalidValueError(f"no effect of the catalogue binds on the model: {reasons}{more}")
    for effect in idle:
        if effect.identifier not in exclude and all(effect is not e for e in CATALOGUE.values()):
            warnings.warn(
                f"effect {effect.identifier!r} binds nowhere on the model and will not be named:"
                f" {_why_nowhere(effect, system)}",
                RuntimeWarning,
                stacklevel=3,  # who called `diagnose`
            )


def _why_nowhere(effect: Effect, system: SystemDescription) -> str:
    """Reason why an effect binds nowhere, with the names of parameters that come near."""
    there = {name.rsplit(".", 1)[-1] for name in system.values}
    wanted = parameters_of(effect.binding)
    absent = sorted(wanted - there)
    if absent:
        return "; ".join(unknown("parameter", name, there) for name in absent)
    near = sorted(n for n in system.values if not wanted or n.rsplit(".", 1)[-1] in wanted)
    shown = ", ".join(map(repr, near[:20])) + (", …" if len(near) > 20 else "")
    return f"its binding finds no place among {shown or 'no parameters'}"
