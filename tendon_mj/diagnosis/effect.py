"""What an entry of the catalogue is, and how it becomes numbers that a fit can change.

An *effect* is a small extension of the model that does nothing at its inert value. Bound to the
elements of one model it is a *candidate*: terms to be fitted, each of which writes parameters of
the simulator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Kind = Literal["missing", "parameter"]


@dataclass(frozen=True)
class Rig:
    """What the catalogue may know of a model and its recordings.

    Attributes:
        values: parameter → value that the model has now [its SI unit].
        known: parameters that were measured on the rig and are never fitted.
        uncertain: parameters that are calibrated in any case.
        spans: sensor → largest less smallest measured value [the sensor's unit].
        inputs: driven actuators.
        free_joints: joints that no driven actuator moves.
    """

    values: Mapping[str, float]
    known: frozenset[str]
    uncertain: frozenset[str]
    spans: Mapping[str, float]
    inputs: tuple[str, ...]
    free_joints: tuple[str, ...]

    def elements(self, parameter: str) -> list[str]:
        """Elements that have a parameter of that name."""
        ending = "." + parameter
        return sorted(name.removesuffix(ending) for name in self.values if name.endswith(ending))


@dataclass(frozen=True)
class Term:
    """One number to be fitted, and the parameters that it writes.

    Attributes:
        targets: parameters of the simulator, all of which get the value.
        unit: of the number.
        inert: the value at which nothing changes.
        low, high: range that is physically sensible.
        probe: the change from inert by which a first look judges its influence; the fit's scale.
        relative_to: where given, a target on element e is (1 + number) × the parameter
            ``e.relative_to``.
        starts: values to begin from, for a number that shapes an effect and does nothing alone.
    """

    targets: tuple[str, ...]
    unit: str
    inert: float
    low: float
    high: float
    probe: float
    relative_to: str = ""
    starts: tuple[float, ...] = ()

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """Parameter → value for the number, beside what the other parameters are."""
        if not self.relative_to:
            return dict.fromkeys(self.targets, number)
        written = {}
        for target in self.targets:
            element = target.rsplit(".", 1)[0]
            written[target] = (1.0 + number) * values[f"{element}.{self.relative_to}"]
        return written

    def scaled(self, number: float) -> float:
        """The number as a fit sees it: in probes from inert, or the logarithm of a shape."""
        return math.log(number) if self.starts else (number - self.inert) / self.probe

    def natural(self, scaled: float) -> float:
        """The number that `scaled` made."""
        return math.exp(scaled) if self.starts else self.inert + scaled * self.probe


@dataclass(frozen=True)
class Candidate:
    """An effect on certain elements of one model.

    Attributes:
        identifier: of the effect.
        kind: "missing", an effect the model lacks, or "parameter", a number that may be wrong.
        where: the elements it is on, for the reader.
        terms: the first one is its strength, the others shape it.
        rugged: see `Effect`.
    """

    identifier: str
    kind: Kind
    where: str
    terms: tuple[Term, ...]
    rugged: bool = False

    @property
    def label(self) -> str:
        """Identifier and place."""
        return f"{self.identifier} ({self.where})"

    @property
    def targets(self) -> frozenset[str]:
        """Parameters that its terms write."""
        return frozenset(target for term in self.terms for target in term.targets)


@dataclass(frozen=True)
class Effect:
    """An entry of the catalogue.

    Attributes:
        identifier: as results and keys call it.
        name: plain words.
        equation: what it adds, in the symbols of docs/theory.md.
        looks_like: its trace in data.
        source: where it is described.
        candidates: binds it to the elements of a model; empty where it has no place there.
        kind: see `Candidate`.
        though_known: whether it may also write what was "measured on the rig".
        rugged: whether the misfit has many small valleys by its terms, as where it makes a sheath
            stick and slip; where slopes do not hold their whole ranges are searched, see
            `tendon_mj.diagnosis.around`.
    """

    identifier: str
    name: str
    equation: str
    looks_like: str
    source: str
    candidates: Callable[[Rig], list[tuple[str, tuple[Term, ...]]]] = field(repr=False)
    kind: Kind = "missing"
    though_known: bool = False
    rugged: bool = False

    def bind(self, rig: Rig) -> list[Candidate]:
        """Its candidates on a model, without those that fit what is known or fitted anyway."""
        taken = rig.uncertain if self.though_known else rig.known | rig.uncertain
        return [
            Candidate(self.identifier, self.kind, where, terms, self.rugged)
            for where, terms in self.candidates(rig)
            if not any(target in taken for term in terms for target in term.targets)
        ]
