"""Models that explain the recordings as well as each other.

Two kinds: an effect and its rivals, each fitted with the rest of the model; and one model at two
values of a number that the recordings do not determine, with everything else fitted to each of them
(the ends of its profile likelihood, Raue et al. 2009, Bioinformatics 25(15)).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis import (
    Candidate,
    Fit,
    FittedCandidate,
    SelectedEffect,
    Selection,
    SelectionContext,
    Term,
    intervals,
    tied,
)
from tendon_mj.typing import FloatArray

_EVALUATIONS = 8  # of a fit from where it is nearly done
_WIDE = 0.5, 5.0  # of the value, and of the probe: an interval wider than both determines little
_SHRUNK = 0.5, 4  # factor on the way to an end of a profile where that is refuted, and tries
_FIXED = 1e-6  # of the way: half the range of a term that a profile holds
_FOLLOWS = 0.5  # of its interval: a number that moves this far along a profile is part of it


@dataclass(frozen=True, eq=False)
class Alternative:
    """A model of the recordings.

    Attributes:
        label: what tells it from the others.
        fit: its terms, and their values.
        held: (p,) which terms make it what it is, and are not fitted to another's data.
    """

    label: str
    fit: Fit
    held: NDArray[np.bool_]


Tie = tuple[Alternative, ...]  # two or more


def find_ties(context: SelectionContext, selection: Selection) -> list[Tie]:
    """Sets of models that the training data cannot tell from each other.

    Of effects with rivals; where none has any, of numbers that are not determined.
    """
    rivals = [_rivals(context, selection.final, effect) for effect in selection.effects]
    return [tie for tie in rivals if tie] or _undetermined(context, selection.final)


def _rivals(context: SelectionContext, final: FittedCandidate, effect: SelectedEffect) -> Tie:
    """An effect and its rivals; none where it has no rival."""
    made = [_alternative(effect.candidate.label, final)] if effect.models else []
    for model in effect.models:
        rival = model.candidate
        assert rival is not None
        effects = tuple(rival if e == effect.candidate else e for e in final.fit.effects)
        own = {e.label: (model if e == rival else final).fit for e in effects}
        start = [
            *final.fit.values[: len(final.fit.calibrated)],
            *(v for e in effects for v in own[e.label].values[own[e.label].terms_of(e)]),
        ]
        if set(effects) == set(model.fit.effects):
            effects, start = model.fit.effects, [*model.fit.values]
        fitted = context.fit_model(effects, start, rival, near=model.fit, evaluations=_EVALUATIONS)
        made.append(_alternative(rival.label, fitted))
    return tuple(made)


def _alternative(label: str, model: FittedCandidate, held: int | None = None) -> Alternative:
    return Alternative(label, model.fit, np.arange(len(model.fit.terms)) == held)


def _undetermined(context: SelectionContext, final: FittedCandidate) -> list[Tie]:
    """The model at both ends of the profile of each number that is not determined by itself."""
    fitted, ties = final.fit, list[Tie]()
    ranges = intervals(context.problem, fitted)
    loose = [k for k in map(int, np.flatnonzero(fitted.shared)) if _is_loose(fitted, k, ranges[k])]
    for k in loose:
        if any(_follows(tie, k, ranges[k]) for tie in ties):
            continue
        ends = [_end_of_profile(context, final, k, float(end)) for end in ranges[k]]
        if ends[0] is not ends[1]:
            ties.append(tuple(_alternative(_at(end.fit, k), end, k) for end in ends))
    return ties


def _is_loose(fitted: Fit, k: int, interval: FloatArray) -> bool:
    term, value = fitted.terms[k], abs(float(fitted.values[k]))
    return bool(interval[1] - interval[0] > max(_WIDE[0] * value, _WIDE[1] * term.probe))


def _follows(tie: Tie, k: int, interval: FloatArray) -> bool:
    """Whether term k moves along with the profile of a tie."""
    moved = abs(float(tie[1].fit.values[k] - tie[0].fit.values[k]))
    return moved > _FOLLOWS * float(interval[1] - interval[0])


def _end_of_profile(
    context: SelectionContext, final: FittedCandidate, k: int, end: float
) -> FittedCandidate:
    """The model fitted with term k held as far towards ``end`` as the data do not refute it."""
    fitted, value = final.fit, float(final.fit.values[k])
    for attempt in range(_SHRUNK[1]):
        at = value + (end - value) * _SHRUNK[0] ** attempt
        half = _FIXED * abs(at - value)
        if half == 0.0:
            break
        start = fitted.values.copy()
        start[k] = at
        terms = [
            replace(term, low=at - half, high=at + half) if j == k else term
            for j, term in enumerate(fitted.terms)
        ]
        calibrated, effects = _split(fitted, terms)
        held = replace(context, calibrated=calibrated).fit_model(
            effects, start, near=fitted, evaluations=_EVALUATIONS
        )
        if tied(final, held):
            return held
    return final


def _split(fitted: Fit, terms: Sequence[Term]) -> tuple[tuple[Term, ...], tuple[Candidate, ...]]:
    """Terms of a fit as those of its calibrated parameters and those of its effects."""
    first = len(fitted.calibrated)
    effects = [replace(e, terms=tuple(terms[fitted.terms_of(e)])) for e in fitted.effects]
    return tuple(terms[:first]), tuple(effects)


def _at(fitted: Fit, k: int) -> str:
    term = fitted.terms[k]
    unit = "" if term.unit in ("", "-") else f" {term.unit}"
    return f"{' = '.join(term.targets)} = {fitted.values[k]:.3g}{unit}"
