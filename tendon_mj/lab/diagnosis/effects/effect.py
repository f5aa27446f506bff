"""Effects, terms to be fitted, and candidates.

An *effect* is a small extension of a model that does nothing at its inert value. Bound to elements
of one model it is a *candidate*: terms to be fitted, each of which writes simulator parameters.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, get_args

from tendon_mj.errors import UnknownNameError
from tendon_mj.lab.parameter_names import recording_of, value_in
from tendon_mj.lab.replay import Readout

EffectKind = Literal["missing", "parameter"]
_LARGEST_LOGARITHM = math.log(sys.float_info.max)


@dataclass(frozen=True)
class SystemDescription:
    """Elements and parameters of a model and its recordings that effects can bind to."""

    values: Mapping[str, float]  # parameter → value in the model [its SI unit]
    known: frozenset[str]  # parameters that were measured on the rig and are never fitted
    uncertain: frozenset[str]  # parameters that are calibrated in any case
    spans: Mapping[str, float]  # sensor → largest minus smallest measured value [the sensor's unit]
    inputs: tuple[str, ...]  # driven actuators and joints
    free_joints: tuple[str, ...]  # joints that no driven actuator moves
    motors: tuple[str, ...] = ()  # inputs whose force depends on their control alone
    slides: frozenset[str] = frozenset()  # joints that slide
    # parameter of an actuator or a body → the joints that it is on or that move it
    joints: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    # position → its value in the model's reference pose, where not 0
    reference: Mapping[str, float] = field(default_factory=dict)
    columns: tuple[tuple[str, ...], ...] = ()  # the inputs of each column that drives several

    def elements(self, parameter: str) -> list[str]:
        """Elements that have a parameter of that name."""
        ending = "." + parameter
        return sorted(name.removesuffix(ending) for name in self.values if name.endswith(ending))

    def on_free_joints(self, elements: Iterable[str], parameter: str) -> list[str]:
        """Those of the elements whose parameter acts on a free joint."""
        free = {*self.free_joints}
        return [e for e in elements if free & {*self.joints.get(f"{e}.{parameter}", ())}]


class Constant(NamedTuple):
    """A parameter that is written with a term at a value that no fit changes."""

    name: str  # of the parameter
    # value and ends of its interval
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Term:
    """A number to be fitted, which all its targets get."""

    targets: tuple[str, ...]  # simulator parameters that it writes
    unit: str  # of the number
    inert: float  # value at which nothing changes
    # physically sensible range
    low: float
    high: float
    probe: float  # change from inert by which screening judges its influence; the fit's scale
    # values to begin from, for a number that shapes an effect and does nothing alone; its logarithm
    # is fitted
    starts: tuple[float, ...] = ()
    spread: float = 0.0  # standard deviation about inert that is expected of it; 0 if none is
    # parameter of the targets' elements that their values depend on; or empty
    depends_on: str = field(default="", kw_only=True)
    # parameters that are written with it at fixed values: of an event, its times
    constants: tuple[Constant, ...] = field(default=(), kw_only=True)
    # strengths that screening tries besides inert + probe, where a trace does not grow with it
    larger: tuple[float, ...] = field(default=(), kw_only=True)

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """Parameter → value for the number, where the other parameters have ``values``."""
        return {c.name: c.value for c in self.constants} | dict.fromkeys(self.targets, number)

    def scaled(self, number: float) -> float:
        """The number as a fit sees it: in probes from inert, or the logarithm of a shape."""
        return math.log(number) if self.starts else (number - self.inert) / self.probe

    def natural(self, scaled: float) -> float:
        """Inverse of `scaled`."""
        if self.starts:  # an end of an interval may be beyond the largest float
            return math.exp(min(scaled, _LARGEST_LOGARITHM))
        return self.inert + scaled * self.probe


@dataclass(frozen=True)
class FactorTerm(Term):
    """A factor of the model's value of each target, ``own``."""

    own: tuple[float, ...] = field(kw_only=True)

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """See `Term.write`."""
        return {t: number * value for t, value in zip(self.targets, self.own, strict=True)}


@dataclass(frozen=True)
class ShiftTerm(Term):
    """The first target's value; the others differ from it by as much as in the model, ``more``."""

    more: tuple[float, ...] = field(kw_only=True)

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """See `Term.write`."""
        return {t: number + more for t, more in zip(self.targets, self.more, strict=True)}


@dataclass(frozen=True)
class ExcessTerm(Term):
    """A target is (1 + number) × the parameter that it depends on."""

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """See `Term.write`."""
        others = [values[f"{element(t)}.{self.depends_on}"] for t in self.targets]
        return {t: (1.0 + number) * v for t, v in zip(self.targets, others, strict=True)}


@dataclass(frozen=True)
class QuotientTerm(Term):
    """A target is ``origin`` + number × its product / the parameter that it depends on."""

    products: tuple[float, ...] = field(kw_only=True)
    origin: float = field(default=0.0, kw_only=True)

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """See `Term.write`."""
        rows = [
            (t, product, values[f"{element(t)}.{self.depends_on}"])
            for t, product in zip(self.targets, self.products, strict=True)
        ]
        return {t: self.origin + number * product / other for t, product, other in rows}


def element(parameter: str) -> str:
    """Element of a parameter."""
    return parameter.rsplit(".", 1)[0]


@dataclass(frozen=True)
class Candidate:
    """An effect on certain elements of one model."""

    effect: Effect
    where: str  # the elements it is on, for the reader
    terms: tuple[Term, ...]  # the first one is its strength, the others shape it

    @property
    def identifier(self) -> str:
        """Identifier of the effect."""
        return self.effect.identifier

    @property
    def label(self) -> str:
        """Identifier and place."""
        return f"{self.identifier} ({self.where})"

    @property
    def targets(self) -> frozenset[str]:
        """Parameters that its terms write."""
        return frozenset(target for term in self.terms for target in term.targets)

    @property
    def on_sensor(self) -> bool:
        """Whether it changes no motion, only the readings of it."""
        return all(t.rpartition(".")[2] in Readout._fields for t in self.targets)

    @property
    def recording(self) -> str:
        """The one recording that it is in; empty if it is in all."""
        return recording_of(self.terms[0].targets[0])

    def acts_on(self, values: Mapping[str, float]) -> bool:
        """Return whether the model has the parameter that it changes, with these values."""
        changed = self.effect.changes
        return not changed or any(values[f"{element(t)}.{changed}"] != 0.0 for t in self.targets)

    def in_model(self, before: Mapping[str, float]) -> bool:
        """Return whether a model has some of it, with parameter → value before the fit."""
        absent = self.effect.absent
        return any(value_in(before, target) != absent for target in self.terms[0].targets)

    def kind_found(self, before: Mapping[str, float], after: Mapping[str, float]) -> EffectKind:
        """Kind of a finding: a model that has more than the data want lacks nothing.

        ``before`` and ``after`` are parameter → value of the model, and as fitted.
        """
        absent = self.effect.absent
        too_much = all(
            abs(after[target] - absent) < abs(value_in(before, target) - absent)
            for target in self.terms[0].targets
        )
        return "parameter" if too_much else self.effect.kind


Bound = list[tuple[str, tuple[Term, ...]]]  # the elements of each candidate, and its terms
Binding = Callable[[SystemDescription], Bound]


@dataclass(frozen=True)
class Effect:
    """An entry of the catalogue.

    Attributes:
        identifier: as results and keys call it.
        name: plain words.
        equation: its contribution, in the symbols of docs/theory.md.
        signature: its trace in data.
        source: where it is described.
        binding: finds the elements of a model that it can be on, and its terms there; none if
            it has no place. See `tendon_mj.lab.diagnosis.effects.binding`.
        next_experiment: motion or measurement that brings the effect out, as the end of a sentence
            that begins with "record"; may be empty.
        kind: "missing", an effect the model lacks, or "parameter", a number that may be wrong.
        overrides_known: whether it may also write parameters that were measured on the rig.
        absent: value of its first parameter at which a model has none of the effect.
        non_smooth: whether the misfit has many local minima in its terms, as where it makes a
            sheath stick and slip. Beside it no block is left out, as the linearisation does not
            hold.
        changes: parameter of its elements that it changes; it is not a candidate if that is 0 on
            all of them. May be empty.
        event: whether it happens once, in one recording: its parameter is 0 before the time
            ``<parameter>_time`` and for the ``<parameter>_duration`` from there on rises to its
            value. Both times are searched for in the residual.
        in_motion: whether it changes nothing at rest, or the same in each row of settled points,
            as creep does after equal times.
        look_at: part of a rig in which it has its cause; may be empty.
        tell_apart: identifier of another effect → experiment that tells the two apart.

    Raises:
        UnknownNameError: the kind is none of the two.
    """

    identifier: str
    name: str
    equation: str
    signature: str
    source: str
    binding: Binding = field(repr=False)
    next_experiment: str = ""
    kind: EffectKind = "missing"
    overrides_known: bool = False
    non_smooth: bool = False
    changes: str = ""
    absent: float = 0.0
    event: bool = False
    in_motion: bool = False
    look_at: str = ""
    tell_apart: Mapping[str, str] | None = field(default=None, repr=False, hash=False)

    def __post_init__(self) -> None:
        if self.kind not in get_args(EffectKind):
            where = f"effect {self.identifier!r}"
            raise UnknownNameError("kind of an effect", self.kind, get_args(EffectKind), where)

    def __repr__(self) -> str:
        return f"Effect({self.identifier!r}: {self.name})"

    def bind(self, system: SystemDescription) -> list[Candidate]:
        """Its candidates on a model, but those of parameters that are known or fitted anyway.

        Of several on the same elements, such as axes of gravity, each is at its parameter.
        """
        taken = system.uncertain if self.overrides_known else system.known | system.uncertain
        bound = self.binding(system)
        places = [where for where, _ in bound]
        return [
            Candidate(self, where if places.count(where) == 1 else terms[0].targets[0], terms)
            for where, terms in bound
            if not any(target in taken for term in terms for target in term.targets)
        ]
