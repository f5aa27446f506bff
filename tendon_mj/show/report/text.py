"""Sentences and tables of a report: the verdict, the next steps, and rows of values and errors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tendon_mj.lab.diagnosis import (
    DISCRIMINATING_EXPERIMENTS,
    MEANING,
    Autocorrelation,
    BeforeAfter,
    Diagnosis,
    Effect,
    ErrorReduction,
    Finding,
    Value,
    state_alternatives,
)
from tendon_mj.lab.noise import noise_levels
from tendon_mj.lab.replay import replay_error
from tendon_mj.lab.units import column_name, column_unit, engineering_unit, plain

ABSENT = "–"
_NAMES = 3  # of parameters that share a value


def meaning(diagnosis: Diagnosis) -> str:
    """Meaning of the verdict; a named effect that the model has too little of is not missing."""
    verdict, findings = diagnosis.verdict, diagnosis.findings
    if verdict == "nothing missing" and diagnosis.bars:
        return "The model explains the recordings down to the scatter between sessions of the rig."
    if diagnosis.withheld:
        return "The recordings have a fault; whether the model lacks anything cannot be said."
    if verdict == "named" and all(finding.recording for finding in findings):
        return "An event explains the error; the model lacks nothing else."
    if verdict == "named" and all(finding.kind == "parameter" for finding in findings):
        verdict = "parameter"
    return MEANING[verdict]


def headline(diagnosis: Diagnosis) -> str:
    """The findings in a sentence with values and units."""
    if diagnosis.verdict == "nothing missing":
        return "Nothing is missing from the model."
    if diagnosis.verdict == "undetermined":
        names = dict.fromkeys(n for other in diagnosis.alternatives for n in other.values)
        return f"These recordings cannot tell {', '.join(names)}."
    if diagnosis.withheld:
        return "No effect is named: the recordings have a fault that would be taken for one."
    if diagnosis.verdict == "unknown":
        return "Nothing was found that explains the error."
    missing, sensors, wrong, happened = (
        " and ".join(f.summary for f in diagnosis.findings if _kind(f) == kind)
        for kind in ("missing", "sensor", "parameter", "happened")
    )
    has = sensors and f"the rig has {sensors}"
    parts = (missing and f"the model lacks {missing}", has, happened, wrong)
    sentence = "; ".join(part for part in parts if part)
    if diagnosis.verdict == "partly":
        sentence = f"in part, {sentence}"
    return sentence[:1].upper() + sentence[1:] + "."


def _kind(finding: Finding) -> str:
    """What a finding is of: an effect of the rig or of a sensor, a parameter, or an event."""
    if finding.recording:
        return "happened"
    is_of_sensor = finding.kind == "missing" and finding.identifier.startswith("sensor_")
    return "sensor" if is_of_sensor else finding.kind


def remainder(white: Mapping[str, tuple[Autocorrelation, Autocorrelation]]) -> str:
    """Sentence on the whiteness of the residuals that the final model leaves, by column."""
    correlated = [column_name(column) for column, (_, after) in white.items() if not after.white]
    if not correlated:
        return "What remains looks like noise: its samples are uncorrelated."
    return f"What remains is correlated ({', '.join(correlated)}): part of it is not white noise."


def what_to_do(diagnosis: Diagnosis) -> list[str]:
    """Next steps as sentences, the first one about the model, as model.xml."""
    if diagnosis.verdict == "nothing missing":
        return [
            "Use model.xml, the model with its calibrated values.",
            "An effect that the motion of these recordings does not bring out cannot be seen in"
            " them: record the motions that the model is for.",
        ]
    if diagnosis.verdict == "undetermined":
        told = state_alternatives(diagnosis, diagnosis.alternatives)
        return [f"Do not rely on the numbers in model.xml that are not determined. {told}"]
    if diagnosis.withheld:
        blocking = [warning for warning in diagnosis.checks if warning.blocks]
        return [
            "Do not rely on model.xml: its uncertain values were fitted to the fault too.",
            *(f"{one.place}: {one.way_out}; then diagnose again." for one in blocking),
        ]
    if diagnosis.verdict == "unknown":
        first = "Do not rely on model.xml: it is only calibrated, and an error remains."
        if diagnosis.closest:
            names = " and ".join(diagnosis.catalogue[name].name for name in diagnosis.closest)
            first = (
                f"Do not rely on model.xml: it has the closest explanation ({names}), which is not"
                " proven."
            )
        advice = advise(diagnosis.closest, diagnosis.catalogue)
        page = (
            'The page "It says unknown: what now?" of the documentation says what the shape of the'
            " residual tells, and how to go on."
        )
        return [first, *(advice or [_record_more(diagnosis)]), page]
    use = [
        "Use model.xml, which includes the findings; tendon-mj replay RECORDING --model model.xml"
        " shows how it follows a recording, with the --description of this diagnosis if it had one."
    ]
    if diagnosis.verdict == "partly":
        without = f", without {', '.join(diagnosis.excluded)}," if diagnosis.excluded else ""
        use = [
            f"Use model.xml with care: an error remains, and nothing was found{without} that"
            " explains it.",
            _record_more(diagnosis),
        ]
    ties = [
        f"These data can't tell {' from '.join(name.replace('_', ' ') for name in group[:2])}."
        f" {' '.join(advise(group, diagnosis.catalogue))}"
        for group in diagnosis.indistinguishable
    ]
    return [*use, *ties, *_inspections(diagnosis)]


def _inspections(diagnosis: Diagnosis) -> list[str]:
    sentences, missing = [], [f for f in diagnosis.findings if f.kind == "missing"]
    for finding in diagnosis.findings:
        part = diagnosis.catalogue[finding.identifier].look_at
        if finding.kind == "parameter":
            if part:
                sentences.append(f"Check {part} ({finding.where}).")
            continue
        if finding.recording:
            sentences.append(
                f"Model.xml has no slip. To replay recording {finding.recording!r}, state it in the"
                f" [known] of that recording, or record it again: look at {part or finding.where}."
            )
            continue
        look = f"look at {part} ({finding.where})" if part else f"inspect {finding.where}"
        name = diagnosis.catalogue[finding.identifier].name
        effect = name if len(missing) > 1 else "this effect"
        sentences.append(f"If the rig should not have {effect}, {look}.")
    return sentences


def _record_more(diagnosis: Diagnosis) -> str:
    located = diagnosis.remaining if diagnosis.changed else diagnosis.located
    return f"Record more of the motions that bring out the rest. {located.sentence}"


def advise(group: Sequence[str], catalogue: Mapping[str, Effect]) -> list[str]:
    """Sentences on the experiments that tell the effects of a group apart.

    One for every pair that is known to tie; for effects in none of these, the motion that brings
    each of them out.
    """
    sentences: dict[str, None] = {}  # in order, each once
    covered: set[str] = set()
    for k, name in enumerate(group):
        for other in group[k + 1 :]:
            sentence = DISCRIMINATING_EXPERIMENTS.get(frozenset({name, other}))
            if sentence:
                covered |= {name, other}
                sentences[sentence] = None
    alone = [
        f"For {name.replace('_', ' ')}, record {catalogue[name].next_experiment}."
        for name in group
        if name not in covered and catalogue[name].next_experiment
    ]
    return [*sentences, *alone]


def most_telling(simulated: Sequence[BeforeAfter]) -> tuple[BeforeAfter, str]:
    """The recording and measured column with the largest error before, relative to the noise."""
    ratios = [
        (error.rmse / noise_levels(row.measured)[column], row, column)
        for row in simulated
        for column, error in replay_error(row.measured, row.before).items()
    ]
    _, row, column = max(ratios, key=lambda ratio: ratio[0])
    return row, column


class ValueRow(NamedTuple):
    """A fitted parameter, or several that share its value, written in ``unit``."""

    name: str
    value: str
    low: str
    high: str
    before: str
    unit: str
    note: str
    fitted: Value  # the numbers that are written


def error_rows(
    errors: ErrorReduction,
    sysid: Mapping[str, float] | None = None,
    reproducibility: Mapping[str, float] | None = None,
) -> list[dict[str, str]]:
    """A row for each signal; ``sysid`` and ``reproducibility`` are in the columns' units."""
    rows = []
    for column, (before, after, noise) in errors.signals.items():
        rival = (sysid or {}).get(column, math.nan)
        between = (reproducibility or {}).get(column, math.nan)
        unit = engineering_unit(column_unit(column), (before, after, rival))
        errors_of = {"before": before, "after": after, "sysid": rival}
        errors_of |= {"noise": noise, "between": between}
        cells = {name: written(unit.factor * error) for name, error in errors_of.items()}
        rows.append({"signal": column_name(column), **cells, "unit": unit.symbol})
    return rows


def value_rows(values: Mapping[str, Value]) -> list[ValueRow]:
    """A row for each parameter, or for the same parameter of elements that share a value."""
    shared: dict[tuple[str, Value], list[str]] = {}
    for name, of in values.items():
        key = name.rpartition(".")[2], replace(of, before=0.0)
        shared.setdefault(key, []).append(name)
    rows = []
    for names in shared.values():
        v, before = values[names[0]], [values[name].before for name in names]
        unit = engineering_unit(v.unit, (v.value, *before))
        note = "" if v.determined else "not determined: its whole range"
        note = "at an end of its range" if v.at_end else note
        numbers = (v.value, v.low, v.high, min(before), max(before))
        value, low, high, *ends = (written(x * unit.factor, 4) for x in numbers)
        model = " … ".join(dict.fromkeys(ends))
        listed = ", ".join(names[:_NAMES]) + (f" … ({len(names)})" if names[_NAMES:] else "")
        symbol = unit.symbol or ABSENT
        rows.append(ValueRow(listed, value, low, high, model, symbol, note, v))
    return rows


def written(value: float, digits: int = 3) -> str:
    """A number to so many significant digits."""
    return plain(value, digits) if math.isfinite(value) else ABSENT
