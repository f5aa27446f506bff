"""Entry of the catalogue, and its path to numbers that a fit can change.

An *effect* is a small extension of the model that does nothing at its inert value. Bound to the
elements of one model it is a *candidate*: terms to be fitted, each of which writes parameters of
the simulator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.replay import Readout, recording_of, value_in

Kind = Literal["missing", "parameter"]
_LARGEST_LOGARITHM = 700.0

# Parameters that change nothing at rest, or the same in each row, as creep does after equal times.
_IN_MOTION = frozenset(
    {
        "viscous_friction",
        "stribeck_friction",
        "creep",
        "axial_damping",
        "tendon_mass",
        "damping",
        "armature",
        "kv",
        "velocity_gain",
        "command_delay",
        "delay",
        "lag",
    }
)


@dataclass(frozen=True)
class SystemDescription:
    """Elements and parameters of a model and its recordings that effects can bind to.

    Attributes:
        values: parameter → value that the model has now [its SI unit].
        known: parameters that were measured on the rig and are never fitted.
        uncertain: parameters that are calibrated in any case.
        spans: sensor → largest less smallest measured value [the sensor's unit].
        inputs: driven actuators and joints.
        columns: the inputs of each column that drives several.
        free_joints: joints that no driven actuator moves.
        motors: inputs whose force depends on nothing but their control.
        slides: joints that slide.
        joints: parameter of an actuator or a body → the joints that it is on or that move it.
        reference: position → what it is in the model's reference pose, where not 0.
    """

    values: Mapping[str, float]
    known: frozenset[str]
    uncertain: frozenset[str]
    spans: Mapping[str, float]
    inputs: tuple[str, ...]
    free_joints: tuple[str, ...]
    motors: tuple[str, ...] = ()
    slides: frozenset[str] = frozenset()
    joints: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    reference: Mapping[str, float] = field(default_factory=dict)
    columns: tuple[tuple[str, ...], ...] = ()

    def moves_freely(self, name: str) -> bool:
        """Whether a parameter's joints are free ones, one of them at least."""
        return bool({*self.joints.get(name, ())} & {*self.free_joints})

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
        probe: the change from inert by which screening judges its influence; the fit's scale.
        relative_to: where given, a target on element e is (1 + number) × the parameter
            ``e.relative_to``.
        own: where given, the model's value of each target, which is multiplied by the number.
        divided_by: where given, ``own`` are products with the parameter ``e.divided_by``, and a
            target on element e is ``origin`` + number × own / ``e.divided_by``.
        origin: see there.
        beyond: where given, what each target is more than the number; the first is the number.
        starts: values to begin from, for a number that shapes an effect and does nothing alone.
        spread: standard deviation about inert that is expected of it; 0 where nothing is.
        beside: parameters that are written with it at a value that no fit changes, each with its
            value and the ends of its interval, as the time of an event.
    """

    targets: tuple[str, ...]
    unit: str
    inert: float
    low: float
    high: float
    probe: float
    relative_to: str = ""
    starts: tuple[float, ...] = ()
    spread: float = 0.0
    own: tuple[float, ...] = ()
    beyond: tuple[float, ...] = ()
    divided_by: str = ""
    origin: float = 0.0
    beside: tuple[tuple[str, float, float, float], ...] = ()

    @property
    def depends_on(self) -> str:
        """Parameter of the targets' elements by which their values go; empty where by none."""
        return self.relative_to or self.divided_by

    def write(self, number: float, values: Mapping[str, float]) -> dict[str, float]:
        """Parameter → value for the number, beside what the other parameters are."""
        if self.own and not self.divided_by:
            return {t: number * value for t, value in zip(self.targets, self.own, strict=True)}
        if self.beyond:
            return {t: number + more for t, more in zip(self.targets, self.beyond, strict=True)}
        if not self.depends_on:
            given = {name: value for name, value, _, _ in self.beside}
            return given | dict.fromkeys(self.targets, number)
        others = [values[f"{t.rsplit('.', 1)[0]}.{self.depends_on}"] for t in self.targets]
        if self.relative_to:
            return {t: (1.0 + number) * v for t, v in zip(self.targets, others, strict=True)}
        rows = zip(self.targets, self.own, others, strict=True)
        return {t: self.origin + number * own / other for t, own, other in rows}

    def scaled(self, number: float) -> float:
        """The number as a fit sees it: in probes from inert, or the logarithm of a shape."""
        return math.log(number) if self.starts else (number - self.inert) / self.probe

    def natural(self, scaled: float) -> float:
        """The number that `scaled` made."""
        if self.starts:  # an end of an interval may be beyond what a number can be
            return math.exp(min(scaled, _LARGEST_LOGARITHM))
        return self.inert + scaled * self.probe


@dataclass(frozen=True)
class Candidate:
    """An effect on certain elements of one model.

    Attributes:
        identifier: of the effect.
        kind: "missing", an effect the model lacks, or "parameter", a number that may be wrong.
        where: the elements it is on, for the reader.
        terms: the first one is its strength, the others shape it.
        non_smooth, changes, absent, event: see `Effect`.
    """

    identifier: str
    kind: Kind
    where: str
    terms: tuple[Term, ...]
    non_smooth: bool = False
    changes: str = ""
    absent: float = 0.0
    event: bool = False

    @property
    def label(self) -> str:
        """Identifier and place."""
        return f"{self.identifier} ({self.where})"

    @property
    def on_sensor(self) -> bool:
        """Whether it changes no motion, only what a sensor makes of it."""
        return all(t.rpartition(".")[2] in Readout._fields for t in self.targets)

    @property
    def in_motion(self) -> bool:
        """Whether readings at rest say nothing of it."""
        return all(t.rpartition(".")[2] in _IN_MOTION for t in self.terms[0].targets)

    @property
    def recording(self) -> str:
        """The one recording that it is in; empty where it is in all."""
        return recording_of(self.terms[0].targets[0])

    def acts_on(self, values: Mapping[str, float]) -> bool:
        """Whether what it changes is there, with these values of the parameters."""
        elements = {target.rsplit(".", 1)[0] for target in self.targets}
        return not self.changes or any(values[f"{e}.{self.changes}"] != 0.0 for e in elements)

    def in_model(self, before: Mapping[str, float]) -> bool:
        """Whether a model has some of it, with parameter → value before the fit."""
        return any(value_in(before, target) != self.absent for target in self.terms[0].targets)

    def found(self, before: Mapping[str, float], after: Mapping[str, float]) -> Kind:
        """Kind of what was found: a model that has more than the data want lacks nothing.

        Args:
            before, after: parameter → value of the model, and as fitted.
        """
        too_much = all(
            abs(after[target] - self.absent) < abs(value_in(before, target) - self.absent)
            for target in self.terms[0].targets
        )
        return "parameter" if too_much else self.kind

    @property
    def targets(self) -> frozenset[str]:
        """Parameters that its terms write."""
        return frozenset(target for term in self.terms for target in term.targets)


Bound = list[tuple[str, tuple[Term, ...]]]  # the elements of each candidate, and its terms
Binding = Callable[[SystemDescription], Bound]


@dataclass(frozen=True)
class Effect:
    """An entry of the catalogue.

    Attributes:
        identifier: as results and keys call it.
        name: plain words.
        equation: what it adds, in the symbols of docs/theory.md.
        signature: its trace in data.
        source: where it is described.
        binding: finds the elements of a model that it can be on, and its terms there; none where
            it has no place. See `tendon_mj.lab.diagnosis.effects.binding`.
        next_experiment: what brings the effect out, as the end of a sentence that begins with
            "record"; may be empty.
        kind: see `Candidate`.
        overrides_known: whether it may also write what was measured on the rig.
        absent: value of its first parameter at which a model has none of the effect.
        non_smooth: whether the misfit has many local minima in its terms, as where it makes a
            sheath stick and slip. Where the linearisation does not hold, their whole ranges are
            searched.
        changes: parameter of its elements that it changes; it is no candidate where that is 0 on
            all of them. May be empty.
        event: whether it happens once, in one recording: its parameter is 0 before the time
            ``<parameter>_time`` and for the ``<parameter>_duration`` from there on rises to its
            value. Both times are searched for in the residual.

    Raises:
        InvalidValueError: the identifier is empty.
        UnknownNameError: the kind is none of the two.
    """

    identifier: str
    name: str
    equation: str
    signature: str
    source: str
    binding: Binding = field(repr=False)
    next_experiment: str = ""
    kind: Kind = "missing"
    overrides_known: bool = False
    non_smooth: bool = False
    changes: str = ""
    absent: float = 0.0
    event: bool = False

    def __post_init__(self) -> None:
        if not self.identifier.strip():
            raise InvalidValueError(f"effect {self.name!r}: the identifier must not be empty")
        if self.kind not in get_args(Kind):
            where = f"effect {self.identifier!r}"
            raise UnknownNameError("kind of an effect", self.kind, get_args(Kind), where)

    def bind(self, system: SystemDescription) -> list[Candidate]:
        """Its candidates on a model, without those that fit what is known or fitted anyway."""
        taken = system.uncertain if self.overrides_known else system.known | system.uncertain
        return [
            Candidate(
                identifier=self.identifier,
                kind=self.kind,
                where=where,
                terms=terms,
                non_smooth=self.non_smooth,
                changes=self.changes,
                absent=self.absent,
                event=self.event,
            )
            for where, terms in self.binding(system)
            if not any(target in taken for term in terms for target in term.targets)
        ]
