"""The catalogue: every effect that a diagnosis can name unless it is given other ones."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping
from typing import Final

from tendon_mj.errors import InvalidValueError, UnknownNameError, unknown
from tendon_mj.lab.diagnosis.effects.binding import parameters_of
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, SystemDescription
from tendon_mj.lab.diagnosis.effects.mechanism import ACTUATORS, JOINTS, SENSORS
from tendon_mj.lab.diagnosis.effects.transmission import PARAMETERS, TRANSMISSION

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


# Two identifiers → the sentence that says what to record.
DISCRIMINATING_EXPERIMENTS: Final[dict[frozenset[str], str]] = {
    frozenset({"sensor_delay", "sensor_lag"}): (
        "Record one hard step: a delay shifts it and keeps its corners, a lag begins at once and"
        " rounds them. Slow motion only shows the time by which both trail."
    ),
    frozenset({"sensor_bias", "sensor_gain"}): (
        "Record a wider range of tension, down to none at all: an offset stays the same, a wrong"
        " scale grows with the reading."
    ),
    frozenset({"friction", "bend_angle"}): (
        "Record the same loop in another posture of the sheath: only the product μφ shows as long"
        " as the bend φ stays as it is."
    ),
    frozenset({"sheath_friction", "bend_angle"}): (
        "Record the same loop in another posture of the sheath: only the product μφ shows as long"
        " as the bend φ stays as it is."
    ),
    frozenset({"axial_stiffness", "sheath_compliance"}): (
        "Measure the tendon alone on a tensile tester, or clamp the sheath: in series compliances"
        " add up, whatever gives way."
    ),
    frozenset({"friction", "constant_friction"}): (
        "Record the same loop at a third and at three times the pretension: capstan friction grows"
        " in proportion, a constant one stays."
    ),
    frozenset({"static_friction", "velocity_weakening"}): (
        "Record slow motion at several speeds and after rests of several lengths: static friction"
        " acts once at breakaway, a Stribeck curve at every low speed."
    ),
    frozenset({"backlash", "friction"}): (
        "Record small reversals at a low and at a high tension: play loses the same motion at both,"
        " friction more at the higher one."
    ),
    frozenset({"joint_stiffness", "gravity_load"}): (
        "Record the same motion with the rig turned by 90°: a spring turns with it, weight does"
        " not."
    ),
    frozenset({"joint_spring", "gravity_load"}): (
        "Record the same motion with the rig turned by 90°: a spring turns with it, weight does"
        " not."
    ),
    frozenset({"command_offset", "gravity_load"}): (
        "Record the same motion with the rig turned by 180°: weight turns with it, the force of a"
        " motor does not."
    ),
    frozenset({"command_delay", "sensor_delay"}): (
        "Measure a second quantity: a late sensor trails alone, behind a late drive all do."
    ),
    frozenset({"kv", "joint_damping"}): (
        "Measure the servo's force: what a joint damps it has to supply, its own rate gain not."
    ),
    frozenset({"springref", "pretension"}): (
        "Let the tendon go slack: the joint then rests where its spring does."
    ),
    frozenset({"gear", "mass"}): (
        "Hold the motor against a load cell: its force at rest tells the gear without the mass."
    ),
    frozenset({"sensor_bias", "pretension"}): (
        "Read the sensor with the tendon slack: an offset remains, a pretension is gone."
    ),
    frozenset({"gear_efficiency", "sheath_friction"}): (
        "Measure the tension at the drive by a load cell: the gear's friction is not in it, the"
        " sheath's is."
    ),
    frozenset({"gear_efficiency", "friction"}): (
        "Measure the tension at the drive by a load cell: the gear's friction is not in it, the"
        " sheath's is."
    ),
    frozenset({"sensor_drift", "friction_drift"}): (
        "Record the sensor at rest for as long: a drifting sensor drifts there too."
    ),
}
