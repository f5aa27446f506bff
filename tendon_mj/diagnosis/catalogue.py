"""The catalogue: every effect that a diagnosis can name. A new one is a file and an entry here."""

from __future__ import annotations

from importlib import import_module
from typing import Final

from tendon_mj.diagnosis.effect import Candidate, Effect, Rig
from tendon_mj.errors import UnknownNameError

# modules of `tendon_mj.diagnosis.effects`
_ENTRIES: Final = (
    "sheath_friction",
    "static_friction",
    "velocity_weakening",
    "viscous_friction",
    "constant_friction",
    "direction_asymmetry",
    "position_dependent_friction",
    "friction_drift",
    "backlash",
    "stiffening",
    "creep",
    "sheath_compliance",
    "tendon_inertia",
    "joint_damping",
    "joint_friction",
    "joint_stiffness",
    "gravity_load",
    "sensor_bias",
    "sensor_gain",
    "sensor_delay",
    "sensor_lag",
    "sensor_drift",
    "friction",
    "axial_stiffness",
    "pretension",
    "bend_angle",
    "moment_arm",
)


def _load(module: str) -> Effect:
    effect = import_module(f"tendon_mj.diagnosis.effects.{module}").EFFECT
    assert isinstance(effect, Effect)
    return effect


CATALOGUE: Final[dict[str, Effect]] = {effect.identifier: effect for effect in map(_load, _ENTRIES)}


def candidates(rig: Rig, exclude: frozenset[str] = frozenset()) -> list[Candidate]:
    """Every effect of the catalogue bound to a model, but those excluded.

    Raises:
        UnknownNameError: an excluded identifier that is not in the catalogue.
    """
    for identifier in exclude:
        if identifier not in CATALOGUE:
            raise UnknownNameError("effect", identifier, CATALOGUE)
    return [
        candidate
        for identifier, effect in CATALOGUE.items()
        if identifier not in exclude
        for candidate in effect.bind(rig)
    ]
