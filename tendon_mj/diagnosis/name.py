"""Names what is missing: adds effects one at a time, and tries to do without each again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tendon_mj.diagnosis.contest import (
    SURE,
    Entrant,
    Field,
    Setting,
    difference,
    tie_width,
    tied,
)
from tendon_mj.diagnosis.effects.effect import Candidate

_MOST_EFFECTS = 3
_NEAR = 0.1  # of the gap: when more than this remains, other effects do not lead to the end either
_TURNS = 2
_IN_PLACE = 0.8  # of what the best explains, to be fitted in the place of another


@dataclass(frozen=True, eq=False)
class Named:
    """An effect in the final model, and those that these data can't tell from it.

    Attributes:
        candidate: the effect.
        rivals: others that explain as much in its place, with how much more they leave.
        confidence: that it is this one and not a rival, 0 … 1.
    """

    candidate: Candidate
    rivals: tuple[tuple[Candidate, float], ...]
    confidence: float


@dataclass(frozen=True, eq=False)
class Naming:
    """What came of it.

    Attributes:
        calibrated: the model with only what was uncertain fitted.
        final: the model with what is named.
        named: in the order of how much they explain.
        first: all candidates for the first of them; None where nothing was looked for.
    """

    calibrated: Entrant
    final: Entrant
    named: tuple[Named, ...]
    first: Field | None


class _Grown(NamedTuple):
    """A model, and how it came about.

    Attributes:
        model: the last one.
        fields: for every effect against whom it was chosen.
        first: all candidates for the first.
        turns: at every addition who could have been chosen, the one that left least first.
        smaller: the last model without one of its effects, by label, where that was fitted.
    """

    model: Entrant
    fields: dict[str, list[Entrant]]
    first: Field | None
    turns: list[list[Entrant]]
    smaller: dict[str, Entrant]


def name_effects(setting: Setting, calibrated: Entrant) -> Naming:
    """Add what helps beyond chance until nothing does.

    After each addition every effect already there is tried to be left out, and at the end every
    other candidate is tried in the place of each: an early choice may have imitated two effects.
    """
    whole = max(calibrated.gap, 0.0)
    grown = _grow(setting, calibrated, {}, whole)
    first, turns = grown.first, grown.turns
    if not grown.model.fit.effects:
        calibrated = grown.model  # fitted on, where an effect was left out again
    if setting.least < grown.model.gap < _NEAR * whole:
        grown = _turn_back(setting, grown, turns, whole)
    model, fields = grown.model, grown.fields
    if len(model.fit.effects) > 1 and model.gap < _NEAR * whole:
        model, fields = _exchange(setting, grown)
    named = [_judge(candidate, model, fields[candidate.label]) for candidate in model.fit.effects]
    return Naming(calibrated, model, tuple(named), first)


def _grow(
    setting: Setting, model: Entrant, known: Mapping[str, list[Entrant]], whole: float
) -> _Grown:
    """Add effects to a model until nothing helps, or what was added is left out again."""
    fields, first, turns = dict(known), None, list[list[Entrant]]()
    smaller = dict[str, Entrant]()
    seen = set[frozenset[str]]()
    while len(model.fit.effects) < _MOST_EFFECTS and model.gap > setting.least:
        labels = frozenset(effect.label for effect in model.fit.effects)
        if labels in seen:
            break
        seen.add(labels)
        field = setting.rivals(model)
        first, rivals = first or field, list(field.entrants)
        if not rivals or not setting.helps(model, rivals[0], whole):
            break
        turns.append(rivals)
        chosen = setting.settle(_simplest(rivals), whole)
        assert chosen.candidate is not None
        fields[chosen.candidate.label] = rivals
        fields = _with(fields, chosen)
        model, smaller = _without_idle(setting, chosen, whole)
    return _Grown(model, fields, first, turns, smaller)


def _turn_back(
    setting: Setting, grown: _Grown, turns: Sequence[list[Entrant]], whole: float
) -> _Grown:
    """Take the second best at one of the turns, where the best led near and not to the end."""
    best = grown
    for turn in range(min(len(turns), _TURNS) - 1, -1, -1):
        rivals = turns[turn]
        if len(rivals) < 2 or best.model.gap <= setting.least:
            continue
        other = rivals[1]
        assert other.candidate is not None
        known = {**grown.fields, other.candidate.label: rivals}
        again = _grow(setting, setting.polish(other), known, whole)
        if setting.helps(best.model, again.model, whole):
            best = again
    return best


def _with(fields: Mapping[str, list[Entrant]], better: Entrant) -> dict[str, list[Entrant]]:
    """The same fields of rivals with a better fit of one of them."""
    assert better.candidate is not None
    label = better.candidate.label
    others = [rival for rival in fields[label] if rival.candidate != better.candidate]
    return {**fields, label: sorted([better, *others], key=lambda rival: rival.gap)}


def _simplest(rivals: Sequence[Entrant]) -> Entrant:
    """Of those not told from the best: a number before an effect, few terms before many."""
    equal = [entrant for entrant in rivals if tied(rivals[0], entrant)]
    return min(equal, key=lambda entrant: (_complexity(entrant.candidate), entrant.gap))


def _complexity(candidate: Candidate | None) -> tuple[bool, int]:
    return (False, 0) if candidate is None else (candidate.kind == "missing", len(candidate.terms))


def _without_idle(
    setting: Setting, model: Entrant, whole: float
) -> tuple[Entrant, dict[str, Entrant]]:
    """Leave out effects without which a fit from here does as well; and see `_Grown.smaller`."""
    smaller = dict[str, Entrant]()
    for candidate in model.fit.effects:
        smaller[candidate.label] = setting.without(model, candidate)
        if not setting.helps(smaller[candidate.label], model, whole):
            return _without_idle(setting, smaller[candidate.label], whole)
    return model, smaller


def _exchange(setting: Setting, grown: _Grown) -> tuple[Entrant, dict[str, list[Entrant]]]:
    """Try every other candidate in the place of each effect; keep what leaves less.

    For the last effect that was done when it was added, unless one before it was replaced.
    """
    fields: dict[str, list[Entrant]] = {}
    model = grown.model
    for candidate in model.fit.effects:
        if model is grown.model and candidate == model.candidate:
            rivals = grown.fields[candidate.label]
        else:
            smaller = grown.smaller.get(candidate.label) if model is grown.model else None
            smaller = smaller or setting.without(model, candidate)
            rivals = list(setting.rivals(smaller, _IN_PLACE).entrants)
        best = next((r for r in rivals if r.candidate == candidate), None)
        if best is None or best.gap > model.gap:
            best = Entrant(candidate, model.fit, model.leftover)
        field = sorted(
            [best, *(r for r in rivals if r.candidate != candidate)], key=lambda r: r.gap
        )
        chosen = _simplest(field)
        if chosen.candidate != candidate and not tied(chosen, best):
            model = chosen
        assert chosen.candidate is not None
        final = chosen.candidate if model is chosen else candidate
        fields[final.label] = field
    return model, fields


def _judge(candidate: Candidate, model: Entrant, field: Sequence[Entrant]) -> Named:
    """Rivals of an effect of the final model, and the odds against them."""
    own = next((e for e in field if e.candidate == candidate), field[0])
    rivals, odds = [], 1.0
    for entrant in field:
        other = entrant.candidate
        if other is None or other == candidate:
            continue
        more = difference(own, entrant)
        if len(other.terms) > len(candidate.terms) and more.mean > -SURE * more.error:
            continue  # more freedom, and no use for it
        width = max(more.error, tie_width(own))
        if other.identifier != candidate.identifier:
            odds += float(np.exp(-max(more.mean, 0.0) / width))
        if tied(own, entrant):
            rivals.append((other, more.mean))
    return Named(candidate, tuple(rivals), 1.0 / odds)
