"""Bindings of an effect to a model: its sheaths, sensors, joints, driven actuators or gravity."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

from tendon_mj.diagnosis.effects.effect import Binding, Bound, SystemDescription, Term
from tendon_mj.errors import InvalidValueError


@dataclass(frozen=True)
class ParameterSpecification:
    """A parameter that an effect writes, before it is bound to elements.

    Attributes:
        parameter: its name after the element's.
        unit: of the number that is fitted.
        low, high: sensible range; with ``relative`` as factors of the value that the model has.
        probe: change by which screening judges its influence; with ``relative`` as a share of that
            value.
        relative_to, starts: see `Term`.
        relative: the range and the probe are relative to the model's own value, which is inert.

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

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise InvalidValueError(f"{self.parameter}: range {self.low:g} … {self.high:g} is none")
        if not self.probe > 0.0:
            raise InvalidValueError(f"{self.parameter}: probe = {self.probe:g} must be > 0")
        for start in self.starts:
            if not max(self.low, 0.0) < start < self.high:
                span = f"{self.low:g} … {self.high:g}"
                raise InvalidValueError(
                    f"{self.parameter}: start {start:g} must be > 0 and within {span}"
                )

    def term(
        self, elements: tuple[str, ...], system: SystemDescription, scale: float = 1.0
    ) -> Term | None:
        """Bind it to elements that all get the same value; ``scale`` stretches range and probe.

        Returns:
            None where an element lacks the parameter; with ``relative`` also where the model's
            value is 0 or differs between the elements.
        """
        targets = tuple(f"{element}.{self.parameter}" for element in elements)
        if not targets or any(target not in system.values for target in targets):
            return None
        value = system.values[targets[0]]
        if self.relative:
            if value == 0.0 or any(system.values[t] != value for t in targets):
                return None
            low, high = sorted((self.low * value, self.high * value))
            return Term(targets, self.unit, value, low, high, self.probe * abs(value))
        if self.starts:  # a logarithm is fitted, which no scale stretches
            low, high, probe = self.low, self.high, self.probe
            return Term(targets, self.unit, 0.0, low, high, probe, self.relative_to, self.starts)
        inert = 0.0 if self.relative_to else value
        low, high = min(inert, scale * self.low), max(inert, scale * self.high)
        return Term(targets, self.unit, inert, low, high, scale * self.probe, self.relative_to)


Specifications = tuple[ParameterSpecification, ...]


def on_sheaths(*specifications: ParameterSpecification) -> Binding:
    """All sheaths of the model, which get the same value; and each of several by itself."""
    return partial(_sheaths, specifications)


def on_sensors(*specifications: ParameterSpecification, spans: bool = True) -> Binding:
    """A candidate for each measured sensor; ``spans``: numbers are shares of its measured span."""
    return partial(_sensors, specifications, spans)


def on_joints(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each joint whose motion no driven actuator prescribes."""
    return partial(_joints, specifications)


def on_inputs(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each driven actuator."""
    return partial(_inputs, specifications)


def on_gravity(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each axis of gravity, which belongs to no element."""
    return partial(_gravity, specifications)


def on_frictionless_sheaths(*specifications: ParameterSpecification) -> Binding:
    """Like `on_sheaths`, only on a model none of whose sheaths has friction."""
    return partial(_frictionless_sheaths, specifications)


def together(*bindings: Binding) -> Binding:
    """The candidates of several bindings."""
    return partial(_together, bindings)


def parameters_of(binding: Binding) -> set[str]:
    """Names of the parameters that a binding of this module looks for; none of another function."""
    if not isinstance(binding, partial):
        return set()
    parts = [part for argument in binding.args if isinstance(argument, tuple) for part in argument]
    found = {part.parameter for part in parts if isinstance(part, ParameterSpecification)}
    return found.union(*(parameters_of(part) for part in parts))


# Functions of modules, bound by `partial`, and no closures: effects can be sent to processes.


def _bind(
    specifications: Specifications,
    elements: tuple[str, ...],
    system: SystemDescription,
    scale: float = 1.0,
) -> Bound:
    """One candidate whose elements share its values; none where a parameter is not there."""
    bound = (specification.term(elements, system, scale) for specification in specifications)
    terms = tuple(term for term in bound if term is not None)
    return [(", ".join(elements), terms)] if len(terms) == len(specifications) else []


def _each(
    specifications: Specifications, elements: Iterable[str], system: SystemDescription
) -> Bound:
    """A candidate for each element by itself."""
    return [bound for e in elements for bound in _bind(specifications, (e,), system)]


def _sheaths(specifications: Specifications, system: SystemDescription) -> Bound:
    sheaths = tuple(system.elements(specifications[0].parameter))
    alone = _each(specifications, sheaths, system) if len(sheaths) > 1 else []
    return _bind(specifications, sheaths, system) + alone


def _frictionless_sheaths(specifications: Specifications, system: SystemDescription) -> Bound:
    friction = [system.values[f"{sheath}.friction"] for sheath in system.elements("friction")]
    return [] if any(friction) else _sheaths(specifications, system)


def _sensors(specifications: Specifications, spans: bool, system: SystemDescription) -> Bound:
    return [
        bound
        for sensor, span in system.spans.items()
        for bound in _bind(specifications, (sensor,), system, span if spans else 1.0)
    ]


def _joints(specifications: Specifications, system: SystemDescription) -> Bound:
    return _each(specifications, system.free_joints, system)


def _inputs(specifications: Specifications, system: SystemDescription) -> Bound:
    return _each(specifications, system.inputs, system)


def _gravity(specifications: Specifications, system: SystemDescription) -> Bound:
    return [bound for one in specifications for bound in _each((one,), ("gravity",), system)]


def _together(bindings: tuple[Binding, ...], system: SystemDescription) -> Bound:
    return [bound for binding in bindings for bound in binding(system)]
