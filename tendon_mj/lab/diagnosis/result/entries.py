"""Entries of a result: findings, ranking and fitted values, from a selection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Effect, Term
from tendon_mj.lab.diagnosis.model_selection.confidence import SelectedEffect
from tendon_mj.lab.diagnosis.model_selection.fit import Fit
from tendon_mj.lab.diagnosis.model_selection.intervals import beyond_range, intervals
from tendon_mj.lab.diagnosis.model_selection.select import Selection
from tendon_mj.lab.diagnosis.result.diagnosis import Finding, Value
from tendon_mj.lab.diagnosis.result.ranked import Ranked
from tendon_mj.lab.diagnosis.result.statement import state_finding
from tendon_mj.lab.replay import Parameter, parameter_of, value_in

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
