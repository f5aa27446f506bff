"""Bindings of an effect to a model: its sheaths, sensors, joints, driven actuators or gravity."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis.effects.effect import Binding, Bound, SystemDescription, Term

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
        relative_to, starts: see `Term`.
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

        Where the model's values differ, all are changed by as much.

        Returns:
            None where an element lacks the parameter; with ``relative`` also where its value is 0.
        """
        targets = tuple(f"{element}.{self.parameter}" for element in elements)
        if not targets or any(target not in system.values for target in targets):
            return None
        own = tuple(system.values[target] for target in targets)
        if self.relative:
            factor = Term(targets, "-", 1.0, self.low, self.high, self.probe, own=own)
            if self.times:
                origin, by = system.reference.get(targets[0], 0.0), system.values
                own = tuple((own[0] - origin) * by[f"{e}.{self.times}"] for e in elements)
                factor = replace(factor, own=own, divided_by=self.times, origin=origin)
            return factor if all(own) else None
        if self.starts:  # a logarithm is fitted, which no scale stretches
            low, high, probe = self.low, self.high, self.probe
            return Term(targets, self.unit, 0.0, low, high, probe, self.relative_to, self.starts)
        inert = 0.0 if self.relative_to else own[0]
        low, high = min(inert, scale * self.low), max(inert, scale * self.high)
        probe = max(scale * self.probe, _SMALLEST_SHARE * abs(inert))
        if len(set(own)) > 1 and not self.relative_to:
            beyond = tuple(value - inert for value in own)
            low = min(inert, scale * self.low - min(beyond))
            high = max(inert, scale * self.high - max(beyond))
            return Term(targets, self.unit, inert, low, high, probe, beyond=beyond)
        return Term(targets, self.unit, inert, low, high, probe, self.relative_to)


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


def on_springs(*specifications: ParameterSpecification) -> Binding:
    """Like `on_joints`, only on those that have a spring."""
    return partial(_springs, specifications)


def on_armatures(*specifications: ParameterSpecification) -> Binding:
    """Like `on_joints`, but on no slide whose body has a mass to be fitted, which does the same."""
    return partial(_armatures, specifications)


def on_bodies(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each body that one of the joints of `on_joints` moves."""
    return partial(_bodies, specifications)


def on_inputs(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each driven column: its actuator or joint, or all that it drives."""
    return partial(_inputs, specifications)


def on_drives(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each driven actuator or joint by itself."""
    return partial(_drives, specifications)


def on_motors(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each driven actuator whose force depends on nothing but its control."""
    return partial(_motors, specifications)


def on_servos(*specifications: ParameterSpecification) -> Binding:
    """A candidate for each driven actuator on a joint of `on_joints`: its work was measured."""
    return partial(_servos, specifications)


def on_commands(*specifications: ParameterSpecification) -> Binding:
    """All driven actuators but motors, by a common factor; and each of several by itself."""
    return partial(_commands, specifications)


def on_reels(*specifications: ParameterSpecification) -> Binding:
    """Like `on_sheaths`, without what the commands of `on_commands` do.

    One command that drives all reels is wrong as all their radii are; of several commands each is
    wrong as one radius is.
    """
    return partial(_reels, specifications)


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


def _all_and_each(
    specifications: Specifications, elements: Iterable[str], system: SystemDescription
) -> Bound:
    """A candidate for all elements together, and for each of several by itself."""
    there = tuple(e for e in elements if _each(specifications, (e,), system))
    alone = _each(specifications, there, system) if len(there) > 1 else []
    return _bind(specifications, there, system) + alone


def _sheaths(specifications: Specifications, system: SystemDescription) -> Bound:
    return _all_and_each(specifications, system.elements(specifications[0].parameter), system)


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


def _springs(specifications: Specifications, system: SystemDescription) -> Bound:
    sprung = [joint for joint in system.free_joints if system.values.get(f"{joint}.stiffness")]
    return _each(specifications, sprung, system)


def _armatures(specifications: Specifications, system: SystemDescription) -> Bound:
    own = {joints[0] for name, joints in system.joints.items() if name.endswith(".mass") and joints}
    with_mass = own & system.slides
    return _each(specifications, (j for j in system.free_joints if j not in with_mass), system)


def _bodies(specifications: Specifications, system: SystemDescription) -> Bound:
    parameter = specifications[0].parameter
    moved = [b for b in system.elements(parameter) if system.moves_freely(f"{b}.{parameter}")]
    return _each(specifications, moved, system)


def _inputs(specifications: Specifications, system: SystemDescription) -> Bound:
    several = {name for names in system.columns for name in names}
    alone = _each(specifications, (e for e in system.inputs if e not in several), system)
    return [b for names in system.columns for b in _bind(specifications, names, system)] + alone


def _drives(specifications: Specifications, system: SystemDescription) -> Bound:
    return _each(specifications, system.inputs, system)


def _motors(specifications: Specifications, system: SystemDescription) -> Bound:
    return _each(specifications, system.motors, system)


def _servos(specifications: Specifications, system: SystemDescription) -> Bound:
    parameter = specifications[0].parameter
    free = [e for e in system.inputs if system.moves_freely(f"{e}.{parameter}")]
    return _each(specifications, free, system)


def _commands(specifications: Specifications, system: SystemDescription) -> Bound:
    return _all_and_each(specifications, _driving(system), system)


def _reels(specifications: Specifications, system: SystemDescription) -> Bound:
    bound, commands = _sheaths(specifications, system), len(_driving(system))
    return bound if commands == 0 else bound[1:] if commands == 1 else []


def _driving(system: SystemDescription) -> list[str]:
    return [name for name in system.inputs if name not in system.motors]


def _gravity(specifications: Specifications, system: SystemDescription) -> Bound:
    return [bound for one in specifications for bound in _each((one,), ("gravity",), system)]


def _together(bindings: tuple[Binding, ...], system: SystemDescription) -> Bound:
    return [bound for binding in bindings for bound in binding(system)]
