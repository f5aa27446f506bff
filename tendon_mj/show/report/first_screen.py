"""First screen of a report: what is wrong with the rig's model, by how much, and what to do now."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from tendon_mj.lab.diagnosis import BeforeAfter, Diagnosis, Finding, Verdict
from tendon_mj.lab.recordings import noise_levels
from tendon_mj.lab.replay import replay_error
from tendon_mj.show.report.advice import advise
from tendon_mj.show.report.parts import PARTS

# verdict → what it means
MEANING: Final[dict[Verdict, str]] = {
    "named": "An effect is missing from the model; held-out data prove it.",
    "parameter": "A parameter of the model is wrong; held-out data prove it.",
    "partly": "A part of the error is explained; what remains is not.",
    "nothing missing": "The model explains the recordings down to their noise.",
    "unknown": "The error is not explained, and nothing is proven.",
}


def meaning(diagnosis: Diagnosis) -> str:
    """What the verdict means; a named effect that the model has too little of is not missing."""
    verdict = diagnosis.verdict
    if verdict == "nothing missing" and diagnosis.bars:
        return "The model explains the recordings down to what differs between sessions of the rig."
    if diagnosis.withheld:
        return "The recordings have a fault; whether the model lacks anything cannot be said."
    if verdict == "named" and all(found.recording for found in diagnosis.findings):
        return "An event explains the error; the model lacks nothing else."
    if verdict == "named" and all(found.kind == "parameter" for found in diagnosis.findings):
        verdict = "parameter"
    return MEANING[verdict]


def headline(diagnosis: Diagnosis) -> str:
    """What was found, in a sentence with the values and their units."""
    if diagnosis.verdict == "nothing missing":
        return "Nothing is missing from the model."
    if diagnosis.withheld:
        return "No effect is named: the recordings have a fault that would be taken for one."
    if diagnosis.verdict == "unknown":
        return "Nothing in the catalogue explains the error."
    missing, wrong, happened = (
        " and ".join(
            f.statement if f.statement and not f.elsewhere else _anywhere(f)
            for f in diagnosis.findings
            if ("happened" if f.recording else f.kind) == kind
        )
        for kind in ("missing", "parameter", "happened")
    )
    parts = [f"the model lacks {missing}"] if missing else []
    parts += [happened] if happened else []
    parts += [wrong] if wrong else []
    said = "; ".join(parts)
    if diagnosis.verdict == "partly":
        said = f"in part, {said}"
    return said[:1].upper() + said[1:] + "."


def _anywhere(finding: Finding) -> str:
    return f"{finding.name} ({' or '.join((finding.where, *finding.elsewhere))})"


def what_to_do(diagnosis: Diagnosis) -> list[str]:
    """Sentences that say what to do now, the first one about the model, as model.xml."""
    catalogue = diagnosis.catalogue
    if diagnosis.verdict == "nothing missing":
        return [
            "Use model.xml, the model with its calibrated values.",
            "An effect that the motion of these recordings does not bring out cannot be seen in"
            " them: record the motions that the model is for.",
        ]
    if diagnosis.withheld:
        return [
            "Do not rely on model.xml: what is uncertain was fitted to the fault too.",
            *(
                f"{w.place}: {w.way_out}; then diagnose again."
                for w in diagnosis.checks
                if w.blocks
            ),
        ]
    if diagnosis.verdict == "unknown":
        advice = advise(diagnosis.closest, catalogue)
        if diagnosis.closest:
            names = " and ".join(catalogue[name].name for name in diagnosis.closest)
            first = (
                f"Do not rely on model.xml: it has what comes closest ({names}), which is not"
                " proven."
            )
        else:
            first = "Do not rely on model.xml: it is only calibrated, and an error remains."
        return [first, *(advice or [_record_more(diagnosis)])]
    said = [
        "Use model.xml, which has what was found; tendon-mj replay RECORDING --model model.xml"
        " shows how it follows a recording, with the --description of this diagnosis if it had one."
    ]
    if diagnosis.verdict == "partly":
        without = f", without {', '.join(diagnosis.excluded)}," if diagnosis.excluded else ""
        said = [
            "Use model.xml with care: an error remains that nothing in the catalogue"
            f"{without} explains."
        ]
        said.append(_record_more(diagnosis))
    for group in diagnosis.indistinguishable:
        names = " from ".join(name.replace("_", " ") for name in group[:2])
        said.append(f"These data can't tell {names}. {' '.join(advise(group, catalogue))}")
    missing = [f for f in diagnosis.findings if f.kind == "missing"]
    for finding in missing:
        if finding.recording:
            said.append(
                f"Model.xml has no slip. To replay recording {finding.recording!r}, state it in the"
                f" [known] of that recording, or record it again: look at"
                f" {PARTS.get(finding.identifier, finding.where)}."
            )
            continue
        part = PARTS.get(finding.identifier)
        look = f"look at {part} ({finding.where})" if part else f"inspect {finding.where}"
        effect = f"{catalogue[finding.identifier].name}" if len(missing) > 1 else "this effect"
        said.append(f"If the rig should not have {effect}, {look}.")
    return said


def _record_more(diagnosis: Diagnosis) -> str:
    located = diagnosis.remaining if diagnosis.changed else diagnosis.located
    return f"Record more of what brings out the rest. {located.sentence}"


def most_telling(simulated: Sequence[BeforeAfter]) -> tuple[BeforeAfter, str]:
    """The recording, and its column, whose error before is the most above noise.

    Args:
        simulated: one or more, each with a measured column.
    """
    ratios = [
        (error.rmse / noise_levels(row.measured)[column], -k, row, column)
        for k, row in enumerate(simulated)
        for column, error in replay_error(row.measured, row.before).items()
    ]
    best = max(ratios, key=lambda found: found[:2])
    return best[2], best[3]
