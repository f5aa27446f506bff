"""Bindings of an effect to a model: its sheaths, sensors, joints, driven actuators or gravity."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis.effects.effect import (
    Binding,
    Bound,
    ExcessTerm,
    FactorTerm,
    QuotientTerm,
    ShiftTerm,
    SystemDescription,
    Term,
)

_SMALLEST_SHARE = 0.01  # of the model's own value: a smaller probe hardly shows


@dataclass(frozen=True)
class ParameterSpecification:
    """A parameter that an effect writes, before it is bound to elements.

    Attributes:
        parameter: its name after the element's.
        unit: of the number that is fitted.
        low, high: sensible range; with ``relative`` as factors of the value that the model has.
        probe: change by which screening judges its influence; with ``relative`` as a share of that
            value.
        relative_to: where given, the number is the excess over this parameter of its element, as a
            share of it.
        starts, larger: see `Term`.
        relative: a factor of the model's own value is fitted, in common for several elements
            whatever their values; an element whose value is 0 is left out.
        times: with ``relative`` a position: the factor is of its distance from the reference pose
            times this parameter of its element, as of the torque of a spring in that pose.

    Raises:
        InvalidValueError: an empty range, no probe, or a start outside the range or not positive.
    """

    parameter: str
    unit: str
    low: float
    high: float
    probe: float
    relative_to: str = ""
    starts: tuple[float, ...] = ()
    relative: bool = False
    times: str = ""
    larger: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        where, span = self.parameter, f"{self.low:g} … {self.high:g}"
        if not self.low < self.high:
            raise InvalidValueError(f"{where}: range {span} is empty")
        if not self.probe > 0.0:
            raise InvalidValueError(f"{where}: probe = {self.probe:g} must be > 0")
        for start in self.starts:
            if not max(self.low, 0.0) < start < self.high:
                raise InvalidValueError(f"{where}: start {start:g} must be > 0 and within {span}")

    def term(
        self, elements: tuple[str, ...], system: SystemDescription, scale: float = 1.0
    ) -> Term | None:
        """Bind it to elements that all get the same value; ``scale`` stretches range and probe.

        If the model's values differ, all are changed by as much.

        Returns:
            None where an element lacks the parameter; with ``relative`` also where its value is 0.
        """
        targets = tuple(f"{element}.{self.parameter}" for element in elements)
        if not targets or any(target not in system.values for target in targets):
            return None
        own = tuple(system.values[target] for target in targets)
        if self.relative:
            return self._factor(targets, own, elements, system)
        if self.starts:  # a logarithm is fitted, which no scale stretches
            numbers, starts = (0.0, self.low, self.high, self.probe), self.starts
        else:
            inert, starts = 0.0 if self.relative_to else own[0], ()
            more = tuple(value - inert for value in own)
            differ = len(set(own)) > 1 and not self.relative_to
            low = min(inert, scale * self.low - (min(more) if differ else 0.0))
            high = max(inert, scale * self.high - (max(more) if differ else 0.0))
            numbers = (inert, low, high, max(scale * self.probe, _SMALLEST_SHARE * abs(inert)))
            if differ:
                return ShiftTerm(targets, self.unit, *numbers, more=more)
        if self.relative_to:
            return ExcessTerm(targets, self.unit, *numbers, starts, depends_on=self.relative_to)
        return Term(targets, self.unit, *numbers, starts, larger=self.larger)

    def _factor(
        self,
        targets: tuple[str, ...],
        own: tuple[float, ...],
        elements: tuple[str, ...],
        system: SystemDescription,
    ) -> Term | None:
        """Factor of the model's values; None if one of these is 0."""
        numbers = (targets, "-", 1.0, self.low, self.high, self.probe)
        if not self.times:
            return FactorTerm(*numbers, own=own) if all(own) else None
        origin = system.reference.get(targets[0], 0.0)
        products = tuple((own[0] - origin) * system.values[f"{e}.{self.times}"] for e in elements)
        if not all(products):
            return None
        return QuotientTerm(*numbers, products=products, depends_on=self.times, origin=origin)


Specifications = tuple[ParameterSpecification, ...]


def _bind(
    specifications: Specifications,
    elements: tuple[str, ...],
    system: SystemDescription,
    scale: float = 1.0,
) -> Bound:
    """One candidate whose elements share its values; none if a parameter is missing."""
    bound = (specification.term(elements, system, scale) for specification in specifications)
    terms = tuple(term for term in bound if term is not None)
    return [(", ".join(elements), terms)] if len(terms) == len(specifications) else []


# Effects can be sent to processes: bindings are objects of functions of this module, no closures.


@dataclass(frozen=True)
class ElementBinding:
    """Binding to elements of a model."""

    specifications: Specifications  # of the parameters
    # of a system, for the name of the first parameter
    elements: Callable[[SystemDescription, str], Iterable[str]]
    # whether a candidate for all elements together goes before one for each of several
    shared: bool = False

    def __call__(self, system: SystemDescription) -> Bound:
        """Candidates on a system."""
        elements = self.elements(system, self.specifications[0].parameter)
        each = [bound for e in elements for bound in _bind(self.specifications, (e,), system)]
        if not self.shared:
            return each
        together = _bind(self.specifications, tuple(element for element, _ in each), system)
        return together + (each if len(each) > 1 else [])


def on(
    elements: Callable[[SystemDescription, str], Iterable[str]],
    *specifications: ParameterSpecification,
    shared: bool = False,
) -> Binding:
    """A candidate for each of some elements, such as `springs`; see `ElementBinding`."""
    return ElementBinding(specifications, elements, shared)


def on_sheaths(*specifications: ParameterSpecification) -> Binding:
    """All sheaths of the model, which get the same value; and each of several by itself."""
    return on(SystemDescription.elements, *specifications, shared=True)


def on_sensors(*specifications: ParameterSpecification, spans: bool = True) -> Binding:
    """A candidate for each measured sensor; ``spans``: numbers are shares of its measured span."""
    return partial(_sensors, specifications, spans)


def on_joints(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each joint whose motion no driven actuator prescribes."""
    return on(_joints, *specifications)


def on_inputs(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each driven column: its actuator or joint, or all that it drives."""
    return partial(_inputs, specifications)


def on_reels(*specifications: ParameterSpecification) -> Binding:
    """Like `on_sheaths`, without the candidates that do the same as those on `commands`.

    One command that drives all reels is wrong as all their radii are; of several commands each is
    wrong as one radius is.
    """
    return partial(_reels, specifications)


def on_gravity(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each axis of gravity, which belongs to no element."""
    return partial(_gravity, specifications)


def together(*bindings: Binding) -> Binding:
    """The candidates of several bindings."""
    return partial(_together, bindings)


def written_parameters(binding: Binding) -> set[str]:
    """Names of the parameters that a binding of this module writes; none of another function."""
    if isinstance(binding, ElementBinding):
        return {specification.parameter for specification in binding.specifications}
    if not isinstance(binding, partial):
        return set()
    parts = [p for a in binding.args for p in (a if isinstance(a, tuple) else (a,))]
    names = {part.parameter for part in parts if isinstance(part, ParameterSpecification)}
    return names.union(*(written_parameters(part) for part in parts))


def frictionless_sheaths(system: SystemDescription, parameter: str) -> list[str]:
    """All sheaths of a model none of which has friction."""
    friction = [system.values[f"{sheath}.friction"] for sheath in system.elements("friction")]
    return [] if any(friction) else system.elements(parameter)


def springs(system: SystemDescription, _: str) -> list[str]:
    """Joints of `on_joints` that have a spring."""
    return [joint for joint in system.free_joints if system.values.get(f"{joint}.stiffness")]


def armatures(system: SystemDescription, _: str) -> list[str]:
    """Joints of `on_joints`, but no slide whose body has a mass to be fitted: it does the same."""
    own = {joints[0] for name, joints in system.joints.items() if name.endswith(".mass") and joints}
    return [joint for joint in system.free_joints if joint not in own & system.slides]


def on_pulleys(specification: ParameterSpecification) -> Binding:
    """A candidate for each joint on whose drum or pulley sheaths wind in both senses.

    They all get the same value. What cables turn in one sense alone rests on one flank of its play.
    """
    return partial(_pulleys, specification)


def _pulleys(specification: ParameterSpecification, system: SystemDescription) -> Bound:
    end, wound = specification.parameter.split("_")[0], dict[str, list[str]]()
    for sheath in system.elements(specification.parameter):
        for joint in system.joints.get(f"{sheath}.{specification.parameter}", ()):
            wound.setdefault(joint, []).append(sheath)
    return [
        (joint, terms)
        for joint, sheaths in wound.items()
        if len({system.values[f"{sheath}.{end}_radius"] > 0.0 for sheath in sheaths}) == 2
        for _, terms in _bind((specification,), tuple(sheaths), system)
    ]


def drawn_plays(system: SystemDescription, parameter: str) -> list[str]:
    """Tendons and joints whose limits are the flanks of a play, by their names."""
    return [name for name in system.elements(parameter) if name.endswith("_play")]


def gears(system: SystemDescription, parameter: str) -> list[str]:
    """Sheaths of tendons that are not drawn: those that have a gear, or all if none has."""
    own = [name for name in system.elements(parameter) if system.values[f"{name}.{parameter}"]]
    return own or system.elements(parameter)


def bodies(system: SystemDescription, parameter: str) -> list[str]:
    """Bodies that one of the joints of `on_joints` moves."""
    return system.on_free_joints(system.elements(parameter), parameter)


def drives(system: SystemDescription, _: str) -> tuple[str, ...]:
    """Driven actuators and joints."""
    return system.inputs


def motors(system: SystemDescription, _: str) -> tuple[str, ...]:
    """Driven actuators whose force depends on their control alone."""
    return system.motors


def drives_on_joints(system: SystemDescription, parameter: str) -> list[str]:
    """Driven actuators on a joint of `on_joints`: their work was measured."""
    return system.on_free_joints(system.inputs, parameter)


def commands(system: SystemDescription, _: str = "") -> list[str]:
    """Driven actuators but motors."""
    return [name for name in system.inputs if name not in system.motors]


def _joints(system: SystemDescription, _: str) -> tuple[str, ...]:
    return system.free_joints


def _sensors(specifications: Specifications, spans: bool, system: SystemDescription) -> Bound:
    return [
        bound
        for sensor, span in system.spans.items()
        for bound in _bind(specifications, (sensor,), system, span if spans else 1.0)
    ]


def _inputs(specifications: Specifications, system: SystemDescription) -> Bound:
    driven = {name for names in system.columns for name in names}
    alone = [(name,) for name in system.inputs if name not in driven]
    return [b for names in (*system.columns, *alone) for b in _bind(specifications, names, system)]


def _reels(specifications: Specifications, system: SystemDescription) -> Bound:
    bound, driving = on_sheaths(*specifications)(system), len(commands(system))
    return bound if driving == 0 else bound[1:] if driving == 1 else []


def _gravity(specifications: Specifications, system: SystemDescription) -> Bound:
    return [bound for s in specifications for bound in _bind((s,), ("gravity",), system)]


def _together(bindings: tuple[Binding, ...], system: SystemDescription) -> Bound:
    return [bound for binding in bindings for bound in binding(system)]
