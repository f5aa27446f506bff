"""Catalogue: the effects that a diagnosis can name unless it is given others."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping
from typing import Final

from tendon_mj.errors import InvalidValueError, UnknownNameError, unknown
from tendon_mj.lab.diagnosis.effects.binding import written_parameters
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, SystemDescription
from tendon_mj.lab.diagnosis.effects.mechanism import ACTUATORS, JOINT_EFFECTS, SENSOR_EFFECTS
from tendon_mj.lab.diagnosis.effects.sheath import PARAMETER_EFFECTS, TRANSMISSION

Effects = Mapping[str, Effect] | Iterable[Effect]  # of a mapping the values count


def by_identifier(effects: Effects) -> dict[str, Effect]:
    """Identifier → effect, in the given order."""
    catalogue: dict[str, Effect] = {}
    for effect in effects.values() if isinstance(effects, Mapping) else effects:
        if not isinstance(effect, Effect):
            raise InvalidValueError(
                f"catalogue: {effect!r} must be a tendon_mj.Effect; those of the package are the"
                " values of tendon_mj.CATALOGUE, such as CATALOGUE['backlash']"
            )
        if effect.identifier in catalogue:
            raise InvalidValueError(f"catalogue: two effects are called {effect.identifier!r}")
        catalogue[effect.identifier] = effect
    return catalogue


CATALOGUE: Final = by_identifier(
    (*TRANSMISSION, *JOINT_EFFECTS, *ACTUATORS, *SENSOR_EFFECTS, *PARAMETER_EFFECTS)
)

# Two identifiers → the experiment that tells the effects apart, as a sentence.
DISCRIMINATING_EXPERIMENTS: Final = {
    frozenset({effect.identifier, other}): sentence
    for effect in CATALOGUE.values()
    for other, sentence in (effect.tell_apart or {}).items()
}


def candidates(
    system: SystemDescription,
    exclude: Collection[str] = (),
    catalogue: Mapping[str, Effect] = CATALOGUE,
) -> list[Candidate]:
    """Every effect of a catalogue bound to a model, but those excluded."""
    for identifier in exclude:
        if identifier not in catalogue:
            raise UnknownNameError("effect", identifier, catalogue)
    kept = [effect for effect in catalogue.values() if effect.identifier not in exclude]
    return [candidate for effect in kept for candidate in effect.bind(system)]


def check_bindings(
    system: SystemDescription, exclude: Collection[str], catalogue: Mapping[str, Effect]
) -> None:
    """Warn of each user-defined effect, not excluded, that binds nowhere on a model.

    An effect of the package without a place on a model is normal.
    """
    unbound = [effect for effect in catalogue.values() if not effect.binding(system)]
    if len(unbound) == len(catalogue):
        reasons = "; ".join(f"{e.identifier!r}: {_why_nowhere(e, system)}" for e in unbound[:3])
        reasons = reasons or "it is empty"
        more = f"; and {len(unbound) - 3} more" if len(unbound) > 3 else ""
        raise InvalidValueError(f"no effect of the catalogue binds on the model: {reasons}{more}")
    for effect in unbound:
        if effect.identifier not in exclude and all(effect is not e for e in CATALOGUE.values()):
            warnings.warn(
                f"effect {effect.identifier!r} binds nowhere on the model and will not be named:"
                f" {_why_nowhere(effect, system)}",
                RuntimeWarning,
                stacklevel=3,  # the caller of `diagnose`
            )


def _why_nowhere(effect: Effect, system: SystemDescription) -> str:
    """Reason why an effect binds nowhere, with the names of parameters that come near."""
    available = {name.rsplit(".", 1)[-1] for name in system.values}
    wanted = written_parameters(effect.binding)
    if absent := sorted(wanted - available):
        return "; ".join(unknown("parameter", name, available) for name in absent)
    near = sorted(n for n in system.values if not wanted or n.rsplit(".", 1)[-1] in wanted)
    shown = ", ".join(map(repr, near[:20])) + (", …" if len(near) > 20 else "")
    return f"its binding finds no place among {shown or 'no parameters'}"
