"""The catalogue: every effect that a diagnosis can name. A new one is a file and an entry here."""

from __future__ import annotations

from typing import Final

from tendon_mj.diagnosis.effect import Candidate, Effect, Rig
from tendon_mj.diagnosis.effects import (
    axial_stiffness,
    backlash,
    bend_angle,
    constant_friction,
    creep,
    direction_asymmetry,
    friction,
    friction_drift,
    gravity_load,
    joint_damping,
    joint_friction,
    joint_stiffness,
    moment_arm,
    position_dependent_friction,
    pretension,
    sensor_bias,
    sensor_delay,
    sensor_drift,
    sensor_gain,
    sensor_lag,
    sheath_compliance,
    sheath_friction,
    static_friction,
    stiffening,
    tendon_inertia,
    velocity_weakening,
    viscous_friction,
)
from tendon_mj.errors import UnknownNameError

CATALOGUE: Final[dict[str, Effect]] = {
    module.EFFECT.identifier: module.EFFECT
    for module in (
        sheath_friction,
        static_friction,
        velocity_weakening,
        viscous_friction,
        constant_friction,
        direction_asymmetry,
        position_dependent_friction,
        friction_drift,
        backlash,
        stiffening,
        creep,
        sheath_compliance,
        tendon_inertia,
        joint_damping,
        joint_friction,
        joint_stiffness,
        gravity_load,
        sensor_bias,
        sensor_gain,
        sensor_delay,
        sensor_lag,
        sensor_drift,
        friction,
        axial_stiffness,
        pretension,
        bend_angle,
        moment_arm,
    )
}


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
