"""Proof on held-out data: from the models of a selection to a verdict."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.data.sessions import spreads
from tendon_mj.lab.diagnosis.data.step_size import step_error
from tendon_mj.lab.diagnosis.effects.effect import Effect
from tendon_mj.lab.diagnosis.held_out import HeldOut, Unseen
from tendon_mj.lab.diagnosis.locate import locate
from tendon_mj.lab.diagnosis.model_selection.context import SelectionContext
from tendon_mj.lab.diagnosis.model_selection.fit import Fit
from tendon_mj.lab.diagnosis.model_selection.reproducibility import bar, reproducibility
from tendon_mj.lab.diagnosis.model_selection.select import Selection
from tendon_mj.lab.diagnosis.model_selection.thresholds import (
    detection_limit,
    discretisation_error,
    has_sheath,
)
from tendon_mj.lab.diagnosis.result.diagnosis import Diagnosis, Finding
from tendon_mj.lab.diagnosis.result.entries import (
    finding,
    fitted_values,
    parameters_beyond_range,
    ranking,
)
from tendon_mj.lab.diagnosis.result.error_reduction import measure_errors
from tendon_mj.lab.diagnosis.result.evidence import Evidence
from tendon_mj.lab.diagnosis.result.lumping import too_few_guides, warn_of_guides
from tendon_mj.lab.diagnosis.result.sentence import (
    ABOVE_NOISE,
    Statement,
    state,
    warn_of_ends,
    warn_of_step_and_noise,
)
from tendon_mj.lab.diagnosis.result.soft_friction import warn_of_soft_flanks, warn_of_soft_friction
from tendon_mj.lab.diagnosis.verdict import LARGEST, decide
from tendon_mj.typing import FloatArray


def prove(
    context: SelectionContext,
    selection: Selection,
    own: Problem,
    proof: Problem,
    step: float | None,
    catalogue: Mapping[str, Effect],
    excluded: Collection[str],
    checks: Sequence[DataWarning],
    began: float,
) -> Diagnosis:
    """Simulate the held-out data with the models of a selection, and decide.

    The decision rests on extrapolated errors, in units of noise and reproducibility together;
    stated are those that a replay with the model's own step finds. Where part of the error remains,
    an effect that explains less than that is taken out.

    Args:
        context, selection: training data, and the models selected on it.
        own: training data with the model's own step.
        proof: held-out recordings, likewise; ``own`` where there are none.
        step: of the selection, see `with_step`.
        catalogue: identifier → effect, of all that could have been named.
        excluded: identifiers of effects that were not considered.
        checks: warnings about the recordings.
        began: start of the diagnosis (`time.perf_counter`) [s].
    """
    held_out = HeldOut(context.problem, own, proof, step, context.base)
    before = held_out.simulate(selection.calibrated.fit)
    while True:
        after = held_out.simulate(selection.final.fit) if selection.effects else before
        findings = _findings(context, selection, catalogue)
        evidence, bars, deviations = _weigh(context, selection, held_out, (before, after))
        verdict = decide(evidence)
        if verdict != "partly":
            break
        fewer = _without_imitation(context, selection, held_out, after, bars, evidence.limit)
        if fewer is selection:
            break
        selection = fewer

    problem, base, mask, fits = context.problem, context.base, held_out.mask, _fits(selection)
    parameters = [fitted.parameters(base) for fitted in fits]
    seen = own.residuals(parameters)
    unseen = before.stated, after.stated
    stated = measure_errors(proof, unseen[0], unseen[1], mask)
    refits = held_out.refits(fits[1])
    calibrated = fitted_values(problem, base, fits[1], refits, calibrated=True)
    found = fitted_values(problem, base, fits[1], refits, calibrated=False)
    proven = verdict in ("named", "parameter", "partly")
    told = Statement(
        verdict=verdict,
        findings=findings,
        errors=stated,
        weighed=evidence.stated,
        judged=evidence.extrapolated,
        reproducibility=deviations,
        extrapolated=float(np.sqrt(np.mean(after.extrapolated[mask] ** 2))),
        limit=evidence.limit,
        beyond=parameters_beyond_range(problem, fits[1]),
        excluded=sorted(excluded),
        non_smooth=any(s.candidate.non_smooth for s in selection.effects),
        sheathed=has_sheath(own.simulate),
        faults=[warning.sentence for warning in checks if warning.blocks],
    )
    first = len(fits[1].calibrated)
    model = {**base, **parameters[1], **after.sessions}
    lumped = too_few_guides(proof, model, stated.after) if stated.after > ABOVE_NOISE else []
    limits = [*warn_of_ends(calibrated), *warn_of_guides(lumped)]
    if verdict in ("partly", "unknown"):
        limits += warn_of_soft_friction(own.simulate, model, _considered(selection))
    limits += warn_of_soft_flanks(own.simulate, model, {**calibrated, **found})
    return Diagnosis(
        verdict=verdict,
        sentence=" ".join([state(told), *limits]),
        findings=findings if proven else (),
        closest=() if proven else tuple(f.identifier for f in findings),
        excluded=tuple(sorted(excluded)),
        ranking=ranking(selection, problem.in_train),
        calibrated=calibrated,
        parameters=found,
        sessions=spreads(fits[1].calibrated, fits[1].values[:first]),
        reproducibility=deviations,
        train=measure_errors(own, seen[0], seen[1], own.in_train),
        held_out=stated,
        located=locate(own, seen[0], own.in_train),  # the held-out tails are left unseen
        remaining=locate(own, seen[1], own.in_train),
        proof=(locate(proof, unseen[0], mask), locate(proof, unseen[1], mask)),
        before={**base, **parameters[0], **before.sessions},
        model=model,
        seconds=time.perf_counter() - began,
        catalogue=catalogue,
        simulator=proof.simulate,
        recordings=own.recordings,
        held_out_recordings=proof.recordings if held_out.has_recordings else (),
        search=(context, selection),
        evidence=evidence,
        warnings=(
            *(f"Before any fit: {warning.sentence}." for warning in checks),
            *warn_of_step_and_noise(told),
            *limits,
        ),
        checks=tuple(checks),
    )


def _fits(selection: Selection) -> tuple[Fit, Fit]:
    """Calibrated and final fit."""
    return selection.calibrated.fit, selection.final.fit


def _findings(
    context: SelectionContext, selection: Selection, catalogue: Mapping[str, Effect]
) -> tuple[Finding, ...]:
    """Findings of a selection."""
    base, known = context.base, context.problem.simulate.parameters
    final = {**base, **selection.final.fit.parameters(base)}
    return tuple(finding(effect, catalogue, known, base, final) for effect in selection.effects)


def _considered(selection: Selection) -> set[str]:
    """Parameters of the selected effects and of their rivals."""
    candidates = (c for s in selection.effects for c in (s.candidate, *s.rivals))
    return {target for candidate in candidates for target in candidate.targets}


def _weigh(
    context: SelectionContext,
    selection: Selection,
    held_out: HeldOut,
    unseen: tuple[Unseen, Unseen],
) -> tuple[Evidence, FloatArray, dict[str, float]]:
    """Evidence of a selection; (m,) bars of the held-out residuals; and the reproducibility."""
    before, after = unseen
    judged, mask = held_out.proof, held_out.mask
    deviations = reproducibility(context.problem, selection.final.fit.residual)
    bars = bar(judged, deviations)
    step, lumping = step_error((after.correction / bars)[mask]), discretisation_error(judged, bars)
    limit = detection_limit(judged, step, bars, mask)
    base = context.base
    final = {**base, **selection.final.fit.parameters(base)}
    evidence = Evidence(
        kinds=[selected.candidate.found(base, final) for selected in selection.effects],
        calibrated=selection.calibrated.excess <= context.detection_limit,
        extrapolated=measure_errors(judged, before.extrapolated, after.extrapolated, mask, bars),
        stated=measure_errors(judged, before.stated, after.stated, mask, bars),
        limit=limit,
        largest=max(LARGEST, lumping),
        beyond=bool(parameters_beyond_range(context.problem, selection.final.fit))
        or not all(selection.final.fit.determines(s.candidate) for s in selection.effects),
        excess=selection.calibrated.excess,
        step=step,
        lumping=lumping,
    )
    return evidence, bars, deviations


def _without_imitation(
    context: SelectionContext,
    selection: Selection,
    held_out: HeldOut,
    after: Unseen,
    bars: FloatArray,
    limit: float,
) -> Selection:
    """The selection without the effect that the held-out data can best do without, if any.

    An effect holds if it explains more of the held-out data than is left unexplained: what explains
    less may stand for a part of that. And it explains more than the limit.
    """
    if len(selection.effects) < 2:
        return selection
    mask = held_out.mask
    left = float(np.mean((after.extrapolated / bars)[mask] ** 2))
    least, imitation = max(limit, left), None
    for selected in selection.effects:
        reduced = context.polish(context.without(selection.final, selected.candidate))
        unseen = held_out.simulate(reduced.fit)
        explained = float(np.mean((unseen.extrapolated / bars)[mask] ** 2)) - left
        if explained < least:
            others = tuple(s for s in selection.effects if s is not selected)
            least, imitation = explained, replace(selection, final=reduced, effects=others)
    return selection if imitation is None else imitation
