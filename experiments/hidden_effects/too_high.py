"""Numbers that are too high in the model: the reference has less of the same."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic

import numpy as np

from experiments.hidden_effects.hidden import HiddenEffect, R
from experiments.hidden_effects.references import ReferenceBench, ReferenceJoint


@dataclass(frozen=True, kw_only=True)
class TooHigh(Generic[R]):
    """A number of the model that is above that of the reference.

    Attributes:
        name: identifier.
        parameter: of the model.
        write: (reference, value) → reference with that value.
        true_range: from which the reference's value is drawn [the parameter's unit].
        high: largest excess of the model's value over it [likewise].
        known: parameters that the recordings state, as the data could not tell them from it.
    """

    name: str
    parameter: str
    write: Callable[[R, float], R]
    true_range: tuple[float, float]
    high: float
    known: Mapping[str, float] = dataclasses.field(default_factory=dict)

    def draw(self, reference: R, rng: np.random.Generator) -> tuple[R, HiddenEffect[R]]:
        """The reference with its true value, and the model's excess as an effect on it."""
        true = float(rng.uniform(*self.true_range))
        effect = HiddenEffect(
            name=self.name,
            apply=lambda reference, excess: self.write(reference, true + excess),
            parameters=lambda _, __: {self.parameter: true},
            high=self.high,
        )
        return self.write(reference, true), effect


def _attribute(name: str) -> Callable[[Any, float], Any]:
    return lambda reference, value: dataclasses.replace(reference, **{name: value})


def _transmission(name: str) -> Callable[[ReferenceBench, float], ReferenceBench]:
    def write(bench: ReferenceBench, value: float) -> ReferenceBench:
        given: dict[str, Any] = {name: value}
        return dataclasses.replace(bench, effects=dataclasses.replace(bench.effects, **given))

    return write


def _by_name(*entries: TooHigh[R]) -> dict[str, TooHigh[R]]:
    return {entry.name: entry for entry in entries}


ON_BENCH: Mapping[str, TooHigh[ReferenceBench]] = _by_name(
    TooHigh(
        name="friction",
        parameter="sheath.friction",
        write=_attribute("friction"),
        true_range=(0.08, 0.2),
        high=0.3,
        known={"sheath.extra_bend": 0.0},
    ),
    TooHigh(
        name="axial_stiffness",
        parameter="sheath.axial_stiffness",
        write=_attribute("axial_stiffness"),
        true_range=(0.8e4, 2e4),
        high=5e4,
    ),
    TooHigh(
        name="pretension",
        parameter="sheath.pretension",
        write=_attribute("pretension"),
        true_range=(16.0, 20.0),
        high=20.0,
    ),
    TooHigh(
        name="constant_friction",
        parameter="sheath.constant_friction",
        write=_transmission("constant_friction"),
        true_range=(0.3, 2.0),
        high=10.0,
    ),
    TooHigh(
        name="viscous_friction",
        parameter="sheath.viscous_friction",
        write=_transmission("viscous_friction"),
        true_range=(20.0, 100.0),
        high=1000.0,
    ),
)
ON_JOINT: Mapping[str, TooHigh[ReferenceJoint]] = _by_name(
    TooHigh(
        name="joint_damping",
        parameter="joint.damping",
        write=_attribute("damping"),
        true_range=(0.0003, 0.003),
        high=0.05,
    ),
    TooHigh(
        name="joint_friction",
        parameter="joint.frictionloss",
        write=_attribute("dry_friction"),
        true_range=(0.0005, 0.003),
        high=0.03,
    ),
    TooHigh(
        name="joint_stiffness",
        parameter="joint.stiffness",
        write=_attribute("stiffness"),
        true_range=(0.015, 0.03),
        high=0.1,
    ),
)  # -, N, N, N, N s/m; N m s/rad, N m, N m/rad
