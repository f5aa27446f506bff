"""Where an effect can sit on a model: on its sheaths, sensors, joints or drives."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tendon_mj.diagnosis.effect import Rig, Term

Bound = list[tuple[str, tuple[Term, ...]]]
Binding = Callable[[Rig], Bound]


@dataclass(frozen=True)
class Knob:
    """A parameter before it is bound to elements.

    Attributes:
        parameter: its name after the element's.
        unit: of the number that is fitted.
        low, high: sensible range; with ``share`` as factors of the value that the model has.
        probe: change for a first look; with ``share`` as a share of that value.
        relative_to, starts: see `Term`.
        share: the range and the probe are relative to the model's own value, which is inert.
    """

    parameter: str
    unit: str
    low: float
    high: float
    probe: float
    relative_to: str = ""
    starts: tuple[float, ...] = ()
    share: bool = False

    def on(self, elements: tuple[str, ...], rig: Rig, scale: float = 1.0) -> Term | None:
        """Bind it to elements that all get the same value; ``scale`` stretches range and probe."""
        targets = tuple(f"{element}.{self.parameter}" for element in elements)
        if not targets or any(target not in rig.values for target in targets):
            return None
        value = rig.values[targets[0]]
        if self.share:
            if value == 0.0 or any(rig.values[t] != value for t in targets):
                return None
            low, high = sorted((self.low * value, self.high * value))
            return Term(targets, self.unit, value, low, high, self.probe * abs(value))
        inert = 0.0 if self.relative_to or self.starts else value
        low, high = min(inert, scale * self.low), max(inert, scale * self.high)
        if self.starts:
            low, high = self.low, self.high
        probe = scale * self.probe
        return Term(targets, self.unit, inert, low, high, probe, self.relative_to, self.starts)


def _bound(knobs: tuple[Knob, ...], elements: tuple[str, ...], rig: Rig, scale: float) -> Bound:
    terms = [knob.on(elements, rig, scale if not knob.starts else 1.0) for knob in knobs]
    if any(term is None for term in terms):
        return []
    return [(", ".join(elements), tuple(term for term in terms if term is not None))]


def on_sheaths(*knobs: Knob) -> Binding:
    """All sheaths of the model, which get the same value; and each of several by itself."""

    def bind(rig: Rig) -> Bound:
        sheaths = tuple(rig.elements(knobs[0].parameter))
        alone = _each(sheaths, knobs, rig) if len(sheaths) > 1 else []
        return _bound(knobs, sheaths, rig, 1.0) + alone

    return bind


def _each(elements: Iterable[str], knobs: tuple[Knob, ...], rig: Rig) -> Bound:
    """A candidate for each element by itself."""
    return [bound for element in elements for bound in _bound(knobs, (element,), rig, 1.0)]


def on_sensors(*knobs: Knob, spans: bool = True) -> Binding:
    """A candidate for each measured sensor; ``spans``: knobs are in shares of its measured span."""
    return lambda rig: [
        bound
        for sensor, span in rig.spans.items()
        for bound in _bound(knobs, (sensor,), rig, span if spans else 1.0)
    ]


def on_joints(*knobs: Knob) -> Binding:
    """A candidate for each joint that is not driven."""
    return lambda rig: _each(rig.free_joints, knobs, rig)


def on_inputs(*knobs: Knob) -> Binding:
    """A candidate for each driven actuator."""
    return lambda rig: _each(rig.inputs, knobs, rig)


def on_world(*knobs: Knob) -> Binding:
    """A candidate for each axis of gravity, which belongs to no element."""
    return lambda rig: [bound for knob in knobs for bound in _each(("gravity",), (knob,), rig)]


def together(*bindings: Binding) -> Binding:
    """The candidates of several places."""
    return lambda rig: [bound for binding in bindings for bound in binding(rig)]
