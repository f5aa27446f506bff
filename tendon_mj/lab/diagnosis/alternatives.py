"""Alternatives: models with one effect more that explain the data as well, by other numbers.

The interval of a fitted number holds if the model lacks nothing. It does not include what an effect
of the catalogue may take over from the number where the data show little difference. With the
trace of the effect as one more column of the Jacobian, the covariance says how far each number may
then move while the residual stays. If that widens its interval, the effect is added at the far end,
since a trace holds near the fit only, and all values are fitted again. If that model leaves no
more, the number's interval includes its own; if it moves by a part that matters, it is told. So it
is with a model that has the effect in the place of another: it lacks the number of that one.

A number that several elements share in ``[uncertain]`` may differ between them, which looks like an
effect on some of these elements. In place of such effects each element gets a number of its own.

Only effects of the rig that the model lacks are added. Effects that change a coefficient of
friction, as static friction does, define that number. Numbers that the model has, and the
calibration of the sensors, are taken as stated: a number that may be wrong is called uncertain.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate, element
from tendon_mj.lab.diagnosis.fitting import Fit, bounded_least_squares, natural_in_range
from tendon_mj.lab.diagnosis.proof import fitted_values, is_narrower
from tendon_mj.lab.diagnosis.result import Alternative, Diagnosis, Value
from tendon_mj.lab.diagnosis.search import starts
from tendon_mj.lab.diagnosis.selection import CONVERGED, Selection, SelectionContext
from tendon_mj.lab.diagnosis.statistics import (
    FittedCandidate,
    at_rest_on_bounds,
    intervals,
    on_bounds,
    sides,
    tie_width,
    with_slope,
)
from tendon_mj.lab.diagnosis.wording import NOTHING, UNDECIDED, state_alternatives, state_finding
from tendon_mj.typing import FloatArray

MATTERS: Final = 0.2  # of a number: if an end of its interval moves by that, an alternative is told
WIDENS: Final = 0.05  # of a number: by that an interval is widened
_EACH = "write each = true for them in [uncertain]"
_FARTHEST = 1e3  # probes from which an effect is fitted that the data do not determine at all
_EVALUATIONS = 12


@dataclass(frozen=True, eq=False)
class _Valley:
    """Values that leave nearly the same residual, with one more effect."""

    candidate: Candidate
    start: FloatArray  # (p + its terms,) the far end [the terms' units]
    ranges: FloatArray  # (p, 2) intervals of the model's terms [their units]


def with_alternatives(result: Diagnosis) -> Diagnosis:
    """The result, with intervals that include those of its alternatives.

    A finding that may be absent in an alternative has its effect as a rival. The verdict is
    "undetermined" if nothing was found, or each finding has such a new rival. A number of which the
    data tell nothing, see `is_narrower`, is an alternative to itself. "Unknown" stays, with numbers
    of each element as the way out.
    """
    if result.search is None:
        return result
    context, selection = result.search
    model, problem, base = selection.final, context.problem, context.base
    each = _number_of_each(context, model)
    if result.verdict == "unknown":
        told = [f"No more is left with {each[0]}: {_EACH}."] if each else []
        sentence = " ".join([result.sentence, *told])
        return replace(result, sentence=sentence, warnings=(*result.warnings, *told))
    fit, values = model.fit, {**result.calibrated, **result.parameters}
    stated = np.where(
        fit.free[:, None], intervals(problem, fit, moving=fit.free), fit.values[:, None]
    )
    untold = _untold(problem, fit)
    numbers = [k for k in _numbers(fit) if k not in untold]
    names = [name for k in untold for name in fit.terms[k].targets]
    far = {name: _far_end(values[name], values[name]) for name in names}
    found = [Alternative("", "the other numbers fitted anew", far)] if far else []
    found += _at_ends(problem, fit, values)
    replaced = frozenset[str]()
    if each:
        words, own = each
        there, _ = fitted_values(problem, base, own, intervals(problem, own))
        shared = [name for t in fit.calibrated if len(t.targets) > 1 for name in t.targets]
        moved = [n for n in shared if _differ(values[n], there[n])] or shared
        best = {n: there[n].value for n in moved}
        found.append(Alternative("", words, best, fitted=True, decided_by=_EACH))
        values |= {n: _joined(values[n], there[n]) for n in shared}
        replaced = frozenset(e.terms[0].targets[0] for e in fit.effects if e not in own.effects)
    rivals: dict[str, list[str]] = {finding.parameter: [] for finding in result.findings}
    for other in (*_tied(selection), *_fits_elsewhere(context, model, numbers, stated)):
        (added,) = (effect for effect in other.effects if effect not in fit.effects)
        ranges = intervals(problem, other)
        calibrated, of_effects = fitted_values(problem, base, other, ranges)
        there = {**_absent(fit, other, values), **calibrated, **of_effects}
        moved = [
            name
            for k in numbers
            if there.keys() >= set(fit.terms[k].targets)
            if other.free[k] or fit.free[k]
            if _shift(stated[k], ranges[k], fit.values[k]) > MATTERS
            for name in fit.terms[k].targets
        ]
        for parameter, names in rivals.items():
            if parameter in there and _includes(there[parameter], values[parameter].before):
                names.append(added.identifier)
                moved = list(dict.fromkeys([*moved, parameter]))
        if moved and added.identifier not in {one.identifier for one in found}:
            after = {**base, **other.parameters(base)}
            words = state_finding(added, problem.simulate.parameters, base, after)
            pairs = {n: (values[n], there[n]) for n in moved}
            found.append(replace(_alternative(added, words, pairs), fit=other))
        values |= {n: _joined(v, there[n]) for n, v in values.items() if n in there}
        stated[:, 0] = np.minimum(stated[:, 0], ranges[: len(stated), 0])
        stated[:, 1] = np.maximum(stated[:, 1], ranges[: len(stated), 1])
    return _restated(result, values, found, rivals, replaced)


def _number_of_each(context: SelectionContext, model: FittedCandidate) -> tuple[str, Fit] | None:
    """The model with numbers of each element in place of shared ones, and what they are in words.

    Without the effects on some of these elements alone; None if there are none, or it leaves more.
    """
    fitted, used = model.fit, context.problem.in_train
    shared = [term for term in fitted.calibrated if len(term.targets) > 1]
    groups = [frozenset(map(element, term.targets)) for term in shared]
    kept = [e for e in fitted.effects if not any({*map(element, e.targets)} < g for g in groups)]
    if len(kept) == len(fitted.effects):
        return None
    counts = [len(term.targets) for term in fitted.calibrated]
    start = [*np.repeat(fitted.values[: len(counts)], counts)]
    start += [value for e in kept for value in fitted.values[fitted.terms_of(e)]]
    terms = tuple(replace(t, targets=(name,)) for t in fitted.calibrated for name in t.targets)
    context = replace(context, calibrated=terms)
    own = context.fit_model(kept, start, near=fitted, evaluations=CONVERGED).fit
    if np.mean(own.residual[used] ** 2) - np.mean(fitted.residual[used] ** 2) > tie_width(model):
        return None
    kinds = ", ".join(dict.fromkeys(t.targets[0].rpartition(".")[2] for t in shared))
    elements = " and ".join(sorted(frozenset[str]().union(*groups)))
    return f"{kinds} of its own on each of {elements}", own


def _numbers(fit: Fit) -> list[int]:
    """Positions of the values of which a share is defined: none of either sign, none at 0."""
    strengths = {fit.terms_of(candidate).start for candidate in fit.effects}
    named = [k for k in range(len(fit.terms)) if k < len(fit.calibrated) or k in strengths]
    movable = fit.free | on_bounds(fit)
    return [
        k
        for k in named
        if movable[k] and fit.shared[k] and fit.terms[k].low >= 0.0
        if fit.free[k] or fit.values[k] > fit.terms[k].probe
    ]


def _tied(selection: Selection) -> Iterator[Fit]:
    """Fits of rivals in the place of a single effect, which leave as little."""
    if len(selection.effects) == 1:
        fits = (model.fit for model in selection.effects[0].models)
        yield from (fit for fit in fits if len(fit.effects) == 1)


def _absent(fit: Fit, other: Fit, values: Mapping[str, Value]) -> dict[str, Value]:
    """Numbers of the effects that another fit does without, as the model has them before."""
    names = {n for e in fit.effects if e not in other.effects for t in e.terms for n in t.targets}
    given = {name: values[name] for name in names & values.keys()}
    return {n: replace(v, value=v.before, low=v.before, high=v.before) for n, v in given.items()}


def _untold(problem: Problem, fit: Fit) -> list[int]:
    """Positions of the numbers of which the data tell nothing, see `is_narrower`."""
    spans = _ranges(fit, sides(problem, fit, fit.free | on_bounds(fit)))
    return [k for k in _numbers(fit) if not is_narrower(np.sort(spans[k]), fit.terms[k])]


def _at_ends(problem: Problem, fit: Fit, values: Mapping[str, Value]) -> list[Alternative]:
    """Numbers that trade places with others, which rest at an end of their range."""
    held = at_rest_on_bounds(problem, fit)
    moved, together = dict[str, float](), sides(problem, fit, fit.free | held).max(axis=0)
    for k in (k for k in _numbers(fit) if fit.free[k] or held[k]):
        alone = sides(problem, fit, fit.free | (np.arange(held.size) == k))[:, k].max()
        widths = np.minimum([alone, together[k]], np.ptp(fit.bounds[:, k])) * fit.terms[k].probe
        if widths[1] - widths[0] > MATTERS * abs(fit.values[k]):
            moved |= {name: _far_end(values[name], values[name]) for name in fit.terms[k].targets}
    others = " and ".join(fit.terms[k].targets[0] for k in np.flatnonzero(held))
    return [Alternative("", f"another {others}", moved)] if moved else []


def _alternative(
    added: Candidate, words: str, pairs: Mapping[str, tuple[Value, Value]]
) -> Alternative:
    """An alternative as it fits best, or at the far end of its intervals if that is no other.

    ``words`` state the effect as it fits best, ``pairs`` are values of the model and of this one.
    """
    if any(_differ(here, there) for here, there in pairs.values()):
        best = {name: there.value for name, (_, there) in pairs.items()}
        return Alternative(added.identifier, words, best, fitted=True)
    far = {name: _far_end(here, there) for name, (here, there) in pairs.items()}
    return Alternative(added.identifier, f"{added.effect.name} ({added.where})", far)


def _differ(here: Value, there: Value) -> bool:
    return abs(there.value - here.value) > MATTERS * abs(here.value)


def _far_end(here: Value, there: Value) -> float:
    """End of the second value's interval that is farther from the first value."""
    return max(there.low, there.high, key=lambda end: abs(end - here.value))


def _includes(value: Value, number: float) -> bool:
    return value.low <= number <= value.high


def _ranges(fit: Fit, reach: FloatArray) -> FloatArray:
    """(p, 2) values of a fit's terms that far below and above."""
    scaled = fit.scaled + np.array([[-1.0], [1.0]]) * reach[:, : fit.scaled.size]
    return np.column_stack([natural_in_range(fit.terms, side) for side in scaled])


def _fits_elsewhere(
    context: SelectionContext, model: FittedCandidate, numbers: Sequence[int], stated: FloatArray
) -> Iterator[Fit]:
    """Fits with one more effect that leave as little as a model, from the far ends of valleys.

    Of effects that promise to widen an interval beyond those ``stated``, which may grow meanwhile.
    """
    fit, used = model.fit, context.problem.in_train
    farthest: dict[str, tuple[float, _Valley]] = {}

    def shift(valley: _Valley) -> float:
        return max(_shift(stated[k], valley.ranges[k], fit.values[k]) for k in numbers)

    for valley in _valleys(context, model) if numbers else ():
        if shift(valley) > farthest.get(valley.candidate.identifier, (WIDENS,))[0]:
            farthest[valley.candidate.identifier] = shift(valley), valley
    for _, valley in sorted(farthest.values(), key=lambda pair: -pair[0]):
        if not shift(valley) > WIDENS:  # by now
            continue
        other = context.fit_model(
            (*fit.effects, valley.candidate),
            valley.start,
            valley.candidate,
            near=fit,
            evaluations=_EVALUATIONS,
        ).fit
        more = np.mean(other.residual[used] ** 2) - np.mean(fit.residual[used] ** 2)
        if more <= tie_width(model):
            yield other


def _valleys(context: SelectionContext, model: FittedCandidate) -> Iterator[_Valley]:
    """Valleys of the effects that the model may lack, in the linearisation about its fit."""
    fit, problem = model.fit, context.problem
    used, moving = problem.in_train, np.append(fit.free | on_bounds(fit), True)
    candidates = [
        c
        for c in context.further(model)
        if c.effect.kind == "missing" and not c.in_model(context.base)
        if not (c.effect.changes or c.on_sensor)
    ]
    slopes = context.slopes_at(model, candidates)
    for candidate in candidates:
        strength = candidate.terms[0]
        for score in starts(fit, candidate):
            if score.key not in slopes:
                continue
            slope = slopes[score.key]
            extended = with_slope(fit, candidate, slope)
            reach = sides(problem, extended, moving)
            farthest = np.minimum(reach[:, -1], _FARTHEST) * (-1.0, 1.0)
            end = max(np.clip(farthest[::-1], *extended.bounds[:, -1]), key=abs)
            bounds = fit.bounds - fit.scaled
            step = bounded_least_squares(fit.jacobian[used], slope[used] * end, bounds)
            near = natural_in_range(fit.terms, fit.scaled + step)
            shape = score.start[len(step) + 1 :]
            start = np.array([*near, strength.natural(float(end)), *shape])
            yield _Valley(candidate, start, _ranges(fit, reach))


def _shift(stated: FloatArray, other: FloatArray, value: float) -> float:
    """How far the second of two intervals goes beyond the first, as a share of a value."""
    beyond = max(stated[0] - other[0], other[1] - stated[1])
    return float(beyond / max(abs(value), np.finfo(float).tiny))


def _joined(one: Value, other: Value) -> Value:
    """The first value with an interval that includes the other one's."""
    low, high = min(one.low, other.low), max(one.high, other.high)
    return replace(one, low=low, high=high, determined=one.determined and other.determined)


def _restated(
    result: Diagnosis,
    values: Mapping[str, Value],
    found: Sequence[Alternative],
    rivals: Mapping[str, Sequence[str]],
    replaced: Collection[str],
) -> Diagnosis:
    """The result with wider intervals, and with the alternatives in its verdict and words.

    ``replaced`` are parameters of the findings that an alternative does without.
    """
    result = replace(
        result,
        calibrated={name: values[name] for name in result.calibrated},
        parameters={name: values[name] for name in result.parameters},
    )
    if not found:
        return result
    findings = []
    for finding in result.findings:
        all_rivals = tuple(dict.fromkeys((*finding.rivals, *rivals[finding.parameter])))
        new = len(all_rivals) - len(finding.rivals) + (finding.parameter in replaced)
        confidence = finding.confidence / (1.0 + new * finding.confidence)
        findings.append(replace(finding, rivals=all_rivals, confidence=confidence))
    found = sorted(found, key=lambda alternative: not alternative.fitted)
    told, sentence = state_alternatives(result, found), result.sentence.removeprefix(NOTHING)
    kept = any(
        new.confidence == old.confidence for new, old in zip(findings, result.findings, strict=True)
    )
    if kept or not findings:
        rest = f"{sentence[:1].upper()}{sentence[1:]}"
    else:
        rest = f"{UNDECIDED}{sentence[:1].lower()}{sentence[1:]}"
    return replace(
        result,
        verdict=result.verdict if kept else "undetermined",
        sentence=f"{told} {rest}",
        findings=tuple(findings),
        alternatives=tuple(found),
        warnings=(told, *result.warnings) if kept else result.warnings,
    )
