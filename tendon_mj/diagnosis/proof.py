"""Proof on held-out data: from the models of a selection to a verdict."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping

import numpy as np

from tendon_mj.diagnosis.data.problem import Problem
from tendon_mj.diagnosis.data.step_size import step_error, with_step
from tendon_mj.diagnosis.effects.effect import Effect
from tendon_mj.diagnosis.locate import locate
from tendon_mj.diagnosis.model_selection.context import SelectionContext
from tendon_mj.diagnosis.model_selection.fit import Fit
from tendon_mj.diagnosis.model_selection.select import Selection
from tendon_mj.diagnosis.model_selection.thresholds import (
    detection_limit,
    discretisation_error,
)
from tendon_mj.diagnosis.result.diagnosis import Diagnosis
from tendon_mj.diagnosis.result.entries import (
    finding,
    fitted_values,
    parameters_beyond_range,
    ranking,
)
from tendon_mj.diagnosis.result.error_reduction import ErrorReduction, measure_errors
from tendon_mj.diagnosis.result.sentence import state, warn_of_ends
from tendon_mj.diagnosis.verdict import decide

LARGEST = 8.0  # excess χ² (3 noise rms), above which a model is not proven whatever it explains


def prove(
    context: SelectionContext,
    selection: Selection,
    own: Problem,
    proof: Problem,
    step: float | None,
    catalogue: Mapping[str, Effect],
    excluded: Collection[str],
    began: float,
) -> Diagnosis:
    """Simulate the held-out data with the models of a selection, and decide.

    The decision rests on extrapolated errors; stated are those that a replay with the model's own
    step finds.

    Args:
        context, selection: training data, and the models selected on it.
        own: training data with the model's own step.
        proof: held-out recordings, likewise; ``own`` where only tails are held out.
        step: of the selection, see `with_step`.
        catalogue: identifier → effect, of all that could have been named.
        excluded: identifiers of effects that were not considered.
        began: start of the diagnosis (`time.perf_counter`) [s].
    """
    problem, base, held_out = context.problem, context.base, proof is not own
    mask = np.ones(proof.in_train.size, bool) if held_out else ~own.in_train
    fits = selection.calibrated.fit, selection.final.fit
    sets = [fitted.parameters(base) for fitted in fits]
    extrapolated, bounds = _extrapolate(problem, proof if held_out else None, step, fits, base)
    seen = own.residuals(sets)
    unseen = proof.residuals(sets) if held_out else seen
    stated = measure_errors(proof, unseen[0], unseen[1], mask)
    beyond = parameters_beyond_range(problem, fits[1])
    verdict = decide(context, selection, extrapolated, stated, bounds, bool(beyond))

    findings = tuple(finding(selected, catalogue) for selected in selection.effects)
    non_smooth = any(selected.candidate.non_smooth for selected in selection.effects)
    excluded = sorted(excluded)
    found = verdict in ("named", "parameter")
    after = 1 if found else 0
    calibrated = fitted_values(problem, base, fits[after], calibrated=True)
    sentence = state(
        verdict, findings, stated, extrapolated.after, bounds[0], beyond, excluded, non_smooth
    )
    return Diagnosis(
        verdict=verdict,
        sentence=sentence + warn_of_ends(calibrated),
        findings=findings if found else (),
        closest=() if found else tuple(f.identifier for f in findings),
        excluded=tuple(excluded),
        ranking=ranking(selection, problem.in_train),
        calibrated=calibrated,
        parameters=fitted_values(problem, base, fits[after], calibrated=False),
        train=measure_errors(own, seen[0], seen[after], own.in_train),
        held_out=measure_errors(proof, unseen[0], unseen[after], mask),
        located=locate(own, seen[0], own.in_train),  # the held-out tails are left unseen
        remaining=locate(own, seen[after], own.in_train),
        proof=(locate(proof, unseen[0], mask), locate(proof, unseen[after], mask)),
        before={**base, **sets[0]},
        model={**base, **sets[after]},
        seconds=time.perf_counter() - began,
        catalogue=catalogue,
        simulator=proof.simulate,
        recordings=own.recordings,
        held_out_recordings=proof.recordings if held_out else (),
    )


def _extrapolate(
    problem: Problem,
    proof: Problem | None,
    step: float | None,
    fits: tuple[Fit, Fit],
    base: Mapping[str, float],
) -> tuple[ErrorReduction, tuple[float, float]]:
    """Errors on held-out data for a step of zero, and the bounds of `decide`."""
    if proof is None:
        judged, mask = problem, ~problem.in_train
        residuals, correction = (fits[0].residual, fits[1].residual), fits[1].correction
    else:
        judged, mask = with_step(proof, step), np.ones(proof.in_train.size, bool)
        sets = [fitted.parameters(base) for fitted in fits]
        coarse = judged.residuals(sets)
        residuals = judged.extrapolate(sets[0], coarse[0]), judged.extrapolate(sets[1], coarse[1])
        correction = residuals[1] - coarse[1]
    limit = detection_limit(judged, step_error(correction[mask]))
    largest = max(LARGEST, discretisation_error(judged))
    return measure_errors(judged, residuals[0], residuals[1], mask), (limit, largest)
