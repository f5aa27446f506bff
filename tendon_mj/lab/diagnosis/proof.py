"""Proof on held-out data: from the models of a selection to a verdict.

Entries of a result: findings, ranking and fitted values, from a selection.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.diagnosis.data import Problem, spreads, step_error
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, Term
from tendon_mj.lab.diagnosis.evidence import LARGEST, Evidence, decide, measure_errors
from tendon_mj.lab.diagnosis.fitting import Fit
from tendon_mj.lab.diagnosis.held_out import HeldOut, Unseen
from tendon_mj.lab.diagnosis.model_faults import (
    too_few_guides,
    warn_of_guides,
    warn_of_soft_flanks,
    warn_of_soft_friction,
)
from tendon_mj.lab.diagnosis.regimes import locate
from tendon_mj.lab.diagnosis.result import Diagnosis, Finding, Ranked, Value
from tendon_mj.lab.diagnosis.selection import Selection, SelectionContext
from tendon_mj.lab.diagnosis.statistics import SelectedEffect, beyond_range, intervals
from tendon_mj.lab.diagnosis.thresholds import (
    bar,
    detection_limit,
    discretisation_error,
    has_sheath,
    reproducibility,
)
from tendon_mj.lab.diagnosis.wording import (
    ABOVE_NOISE,
    Statement,
    state,
    state_finding,
    warn_of_ends,
    warn_of_step_and_noise,
)
from tendon_mj.lab.replay import Parameter, parameter_of, value_in
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


_EXPLAINS = 0.01  # of the excess χ², to be in the ranking
# A calibrated value this near to an end is held by it: a hundredth of the range, or, in a range of
# decades, of what would be the range about its guess.
_MARGIN = 0.2  # of a probe


def finding(
    selected: SelectedEffect,
    catalogue: Mapping[str, Effect],
    parameters: Mapping[str, Parameter],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> Finding:
    """Finding of a selected effect; its rivals are other effects, or the same one elsewhere.

    Args:
        selected: effect of the final model.
        catalogue: identifier → effect.
        parameters: of the simulator.
        before, after: parameter → value of the model, and as fitted.
    """
    effect, rivals = catalogue[selected.candidate.identifier], selected.rivals
    candidate = selected.candidate
    return Finding(
        identifier=effect.identifier,
        name=effect.name,
        equation=effect.equation,
        where=candidate.where,
        kind="parameter" if candidate.in_model(before) else candidate.kind,
        statement=state_finding(effect, candidate, parameters, before, after),
        parameter=candidate.terms[0].targets[0],
        recording=candidate.recording,
        confidence=selected.confidence,
        rivals=tuple(
            dict.fromkeys(r.identifier for r in rivals if r.identifier != effect.identifier)
        ),
        elsewhere=tuple(r.where for r in rivals if r.identifier == effect.identifier),
    )


def ranking(selection: Selection, in_train: NDArray[np.bool_]) -> tuple[Ranked, ...]:
    """Rank the candidates for the first effect: fitted ones by their error, others by screening."""
    if selection.first is None:
        return ()
    excess = float(np.mean(selection.calibrated.fit.residual[in_train] ** 2)) - 1.0
    first = selection.first
    left, ends = dict[str, float](), dict[str, tuple[float, str]]()
    for model in (*first.fitted, *first.at_end):
        candidate = model.candidate
        if candidate is not None:
            left[candidate.label] = float(np.sqrt(max(1.0 + model.excess, 0.0)))
            if model in first.at_end:
                ends[candidate.label] = _nearest_end(model.fit, candidate)
    ranked: dict[str, Ranked] = {}
    for score in first.scores:
        candidate, share = score.candidate, min(score.explained / excess, 1.0)
        if share >= _EXPLAINS:
            label = candidate.label
            end, unit = ends.get(label, (None, ""))
            row = Ranked(candidate.identifier, candidate.where, share, left.get(label), end, unit)
            ranked.setdefault(label, row)
    return tuple(
        sorted(
            ranked.values(),
            key=lambda r: (r.left is None, r.at_end is not None, r.left or 0.0, -r.explains),
        )
    )


def _nearest_end(fit: Fit, candidate: Candidate) -> tuple[float, str]:
    """End of its range at which a candidate's strength stands, and its unit."""
    strength = int(fit.terms_of(candidate).start)
    term, value = fit.terms[strength], float(fit.values[strength])
    nearest = term.high if abs(term.high - value) < abs(term.low - value) else term.low
    return nearest, term.unit


def fitted_values(
    problem: Problem,
    base: Mapping[str, float],
    fit: Fit,
    refits: Sequence[Fit] = (),
    *,
    calibrated: bool,
) -> dict[str, Value]:
    """Fitted parameters with intervals: the calibrated ones, or else those of the effects."""
    written = fit.parameters(base)
    ranges = intervals(problem, fit, refits)
    inside = fit.free & (np.ptp(ranges, axis=1) < [term.high - term.low for term in fit.terms])
    others = [fit.parameters(base, np.where(inside, end, fit.values)) for end in ranges.T]
    first = len(fit.calibrated)
    values = {}
    for k, term in enumerate(fit.terms):
        if (k < first) != calibrated or term.spread > 0.0:
            continue
        at_end = calibrated and not _clear_of_ends(fit.values[k], term)
        narrower = bool(ranges[k][0] > term.low or ranges[k][1] < term.high)
        determined = bool(fit.free[k]) and narrower and not at_end
        span = ranges[k] if determined else (term.low, term.high)
        around = [written, *others] if term.depends_on else [written]
        for target in term.targets:
            ends = [term.write(float(e), {**base, **o})[target] for e in span for o in around]
            unit = problem.simulate.parameters[parameter_of(target)].unit
            before = value_in(base, target)
            values[target] = Value(
                written[target], min(ends), max(ends), unit, before, determined, at_end
            )
        for name, value, low, high in term.beside:
            unit = problem.simulate.parameters[parameter_of(name)].unit
            values[name] = Value(value, low, high, unit, value_in(base, name))
    return values


def parameters_beyond_range(problem: Problem, fit: Fit) -> list[str]:
    """Calibrated parameters that the effects of a fit would take beyond their ranges."""
    count = len(fit.calibrated)
    near = np.array(
        [
            k < count and not term.spread and not _clear_of_ends(value, term)
            for k, (term, value) in enumerate(zip(fit.terms, fit.values, strict=True))
        ],
        dtype=bool,
    )
    if not near.any():
        return []
    beyond = beyond_range(problem, fit, near)
    return [t for k in np.flatnonzero(beyond) for t in fit.terms[k].targets]


def _clear_of_ends(value: float, term: Term) -> bool:
    """Whether a calibrated value lies inside its range; the fit never quite reaches an end.

    In a range of decades twice the low end is far from it.
    """
    margin = _MARGIN * term.probe
    low = min(margin, term.low) if term.low > 0.0 else margin
    return bool(term.low + low < value < term.high - margin)
