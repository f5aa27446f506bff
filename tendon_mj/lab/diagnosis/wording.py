"""Words of a diagnosis: its verdict, its findings, its evidence and its warnings, in sentences."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

from tendon_mj.lab.data_check import FORCES, tells_force
from tendon_mj.lab.diagnosis.effects.effect import Candidate, ShiftTerm, Term, element
from tendon_mj.lab.diagnosis.limits import ABOVE_NOISE as ABOVE_NOISE
from tendon_mj.lab.diagnosis.limits import CLOSED
from tendon_mj.lab.diagnosis.result import Alternative, Diagnosis, Finding, Value
from tendon_mj.lab.diagnosis.verdict import NOISE, PART, ErrorReduction, Evidence, Verdict
from tendon_mj.lab.parameter_names import parameter_of
from tendon_mj.lab.replay import Parameter
from tendon_mj.lab.units import (
    column_name,
    column_unit,
    engineering_unit,
    estimated_percent,
    from_to,
    plain,
    quantity,
)

MEANING: Final[dict[Verdict, str]] = {
    "named": "An effect is missing, or the model has too little of it; held-out data prove it.",
    "parameter": "A parameter of the model is wrong; held-out data prove it.",
    "partly": "A part of the error is explained; the rest is not.",
    "nothing missing": "The model explains the recordings down to their noise.",
    "undetermined": "The model explains the recordings, and so does another with other numbers.",
    "unknown": "The error is not explained, and nothing is proven.",
}
NOTHING: Final = "Nothing is missing: "
UNDECIDED: Final = "Found, and not decided: "
_SLIPS = (
    " Where a tendon sticks and slips it may also be its values that were not found, or the steps"
    " that are too long."
)
_TOO_SMALL = 0.7  # error [noise]: a smaller one means that the noise is stated too large
_COARSE = 1.5  # error over the extrapolated one, from which the model's step is too long
_SHOWN = 4  # signals in the sentence

# parameter → its name in words, where that is not its identifier
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
_ABSENT = 1e-3  # of a probe from where the effect is absent: a fit comes no nearer


def state(
    verdict: Verdict,
    findings: Sequence[Finding],
    evidence: Evidence,
    *,
    excluded: Sequence[str] = (),
    faults: Sequence[str] = (),
) -> str:
    """State the verdict, its findings, and the error on held-out data by which it is judged.

    ``excluded`` are effects of the catalogue that were not considered, ``faults`` those of the
    recordings, for which no effect is named.
    """
    catalogue = "the catalogue" + (f", without {', '.join(excluded)}," if excluded else "")
    if verdict == "nothing missing":
        text = _nothing(evidence)
    elif verdict == "unknown" and faults:
        text = _faulty(evidence, faults)
    elif verdict == "unknown":
        text = f"{_not_found(catalogue)} the error. {_closest(findings, evidence)}"
    else:
        text = f"{_list_by_kind(findings)}; {_shrank(evidence)}."
        if verdict == "partly":
            text = (
                f"In part {text[0].lower()}{text[1:]} {_not_found(catalogue)} what"
                f" remains, {_times(evidence.extrapolated, evidence.extrapolated.after)}."
            )
    return text + _between_sessions(evidence)


def _not_found(catalogue: str) -> str:
    """Beginning of a sentence on what a search, which is never exhaustive, did not find."""
    return f"Nothing was found in {catalogue} that explains"


def _nothing(evidence: Evidence) -> str:
    errors, steps = evidence.held_out, _too_long(evidence, evidence.held_out.before)
    text = f"{NOTHING}calibrated, the model is off by {_off(evidence)}{steps}"
    if evidence.weighed.before > ABOVE_NOISE and not steps:
        guides = " and its guides in place of a smooth sheath" if evidence.lumping > 0.0 else ""
        text += (
            f"; up to {math.sqrt(1.0 + evidence.limit):.2f} is put down to the simulation itself,"
            f" its steps{guides}"
        )
    if errors.before < _TOO_SMALL:
        text += (
            ". No model is that good: the noise in [measured], or its estimate where none is"
            " stated, is too large and hides what is smaller"
        )
    return text + "."


def _faulty(evidence: Evidence, faults: Sequence[str]) -> str:
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    return (
        "No effect is named, as the recordings have a fault that would be taken for one:"
        f" {faults[0]}{more}. Calibrated, the model is off by {_off(evidence)} on held-out"
        " data. Mend the recordings and diagnose again."
    )


def _closest(findings: Sequence[Finding], evidence: Evidence) -> str:
    off = f"On held-out data the calibrated model is off by {_off(evidence)}."
    if not findings:
        return off
    shares = evidence.weighed.reducible_closed, evidence.extrapolated.reducible_closed
    too_little = ", of which two thirds are required" if 0.0 < max(shares) < PART else ""
    taken = (
        f", and it would take {', '.join(evidence.beyond)} beyond its range"
        if evidence.beyond
        else ""
    )
    return (
        f"{off} What comes closest is not proven: {', and '.join(f.summary for f in findings)};"
        f" {_shrank(evidence)}{too_little}{taken}.{_SLIPS if evidence.non_smooth else ''}"
    )


def _list_by_kind(findings: Sequence[Finding]) -> str:
    """Findings: effects that are missing, events, and parameters that were wrong."""
    happened = _list([f for f in findings if f.recording])
    missing = _list([f for f in findings if not f.recording and f.kind == "missing"])
    wrong = _list([f for f in findings if not f.recording and f.kind != "missing"])
    parts = [f"missing: {missing}"] if missing else []
    parts += [happened] if happened else []
    parts += [f"a parameter was wrong: {wrong}"] if wrong else []
    text = "; ".join(parts)
    return text[:1].upper() + text[1:]


def _list(findings: Sequence[Finding]) -> str:
    return ", and ".join(f.summary + _doubt(f) for f in findings)


def _doubt(finding: Finding) -> str:
    if finding.rivals:
        return f" – or {' or '.join(finding.rivals)}, these data can't tell –"
    sure = estimated_percent(finding.confidence)
    return f" – {sure} sure: others explain nearly as much –" if finding.confidence < 0.5 else ""


def _shrank(evidence: Evidence) -> str:
    """Reduction of the errors on held-out data, by signal and then over all."""
    errors = evidence.held_out
    signals = [
        f"{column_name(column)} {from_to(before, after, column_unit(column), ' to ')}"
        for column, (before, after, _) in errors.signals.items()
    ]
    shown = "; ".join(signals[:_SHOWN]) + ("; …" if len(signals) > _SHOWN else "")
    by_signal = f"{shown}; over all from " if shown else ""
    text = (
        f"on held-out data the error goes from {by_signal}{errors.before:.2f} to"
        f" {errors.after:.2f} times the noise{_too_long(evidence, errors.after)}"
    )
    if _sessions_differ(evidence):
        before = f"{evidence.weighed.before:.2f}"
        text += f", from {before} to {_times(evidence.weighed, evidence.weighed.after)} together"
    if (closed := evidence.weighed.reducible_closed) > 0.0:
        text += f", which closes {estimated_percent(closed)} of what could be closed"
    return text


def _off(evidence: Evidence) -> str:
    """The error of the calibrated model in units of noise, and in that of the verdict."""
    off = _times(evidence.held_out, evidence.held_out.before)
    if not _sessions_differ(evidence):
        return off
    return f"{off}, {_times(evidence.weighed, evidence.weighed.before)} together"


def _times(errors: ErrorReduction, error: float) -> str:
    """An error in the unit of others: "2.85 times the noise"."""
    unit = "the noise" if errors.unit == NOISE else errors.unit
    return f"{error:.2f} times {unit}"


def _sessions_differ(evidence: Evidence) -> bool:
    """Return whether a session of the rig differs from the next by more than noise."""
    return evidence.weighed.unit != NOISE


def _between_sessions(evidence: Evidence) -> str:
    """Standard deviations between sessions, which add to the noise in the verdict."""
    if not _sessions_differ(evidence):
        return ""
    levels = [
        f"{column_name(column)} {quantity(deviation, column_unit(column), 2)}"
        for column, deviation in evidence.reproducibility.items()
        if deviation > 0.0
    ]
    return f" Between sessions of the rig, beyond noise, differ {', '.join(levels)} rms."


def _too_long(evidence: Evidence, error: float) -> str:
    """Remark on a timestep that makes much of an error [noise]."""
    shorter = _steps_too_long(evidence, error)
    if not shorter:
        return ""
    return (
        f" ({evidence.zero_step:.2f} in ever shorter steps: the model's timestep is too long"
        f" for it; one {shorter} times shorter would do)"
    )


def _steps_too_long(evidence: Evidence, error: float) -> int:
    """Factor by which the timestep had to be shorter where it makes or hides an error; or 0.

    0 also if a simulation failed, as its error is infinite.
    """
    if not math.isfinite(max(error, evidence.zero_step)):
        return 0
    hides = evidence.zero_step > _COARSE * error and evidence.remaining > evidence.limit
    if error <= _COARSE * evidence.zero_step and not hides:
        return 0
    steps = math.sqrt(abs(error**2 - evidence.zero_step**2))  # in proportion to the timestep
    return max(2, math.ceil(steps))


def warn_of_step_and_noise(findings: Sequence[Finding], evidence: Evidence) -> list[str]:
    """Warn of a timestep that makes much of the error, and of noise that is stated too large."""
    error = evidence.held_out.after if findings else evidence.held_out.before
    warnings = []
    if shorter := _steps_too_long(evidence, error):
        warnings.append(
            f"The model's timestep is too long: the error is {error:.2f} times the noise, and would"
            f" be {evidence.zero_step:.2f} in ever shorter steps; one {shorter} times shorter would"
            " do."
        )
    if error < _TOO_SMALL:
        warnings.append(
            f"The model is off by {error:.2f} times the noise, and none is that good: the noise in"
            " [measured], or its estimate where none is stated, is too large."
        )
    return warnings


def warn_of_ends(calibrated: Mapping[str, Value]) -> list[str]:
    """Warn of calibrated values at an end of their range."""
    return [
        f"{name} stands at an end of its range,"
        f" {from_to(value.low, value.high, value.unit, ' … ')}:"
        " if that is not the rig's limit, widen it."
        for name, value in calibrated.items()
        if value.at_end
    ]


def state_alternatives(result: Diagnosis, alternatives: Sequence[Alternative]) -> str:
    """State which numbers the signals cannot tell, from what, and what would decide."""
    stated = {**result.calibrated, **result.parameters}
    moved = Counter(name for other in alternatives for name in other.values)
    most = max(moved, key=lambda name: moved[name])
    alike = [n for n in moved if stated[n].value == stated[most].value]
    there = [*filter(None, (_elsewhere(other, alike, stated) for other in alternatives))]
    here = f"{', '.join(alike)} = {quantity(stated[most].value, stated[most].unit)}"
    others = [name for name in moved if name not in alike]
    text = f"These signals cannot tell {here} from {', or from '.join(there[:_SHOWN])}"
    text += f"; nor do they tell {', '.join(others)}" if others else ""
    ways = list(dict.fromkeys(other.decided_by for other in alternatives if other.decided_by))
    effects = [result.catalogue[other.identifier] for other in alternatives if other.identifier]
    records = [e.next_experiment for e in effects if e.next_experiment]
    if not any(tells_force(r.measured) for r in result.recordings):
        ways.append(f"measure a force: {FORCES}")
    elif records:
        ways.append(f"record {', or '.join(dict.fromkeys(records))}")
    ways = ways or ["measure one of them and state it in [known]"]
    return f"{text}. To decide, {', or '.join(ways)}."


def _elsewhere(other: Alternative, alike: Sequence[str], stated: Mapping[str, Value]) -> str:
    """The value of an alternative that is farthest from one stated for all alike; or nothing."""
    values = {name: other.values[name] for name in alike if name in other.values}
    if not values:
        return ""
    name = max(values, key=lambda n: abs(values[n] - stated[n].value))
    named = f"{name} = " if len({*values.values()}) > 1 else ""
    return f"{named}{quantity(values[name], stated[name].unit)} with {other.statement}"


def reason(evidence: Evidence, verdict: Verdict | None) -> str:
    """The criterion that decides on a verdict; None if a search would have to decide."""
    errors, limit = evidence.extrapolated, f"{(1.0 + evidence.limit) ** 0.5:.2f}"
    unit = f"this {errors.unit}"
    off = f"The calibrated model leaves {errors.before:.2f} times {unit}"
    if verdict == "nothing missing" and evidence.remaining > evidence.limit:
        own = evidence.weighed.before
        return f"With the model's own step {own:.2f} times {unit} is left, and nothing stands out."
    if verdict == "nothing missing":
        return f"{off}, which is below the detection limit of {limit}."
    if verdict is None:
        return f"{off}, above the detection limit of {limit}: an effect would be sought."
    if evidence.beyond or evidence.at_end:
        return "The findings would take a parameter beyond its range, at any noise."
    closed = errors.reducible_closed
    removed = f"{100.0 * min(closed, 1.0):.1f} % of the error above {unit} is removed"
    remains = f"{errors.after:.2f} times {unit} remains"
    if verdict in ("named", "parameter"):
        if closed >= CLOSED:
            return f"{removed}; {100.0 * CLOSED:.1f} % is required."
        return f"{remains}, which is below the detection limit of {limit}."
    if verdict == "partly":
        required = 'two thirds are required for the verdict "partly"'
        return f"{removed}, and {required}; {remains}, which is not explained."
    if closed < PART:
        return f"{removed}, and two thirds are required; {remains}."
    if evidence.weighed.after >= evidence.weighed.before:
        return f"{removed}, but with the model's own step the error stays."
    return f"{removed}, but of a signal more remains than before."


def state_finding(
    candidate: Candidate,
    parameters: Mapping[str, Parameter],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> str:
    """State a finding: "the damping of joint elbow is too high: 19, not 400 N s/m".

    ``before`` and ``after`` are parameter → value of the model, and as fitted.
    """
    effect, first = candidate.effect, candidate.terms[0].targets[0]
    unit = parameters[parameter_of(first)].unit
    if effect.event:
        return _event(candidate, unit, after)
    if effect.kind == "missing" and not candidate.in_model(before):
        name = "" if engineering_unit(unit, ()).symbol else f"{_named(first)} "
        return f"{_placed(candidate)}, {name}{quantity(after[first], unit)}"
    numbers = candidate.terms if effect.kind == "parameter" else candidate.terms[:1]
    return ", and ".join(_wrong(t, effect.absent, parameters, before, after) for t in numbers)


def _event(candidate: Candidate, unit: str, after: Mapping[str, float]) -> str:
    """An event with its size, its time and its recording: "the cable slipped by 0.8 mm …"."""
    first, (time, *_) = candidate.terms[0].targets[0], candidate.terms[0].constants
    slipped = "the cable" if unit == "m" else "the cable or the drive"
    way = "let out" if after[first] < 0.0 else "drawn in"
    digits = min(max(0, 1 - math.floor(math.log10(max(time.high - time.low, 1e-3)))), 3)
    return (
        f"{slipped} slipped by {quantity(abs(after[first]), unit)} ({way}) at"
        f" {after[time.name]:.{digits}f} s of recording {candidate.recording!r}"
        f" ({first.rpartition('.')[0]})"
    )


def _wrong(
    term: Term,
    absent: float,
    parameters: Mapping[str, Parameter],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> str:
    """A number of the model that was wrong: which way, and its right value."""
    first = term.targets[0]
    unit, kind = parameters[first].unit, parameters[first].kind
    of = " and ".join(element(target) for target in term.targets)
    if len(term.targets) == 1 and kind in _ELEMENTS:
        of = f"{kind} {of}"
    text = f"the {_named(first)} of {of} is {_which_way(first, before[first], after[first])}"
    if len({plain(before[target]) for target in term.targets}) > 1:
        if not isinstance(term, ShiftTerm):
            return f"{text}: {plain(after[first] / before[first])} times what the model says"
        change = after[first] - before[first]
        more = "more" if change > 0.0 else "less"
        return f"{text}: {quantity(abs(change), unit)} {more} than the model says"
    value = absent if abs(after[first] - absent) < _ABSENT * term.probe else after[first]
    return f"{text}: {from_to(value, before[first], unit, ', not ')}"


def _placed(candidate: Candidate) -> str:
    """An effect's name with the elements it is on: "dry friction of joint elbow"."""
    name, where = candidate.effect.name, candidate.where
    if "a joint" in name and "," not in where:
        return name.replace("a joint", f"joint {where}")
    return f"{name} ({where})"


def _named(parameter: str) -> str:
    """A parameter, without its element, in words."""
    name = parameter.rsplit(".", 1)[1]
    return _NAMES.get(name, name.replace("_", " "))


def _which_way(parameter: str, before: float, after: float) -> str:
    """Direction of an error: "too high", "too low" or "wrong"."""
    if parameter.rsplit(".", 1)[1] in _SIGNED or before * after < 0.0:
        return "wrong"
    return "too high" if abs(after) < abs(before) else "too low"
