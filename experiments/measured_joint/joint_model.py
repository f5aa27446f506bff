"""Numbers of the joint's MuJoCo model that a direct fit finds, for three laws of friction.

All have the numbers that `joint.toml` calls uncertain, within its ranges, and a tendon that creeps,
as the diagnosis finds. Friction is

* capstan friction of the sheath, μ,
* constant friction of the sheath in its place, linear in the bend,
* MuJoCo's `frictionloss` of the hinge alone, linear in the bend.

MuJoCo's `frictionloss` of a tendon is no candidate: the length of a tendon in its sheath does not
change, so that it does nothing here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from experiments.measured_joint.recording import bend
from tendon_mj.lab.recordings import Recording

_SHEATHS = ("sheath_1", "sheath_2")


@dataclass(frozen=True)
class Number:
    """A number to fit.

    Attributes:
        name: in tables.
        parameters: of the model, that it is added to.
        low, high: range [the parameter's unit, per rad with ``per_bend``].
        logarithmic: whether the range is searched by its logarithm.
        per_bend: whether it counts times the bend of a recording.
    """

    name: str
    parameters: tuple[str, ...]
    low: float
    high: float
    logarithmic: bool = False
    per_bend: bool = False

    def at(self, share: float) -> float:
        """Value at a share of the range, 0 … 1."""
        if self.logarithmic:
            return self.low * math.exp(share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)


def _both(parameter: str) -> tuple[str, ...]:
    return tuple(f"{sheath}.{parameter}" for sheath in _SHEATHS)


_RIG = (
    Number("spool's radius", ("command.command_scale",), 0.5, 4.0, logarithmic=True),
    Number("EA", _both("axial_stiffness"), 100.0, 4000.0, logarithmic=True),
    Number("zero of load cell 1", ("input_tension_1.offset",), -2.0, 2.0),
    Number("zero of load cell 2", ("input_tension_2.offset",), -2.0, 2.0),
    Number("compliance at the motor", _both("sheath_compliance"), 0.0, 2e-3),
    Number("hinge's stiffness", ("joint.stiffness",), 0.0, 0.2),
    Number("hinge's dry friction", ("joint.frictionloss",), 0.0, 0.1),
    Number("hinge's damping", ("joint.damping",), 0.0, 0.05),
)
_CREEP = (
    Number("creep", _both("creep"), 0.0, 2.0),
    Number("its time", _both("creep_time"), 0.1, 10.0, logarithmic=True),
)
_HINGE_PER_BEND = Number(
    "hinge's dry friction per rad", ("joint.frictionloss",), 0.0, 0.05, per_bend=True
)
_CONSTANT = Number("F_c", _both("constant_friction"), 0.0, 10.0)
_CONSTANT_PER_BEND = Number("F_c per rad", _both("constant_friction"), 0.0, 5.0, per_bend=True)
_CAPSTAN = Number("μ", _both("friction"), 0.0, 1.0)

CAPSTAN = (*_RIG, *_CREEP, _CAPSTAN)
CONSTANT = (*_RIG, *_CREEP, _CONSTANT, _CONSTANT_PER_BEND)
FRICTIONLOSS = (*_RIG, *_CREEP, _HINGE_PER_BEND)


def narrowed(numbers: Sequence[Number], recording: Recording) -> tuple[Number, ...]:
    """Numbers of one parameter each within the range that a recording states for it."""
    return tuple(
        replace(number, low=max(number.low, told.low), high=min(number.high, told.high))
        if len(number.parameters) == 1 and (told := recording.uncertain.get(number.parameters[0]))
        else number
        for number in numbers
    )


def values_in(
    numbers: Sequence[Number], shares: Sequence[float], recordings: Sequence[Recording]
) -> dict[str, float]:
    """Parameter of each recording, ``<parameter> @ <recording>`` → value."""
    values: dict[str, float] = {}
    for recording in recordings:
        for number, share in zip(numbers, shares, strict=True):
            amount = number.at(share) * (bend(recording) if number.per_bend else 1.0)
            for parameter in number.parameters:
                key = f"{parameter} @ {recording.name}"
                values[key] = values.get(key, 0.0) + amount
    return values


def named(numbers: Sequence[Number], shares: Sequence[float]) -> Mapping[str, float]:
    """Name of each number → its value."""
    return {n.name: n.at(s) for n, s in zip(numbers, shares, strict=True)}
