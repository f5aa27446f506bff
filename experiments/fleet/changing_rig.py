"""Changes of a rig in a hidden fleet, and their sizes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from experiments.hidden_effects.excitation import Sensor
from experiments.hidden_effects.references import ReferenceBench

Course = Literal["step", "ramp"]
OUTPUT = "output_tension_N"
_BEFORE, _AFTER = 3, 5  # recordings at least, of a rig that changes


@dataclass(frozen=True)
class Kind:
    """A kind of change.

    Attributes:
        parameter: of the model, that changes.
        sizes: smallest and largest size.
        apply: (rig, size) → rig.
        ramp: whether it may also grow from day to day.
    """

    parameter: str
    sizes: tuple[float, float]
    apply: Callable[[ReferenceBench, float], ReferenceBench]
    ramp: bool = False


def _factor(attribute: str) -> Callable[[ReferenceBench, float], ReferenceBench]:
    """Change of an attribute by a share of itself."""

    def apply(rig: ReferenceBench, size: float) -> ReferenceBench:
        return dataclasses.replace(rig, **{attribute: getattr(rig, attribute) * (1.0 + size)})

    return apply


def _effect(attribute: str) -> Callable[[ReferenceBench, float], ReferenceBench]:
    """An effect of the transmission that comes up."""

    def apply(rig: ReferenceBench, size: float) -> ReferenceBench:
        return dataclasses.replace(
            rig, effects=dataclasses.replace(rig.effects, **{attribute: size})
        )

    return apply


def _sensor(attribute: str) -> Callable[[ReferenceBench, float], ReferenceBench]:
    """A change of the output's sensor."""

    def apply(rig: ReferenceBench, size: float) -> ReferenceBench:
        own = dataclasses.replace(rig.sensors.get(OUTPUT, Sensor()), **{attribute: size})
        return dataclasses.replace(rig, sensors={**rig.sensors, OUTPUT: own})

    return apply


# Sizes are some five to fifteen times the differences from day to day (`make_fleet`).
KINDS: dict[str, Kind] = {
    "friction": Kind("sheath.friction", (0.15, 0.5), _factor("friction"), ramp=True),
    "pretension": Kind("sheath.pretension", (-0.2, -0.08), _factor("pretension"), ramp=True),
    "axial_stiffness": Kind(
        "sheath.axial_stiffness", (-0.25, -0.1), _factor("axial_stiffness"), ramp=True
    ),
    "backlash": Kind("sheath.backlash", (0.06e-3, 0.2e-3), _effect("backlash"), ramp=True),  # m
    "viscous_friction": Kind("sheath.viscous_friction", (60.0, 200.0), _effect("viscous_friction")),
    "constant_friction": Kind("sheath.constant_friction", (0.5, 2.0), _effect("constant_friction")),
    "sheath_compliance": Kind(
        "sheath.sheath_compliance", (0.6e-5, 2e-5), _effect("sheath_compliance")
    ),  # m/N
    "sensor_bias": Kind("output_tension.offset", (0.3, 1.0), _sensor("bias")),  # N
    "sensor_gain": Kind("output_tension.scale", (0.03, 0.1), _sensor("gain")),
    "sensor_delay": Kind("output_tension.delay", (0.004, 0.015), _sensor("delay")),  # s
}


@dataclass(frozen=True)
class RigChange:
    """Change of one rig: its kind, its size, its course, and the recording it begins at."""

    kind: str
    size: float
    course: Course
    first: int

    def applied(self, rig: ReferenceBench, recording: int, recordings: int) -> ReferenceBench:
        """The rig as it is in a recording."""
        if recording < self.first:
            return rig
        share = 1.0
        if self.course == "ramp":
            share = (recording - self.first + 1) / (recordings - self.first)
        return KINDS[self.kind].apply(rig, share * self.size)


def draw_change(kind: str, recordings: int, rng: np.random.Generator) -> RigChange:
    """Draw the change of a rig with enough recordings before it and after."""
    ramp = KINDS[kind].ramp and bool(rng.integers(2))
    first = int(rng.integers(_BEFORE, recordings - _AFTER + 1))
    return RigChange(
        kind, float(rng.uniform(*KINDS[kind].sizes)), "ramp" if ramp else "step", first
    )
