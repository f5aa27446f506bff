"""Sentences that state a verdict.

Statement of a finding: which number was wrong, which way, and what it should be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, Term
from tendon_mj.lab.diagnosis.evidence import NOISE, ErrorReduction, Verdict
from tendon_mj.lab.diagnosis.result import Finding, Value
from tendon_mj.lab.diagnosis.thresholds import PART
from tendon_mj.lab.replay import (
    Parameter,
    column_name,
    column_unit,
    engineering_unit,
    estimated_percent,
    from_to,
    parameter_of,
    plain,
    quantity,
)

_SLIPS = (
    " Where a tendon sticks and slips it may also be its values that were not found, or the steps"
    " that are too long."
)
_TOO_SMALL = 0.7  # error [noise]: a smaller one means that the noise is stated too large
_COARSE = 1.5  # error over the extrapolated one, from which the model's step is too long
ABOVE_NOISE = 1.05  # error [noise], from which a sentence says what the rest is put down to
_SHOWN = 4  # signals in the sentence


@dataclass(frozen=True, kw_only=True)
class Statement:
    """What a sentence says.

    Attributes:
        verdict, findings: to state.
        errors: of calibrated and final model on held-out data, with the model's own step [noise].
        weighed: the same in units of noise and reproducibility together.
        judged: these for a step of zero, by which the verdict was decided.
        reproducibility: column → standard deviation between sessions [the column's unit].
        extrapolated: error of the final model for a step of zero [noise].
        limit: excess χ² that is put down to the simulation [-].
        beyond: uncertain parameters that the explanation would take beyond their ranges.
        excluded: effects of the catalogue that were not considered.
        non_smooth: whether one of the findings is of a non-smooth effect.
        sheathed: whether the model has a sheath.
        faults: of the recordings, for which no effect is named.
    """

    verdict: Verdict
    findings: Sequence[Finding]
    errors: ErrorReduction
    weighed: ErrorReduction
    judged: ErrorReduction
    reproducibility: Mapping[str, float]
    extrapolated: float
    limit: float
    beyond: Sequence[str] = ()
    excluded: Sequence[str] = ()
    non_smooth: bool = False
    sheathed: bool = True
    faults: Sequence[str] = ()


def state(stated: Statement) -> str:
    """State the verdict, its findings, the error on held-out data, and what it is judged by."""
    if stated.verdict == "nothing missing":
        return _nothing(stated) + _between_sessions(stated)
    if stated.verdict == "unknown":
        return _unknown(stated) + _between_sessions(stated)
    happened = [finding for finding in stated.findings if finding.recording]
    others = [finding for finding in stated.findings if not finding.recording]
    missing = [finding for finding in others if finding.kind == "missing"]
    wrong = [finding for finding in others if finding.kind != "missing"]
    parts = [f"Missing: {_list(missing)}"] if missing else []
    if happened:
        said = _list(happened)
        parts.append(said if parts else said[0].upper() + said[1:])
    if wrong:
        parts.append(f"{'a' if parts else 'A'} parameter was wrong: {_list(wrong)}")
    text = f"{'; '.join(parts)}; {_shrank(stated)}."
    if stated.verdict == "partly":
        text = (
            f"In part {text[0].lower()}{text[1:]} Nothing in the catalogue{_without(stated)}"
            f" explains what remains, {_times(stated.judged, stated.judged.after)}."
        )
    return text + _between_sessions(stated)


def warn_of_ends(calibrated: Mapping[str, Value]) -> list[str]:
    """Warn of calibrated values at an end of their range."""
    return [
        f"{name} stands at an end of its range,"
        f" {from_to(value.low, value.high, value.unit, ' … ')}:"
        " if that is not the rig's limit, widen it."
        for name, value in calibrated.items()
        if value.at_end
    ]


def warn_of_step_and_noise(stated: Statement) -> list[str]:
    """Warn of a timestep that makes much of the error, and of noise that is stated too large."""
    error = stated.errors.after if stated.findings else stated.errors.before
    said = []
    if shorter := _steps_too_long(stated, error):
        said.append(
            f"The model's timestep is too long: of an error of {error:.2f} times the noise,"
            f" {stated.extrapolated:.2f} would be left in ever shorter steps; one {shorter} times"
            " shorter would do."
        )
    if error < _TOO_SMALL:
        said.append(
            f"The model is off by {error:.2f} times the noise, and none is that good: the noise in"
            " [measured], or its estimate where none is stated, is too large."
        )
    return said


def _unknown(stated: Statement) -> str:
    if stated.faults:
        more = f" (and {len(stated.faults) - 1} more)" if len(stated.faults) > 1 else ""
        return (
            f"No effect is named, as the recordings have a fault that would be taken for one:"
            f" {stated.faults[0]}{more}. Calibrated, the model is off by {_off(stated)} on held-out"
            " data. Mend the recordings and diagnose again."
        )
    text = f"Nothing in the catalogue{_without(stated)} explains the error."
    if not stated.findings:
        return f"{text} On held-out data the model is off by {_off(stated)}."
    taken = (
        f", and it would take {', '.join(stated.beyond)} beyond its range" if stated.beyond else ""
    )
    text += (
        f" What comes closest is not proven: {_list(stated.findings)}; {_shrank(stated)}"
        f"{_too_little(stated)}{taken}."
    )
    return text + (_SLIPS if stated.non_smooth else "")


def _too_little(stated: Statement) -> str:
    """What share of the error had to be closed, where less of it was."""
    shares = stated.weighed.reducible_closed, stated.judged.reducible_closed
    return ", of which two thirds are asked" if 0.0 < max(shares) < PART else ""


def _shrank(stated: Statement) -> str:
    """How far the errors on held-out data went, by signal and then over all."""
    errors = stated.errors
    signals = [
        f"{column_name(column)} {from_to(before, after, column_unit(column), ' to ')}"
        for column, (before, after, _) in errors.signals.items()
    ]
    shown = "; ".join(signals[:_SHOWN]) + ("; …" if len(signals) > _SHOWN else "")
    text = (
        f"on held-out data the error goes from {errors.before:.2f} to {errors.after:.2f} times the"
        " noise"
    )
    if shown:
        text = (
            f"on held-out data the error goes from {shown}; over all from {errors.before:.2f} to"
            f" {errors.after:.2f} times the noise"
        )
    text += _too_long(stated, errors.after)
    if _differs(stated):
        before = f"{stated.weighed.before:.2f}"
        text += f", from {before} to {_times(stated.weighed, stated.weighed.after)} together"
    if (closed := stated.weighed.reducible_closed) > 0.0:
        text += f", which closes {estimated_percent(closed)} of what could be closed"
    return text


def _off(stated: Statement) -> str:
    """The error of the calibrated model in units of noise, and in that of the verdict."""
    off = _times(stated.errors, stated.errors.before)
    if not _differs(stated):
        return off
    return f"{off}, {_times(stated.weighed, stated.weighed.before)} together"


def _times(errors: ErrorReduction, error: float) -> str:
    """An error in the unit of others: "2.85 times the noise"."""
    unit = "the noise" if errors.unit == NOISE else errors.unit
    return f"{error:.2f} times {unit}"


def _differs(stated: Statement) -> bool:
    """Whether a session of the rig differs from the next by more than noise."""
    return stated.weighed.unit != NOISE


def _between_sessions(stated: Statement) -> str:
    """How much the rig differs between sessions, which decides beside the noise."""
    if not _differs(stated):
        return ""
    levels = [
        f"{column_name(column)} {quantity(deviation, column_unit(column), 2)}"
        for column, deviation in stated.reproducibility.items()
        if deviation > 0.0
    ]
    return f" Between sessions of the rig, beyond noise, differ {', '.join(levels)} rms."


def _without(stated: Statement) -> str:
    return f", without {', '.join(stated.excluded)}," if stated.excluded else ""


def _too_long(stated: Statement, error: float) -> str:
    """Remark on a timestep that makes much of an error [noise]."""
    shorter = _steps_too_long(stated, error)
    if not shorter:
        return ""
    return (
        f" ({stated.extrapolated:.2f} in ever shorter steps: the model's timestep is too long"
        f" for it; one {shorter} times shorter would do)"
    )


def _steps_too_long(stated: Statement, error: float) -> int:
    """By how much the timestep had to be shorter where it makes much of an error [noise]; or 0."""
    if error <= _COARSE * stated.extrapolated:
        return 0
    steps = math.sqrt(error**2 - stated.extrapolated**2)  # in proportion to the timestep
    return max(2, math.ceil(steps))


def _nothing(stated: Statement) -> str:
    errors, steps = stated.errors, _too_long(stated, stated.errors.before)
    text = f"Nothing is missing: calibrated, the model is off by {_off(stated)}{steps}"
    if stated.weighed.before > ABOVE_NOISE and not steps:
        guides = " and its guides in place of a smooth sheath" if stated.sheathed else ""
        text += (
            f"; up to {math.sqrt(1.0 + stated.limit):.2f} is put down to the simulation itself, its"
            f" steps{guides}"
        )
    if errors.before < _TOO_SMALL:
        text += (
            ". No model is that good: the noise in [measured], or its estimate where none is"
            " stated, is too large and hides what is smaller"
        )
    return text + "."


def _list(findings: Sequence[Finding]) -> str:
    return ", and ".join(
        _said(finding)
        + (
            f" – or {' or '.join(finding.rivals)}, these data can't tell –"
            if finding.rivals
            else ""
        )
        for finding in findings
    )


def _said(finding: Finding) -> str:
    """What was found, with its value where it is on one element and no other."""
    if finding.statement and not finding.elsewhere:
        return finding.statement
    return f"{finding.name} ({' or '.join((finding.where, *finding.elsewhere))})"


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
    said = f"the {_named(first)} of {of} is {_which_way(first, before[first], after[first])}"
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


def _which_way(parameter: str, before: float, after: float) -> str:
    """Which way a number was wrong."""
    if parameter.rsplit(".", 1)[1] in _SIGNED or before * after < 0.0:
        return "wrong"
    return "too high" if abs(after) < abs(before) else "too low"
