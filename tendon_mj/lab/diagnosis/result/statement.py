"""Statement of a finding: which number was wrong, which way, and what it should be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, Term
from tendon_mj.lab.replay import Parameter, engineering_unit, from_to, parameter_of, plain, quantity

# parameter → what it is called, where not by its name in words
_NAMES: Final = {
    "frictionloss": "dry friction",
    "springref": "rest position of the spring",
    "kp": "gain",
    "kv": "gain on the rate",
    "friction": "coefficient of friction",
    "drawn_bend": "bend",
    "extra_bend": "bend beyond the path's",
    "command_scale": "scale of the command",
    "command_offset": "offset of the command",
    "command_delay": "delay of the command",
    **{axis: f"{axis} component" for axis in "xyz"},
}
# Positions and offsets, which are neither high nor low.
_SIGNED: Final = {"springref", "extra_bend", "command_offset", "offset", "drift", "x", "y", "z"}
_ELEMENTS: Final = ("joint", "body", "actuator", "motor", "sensor")  # named before their names
_NONE = 1e-3  # of a probe from where there is none: a fit comes no nearer


def state_finding(
    effect: Effect,
    candidate: Candidate,
    parameters: Mapping[str, Parameter],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> str:
    """Say what was found: "the damping of joint elbow is too high: 19, not 400 N s/m".

    Args:
        effect, candidate: that was found.
        parameters: of the simulator, for units and kinds of elements.
        before, after: parameter → value of the model, and as fitted.
    """
    first = candidate.terms[0].targets[0]
    unit = parameters[parameter_of(first)].unit
    if candidate.event:
        return _event(candidate, unit, after)
    if candidate.kind == "missing" and not candidate.in_model(before):
        called = "" if engineering_unit(unit, ()).symbol else f"{_named(first)} "
        return f"{_placed(effect, candidate)}, {called}{quantity(after[first], unit)}"
    numbers = candidate.terms if candidate.kind == "parameter" else candidate.terms[:1]
    return ", and ".join(_wrong(t, candidate.absent, parameters, before, after) for t in numbers)


def _event(candidate: Candidate, unit: str, after: Mapping[str, float]) -> str:
    """What happened, how far, when and in which recording: "the cable slipped by 0.8 mm …"."""
    first, ((when, _, low, high), *_) = candidate.terms[0].targets[0], candidate.terms[0].beside
    slipped = "the cable" if unit == "m" else "the cable or the drive"
    way = "let out" if after[first] < 0.0 else "drawn in"
    digits = min(max(0, 1 - math.floor(math.log10(max(high - low, 1e-3)))), 3)
    return (
        f"{slipped} slipped by {quantity(abs(after[first]), unit)} ({way}) at"
        f" {after[when]:.{digits}f} s of recording {candidate.recording!r}"
        f" ({first.rpartition('.')[0]})"
    )


def _wrong(
    term: Term,
    absent: float,
    parameters: Mapping[str, Parameter],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> str:
    """Which number of the model was wrong, which way, and what it should be."""
    targets, first = term.targets, term.targets[0]
    unit = parameters[first].unit
    of = " and ".join(t.rsplit(".", 1)[0] for t in targets)
    if len(targets) == 1 and parameters[first].kind in _ELEMENTS:
        of = f"{parameters[first].kind} {of}"
    said = f"the {_named(first)} of {of} is {_off(first, before[first], after[first])}"
    differ = len({plain(before[target]) for target in targets}) > 1
    if differ and term.beyond:
        change = after[first] - before[first]
        more = "more" if change > 0.0 else "less"
        return f"{said}: {quantity(abs(change), unit)} {more} than the model says"
    if differ:
        return f"{said}: {plain(after[first] / before[first])} times what the model says"
    found = after[first]
    if abs(found - absent) < _NONE * term.probe:
        found = absent
    return f"{said}: {from_to(found, before[first], unit, ', not ')}"


def _placed(effect: Effect, candidate: Candidate) -> str:
    """An effect's name with the elements it is on: "dry friction of joint elbow"."""
    if "a joint" in effect.name and "," not in candidate.where:
        return effect.name.replace("a joint", f"joint {candidate.where}")
    return f"{effect.name} ({candidate.where})"


def _named(parameter: str) -> str:
    """A parameter, without its element, in words."""
    name = parameter.rsplit(".", 1)[1]
    return _NAMES.get(name, name.replace("_", " "))


def _off(parameter: str, before: float, after: float) -> str:
    """Which way a number was wrong."""
    if parameter.rsplit(".", 1)[1] in _SIGNED or before * after < 0.0:
        return "wrong"
    return "too high" if abs(after) < abs(before) else "too low"
