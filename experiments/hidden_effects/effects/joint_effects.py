"""Effects that can be hidden in the joint, each with its largest strength."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np

from experiments.hidden_effects.effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.references.joint import ReferenceJoint
from tendon_mj.models import Joint


def _parameter(
    name: str, attribute: str, parameter: str, start: float, high: float, sign: float = 1.0
) -> Callable[[np.random.Generator], HiddenEffect[ReferenceJoint]]:
    """Effect that raises an attribute of the reference from ``start`` by its strength."""

    def draw(_: np.random.Generator) -> HiddenEffect[ReferenceJoint]:
        return HiddenEffect(
            name=name,
            apply=lambda joint, s: dataclasses.replace(joint, **{attribute: start + s}),
            parameters=lambda _, s: {parameter: start + sign * s},
            high=high,
        )

    return draw


JOINT_EFFECTS: Mapping[str, Callable[[np.random.Generator], HiddenEffect[ReferenceJoint]]] = {
    "joint_damping": _parameter("joint_damping", "damping", "joint.damping", Joint.damping, 0.02),
    "joint_friction": _parameter("joint_friction", "dry_friction", "joint.frictionloss", 0.0, 0.02),
    "joint_stiffness": _parameter(
        "joint_stiffness", "stiffness", "joint.stiffness", Joint.stiffness, 0.06
    ),
    "gravity_load": _parameter("gravity_load", "gravity", "gravity.z", 0.0, 9.81, sign=-1.0),
}  # N m s/rad, N m, N m/rad, m/s²
