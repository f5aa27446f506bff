"""Selection of the effects that a model lacks: forward, backtracking, swap step, elimination."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Term
from tendon_mj.lab.diagnosis.events import find_events
from tendon_mj.lab.diagnosis.fitting import Fit, fit, fit_without
from tendon_mj.lab.diagnosis.limits import (
    SMALLEST_EXCESS,
    STANDARD_ERRORS,
    detection_limit,
    least_share,
    unexplained_excess,
)
from tendon_mj.lab.diagnosis.search import ScreeningScore, Slopes, descend, screen
from tendon_mj.lab.diagnosis.statistics import (
    FittedCandidate,
    SelectedEffect,
    cross_validate,
    gain,
    is_wrong_number,
    rate_effect,
    simplest,
    tied,
)
from tendon_mj.lab.progress import Progress
from tendon_mj.typing import FloatArray

CONVERGED = 25  # evaluations: enough for a fit to converge
_NEAR = 5  # evaluations: enough from where screening has led
_MOST_FITS, _MOST_LOOKED_AT = 4, 10
_PROMISING = 0.6  # of the reduction by the best candidate, to be fitted
_SWAP_SHARE = 0.8  # likewise, to be fitted in the place of another
_LOOKED_AT = 0.05  # of it by a slope, to be simulated where others down the list may be fitted
_LEAST = 0.03, 0.3  # likewise, if none of those explains enough; on a sensor
_EVENT = 0.1  # of the excess, that an event explains by its scan, to be located
_EXPLAINS = 0.75  # of the excess may be left by a further effect, for no others to be looked at
_LITTLE = 0.1  # of the initial excess: where more remains, other choices do not help either
_HALFWAY, _MOST_POLISHED = 0.5, 3  # of the smallest gain, for a fit to be continued; fits
_ROUNDS = 2  # in which the second-best choice is tried too
_MOST_EFFECTS = 3


@dataclass(frozen=True, eq=False)
class CandidateSet:
    """Candidates for one more effect."""

    scores: tuple[ScreeningScore, ...]  # of all that change a residual, best first
    # fitted candidates of which the data determine the strength, best first
    fitted: tuple[FittedCandidate, ...]
    # those that were fitted and ended at an end of their range, best first
    at_end: tuple[FittedCandidate, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class SelectionContext:
    """Everything that stays the same during a selection."""

    problem: Problem  # data
    base: Mapping[str, float]  # parameter → value of the model
    calibrated: tuple[Term, ...]  # terms of the uncertain parameters
    candidates: tuple[Candidate, ...]  # catalogue on this model
    step_error: float  # of the simulation, see step_error
    initial_excess: float  # excess χ² of the calibrated model, see reducible_excess
    progress: Progress  # callback
    residual: FloatArray | None = None  # (m,) of the calibrated model [noise]
    # fits, and slopes of candidates there, for the first pass of screenings at fits like them
    slopes: list[tuple[Fit, Slopes]] = field(default_factory=list)
    # fits without one of the effects of a fit, likewise
    reduced: dict[tuple[Fit, Candidate], FittedCandidate] = field(default_factory=dict)

    def fit_model(
        self,
        effects: Sequence[Candidate],
        start: Sequence[float] | np.ndarray,
        candidate: Candidate | None = None,
        *,
        near: Fit | None = None,
        jacobian: FloatArray | None = None,
        seen: FloatArray | None = None,
        evaluations: int = _NEAR,
    ) -> FittedCandidate:
        """Fit a model with these effects from ``start``; ``near`` is a fit not far from there.

        ``jacobian`` and ``seen`` are what is known at ``start``, see `fit`.
        """
        fitted = fit(
            self.problem,
            self.base,
            self.calibrated,
            effects,
            np.asarray(start, float),
            correction=None if near is None else near.correction,
            jacobian=jacobian,
            seen=seen,
            evaluations=evaluations,
        )

        def refit(left_out: int) -> Fit:
            return fit_without(self.problem, self.base, fitted, left_out)

        return FittedCandidate(candidate, fitted, cross_validate(self.problem, fitted, refit))

    def extend(
        self, model: FittedCandidate, share: float = _PROMISING, *, look_down: bool = True
    ) -> CandidateSet:
        """Screen all candidates for one more effect, and fit the best.

        Fitted are those with a screened reduction of χ² of at least ``share`` of the best; and
        with ``look_down`` others down the list, until one of which the data determine the strength
        leaves less than three quarters of the excess; as the first effect, next to nothing.
        Screening is linear, and may see little of an effect that trades places with terms of the
        model.
        """
        half = 0.5 * share  # a slope may promise half of what there is
        kept = (_LOOKED_AT if look_down else half, half)
        scores = self._screen(model, self.further(model), kept)
        if events := self._events(model, half * scores[0].explained if scores else 0.0):
            scores = sorted(scores + self._screen(model, events, kept), key=lambda s: -s.explained)
        shortlist, others_down = _promising(scores, share)
        fitted = list[FittedCandidate]()
        for k, score in enumerate(shortlist + others_down * look_down):
            if k >= len(shortlist) and any(self._explains(model, other) for other in fitted):
                break
            self.progress("fit", min(k, len(shortlist)), len(shortlist))
            extended = self.fit_model(
                (*model.fit.effects, score.candidate),
                score.start,
                score.candidate,
                near=model.fit,
                jacobian=score.jacobian(model.fit),
                seen=score.seen,
            )
            fitted.append(extended)
        if shortlist:
            self.progress("fit", len(shortlist), len(shortlist))
        return CandidateSet(tuple(scores), *_best_of_each(fitted))

    def further(self, model: FittedCandidate) -> list[Candidate]:
        """Candidates that may be added to a model, but events."""
        values = {**self.base, **model.fit.parameters(self.base)}
        return [
            c
            for c in self.candidates
            if not c.targets & model.fit.targets and c.acts_on(values) and not c.effect.event
        ]

    def slopes_at(self, model: FittedCandidate, candidates: Sequence[Candidate]) -> Slopes:
        """Slopes of candidates at a fit, but of those that left no trace at others."""
        found = [slope for _, known in self.slopes for slope in known.items()]
        traced = {label for (label, _), slope in found if slope.any()}
        traceless = {label for (label, _), _ in found} - traced
        candidates = [c for c in candidates if c.label not in traceless]
        slopes: Slopes = {}
        screen(self.problem, self.base, model.fit, candidates, self.progress, slopes, ())
        return {key: slope for key, slope in slopes.items() if slope.any()}

    def _events(self, model: FittedCandidate, least: float) -> list[Candidate]:
        """Events that explain enough of a model's misfit, and ``least`` of the reduced χ²."""
        least = max(0.5 * self.smallest_gain, _EVENT * model.excess, least)
        events = [candidate for candidate in self.candidates if candidate.effect.event]
        return find_events(self.problem, self.base, model.fit, events, model.fit.targets, least)

    def _screen(
        self, model: FittedCandidate, candidates: Sequence[Candidate], kept: tuple[float, float]
    ) -> list[ScreeningScore]:
        known = self.problem, self.base, model.fit
        return screen(*known, candidates, self.progress, self._slopes_near(model.fit), kept)

    def _slopes_near(self, fitted: Fit) -> Slopes:
        """Slopes that are known at the last fit where the response was like that of a fit."""
        for other, slopes in reversed(self.slopes):
            if other.responds_like(fitted):
                return slopes
        self.slopes.append((fitted, {}))
        return self.slopes[-1][1]

    def _explains(self, model: FittedCandidate, extended: FittedCandidate) -> bool:
        """Return whether an effect leaves little, with a strength that the data determine.

        The first of a model: next to nothing, since another may leave that by itself.
        """
        little = _EXPLAINS * model.excess if model.fit.effects else SMALLEST_EXCESS
        less = extended.excess < little
        return extended.determined and less and self.improves(model, extended)

    def without(self, model: FittedCandidate, candidate: Candidate) -> FittedCandidate:
        """Fit a model without one of its effects, from the values of the others."""
        fitted = model.fit
        if (fitted, candidate) not in self.reduced:
            rest, own = [e for e in fitted.effects if e != candidate], fitted.terms_of(candidate)
            self.reduced[fitted, candidate] = self.fit_model(
                rest,
                np.delete(fitted.values, own),
                model.candidate,
                near=fitted,
                jacobian=np.delete(fitted.jacobian, own, axis=1),
            )
        return self.reduced[fitted, candidate]

    def polish(self, model: FittedCandidate, change: FloatArray | None = None) -> FittedCandidate:
        """Continue a fit to convergence, so that no effect is added to mend an early stop.

        ``change`` (m,) is that of its residuals since, where the model and the step are the same.
        """
        fitted = model.fit
        return self.fit_model(
            fitted.effects,
            fitted.values,
            model.candidate,
            near=fitted,
            jacobian=None if change is None else fitted.jacobian,
            seen=None if change is None else fitted.residual - fitted.correction + change,
            evaluations=CONVERGED,
        )

    def converged(
        self, model: FittedCandidate, ranked: Sequence[FittedCandidate]
    ) -> list[FittedCandidate]:
        """Extensions of a model, best first, of which the promising ones are fits to convergence.

        A fit that was stopped on its way may leave more than another effect, or than is worth it.
        """
        promising = [m for m in ranked if model.excess - m.excess > _HALFWAY * self.smallest_gain]
        return self._polished(ranked, promising[:_MOST_POLISHED])

    def simplest(self, ranked: Sequence[FittedCandidate]) -> FittedCandidate:
        """Simplest of the extensions of a model, best first, that are tied.

        Wrong numbers of the model that are behind an effect that it lacks by less than matters are
        fitted to convergence before, and so is that.
        """
        near = ranked[0].excess + self.smallest_gain
        numbers = [m for m in ranked if is_wrong_number(m) and m.excess < near]
        if not numbers or is_wrong_number(ranked[0]):
            return simplest(ranked)
        return simplest(self._polished(ranked, [ranked[0], *numbers[:_MOST_POLISHED]]))

    def _polished(
        self, ranked: Sequence[FittedCandidate], some: Sequence[FittedCandidate]
    ) -> list[FittedCandidate]:
        """Models, of which some are fitted to convergence, best first."""
        ended = [self.polish(m) if m in some else m for m in ranked]
        return sorted(ended, key=lambda m: m.excess)

    def optimise(self, model: FittedCandidate) -> FittedCandidate:
        """Continue a fit to convergence, and out of a local minimum where it leaves much."""
        best = self.polish(model)
        if best.excess > self.smallest_gain:
            start = descend(self.problem, self.base, best.fit)
            if start is not None:
                best = self._lower(best, start, best.added)
        return best

    def at_other_places(
        self, model: FittedCandidate, others: Sequence[FittedCandidate]
    ) -> FittedCandidate:
        """Best of a fit and of those with its last effect at the places of ``others``.

        They begin from its values: far from the data, each had ended in a minimum of its own.
        """
        best = model
        for candidate in (other.added for other in others):
            if candidate != model.candidate and candidate.effect is model.added.effect:
                best = self._lower(best, model.fit.values, candidate)
        return best

    def _lower(self, model: FittedCandidate, start: FloatArray, last: Candidate) -> FittedCandidate:
        """Better one of a fit and a fit from ``start``, whose last effect is ``last``."""
        effects = (*model.fit.effects[:-1], last)
        moved = self.fit_model(effects, start, last, evaluations=CONVERGED)
        return min(model, moved, key=lambda end: end.excess)

    def improves(self, before: FittedCandidate, after: FittedCandidate) -> bool:
        """Return whether the second model leaves significantly less than the first."""
        got = gain(before.validation, after.validation)
        least = max(self.smallest_gain, least_share(self.problem) * before.excess)
        return got.mean > max(least, STANDARD_ERRORS * got.standard_error)

    def leaves_much(self, model: FittedCandidate) -> bool:
        """Return whether a model leaves more than the detection limit in the fit and out of it.

        Numbers that the data do not determine leave much where a block is left out, and alone.
        """
        left = model.fit.residual[self.problem.in_train]
        fitted = float(left @ left) / max(left.size - int(model.fit.free.sum()), 1) - 1.0
        return min(model.excess, fitted) > self.detection_limit

    @cached_property
    def detection_limit(self) -> float:
        """Excess χ² below which nothing is named."""
        return detection_limit(self.problem, self.step_error, residual=self.residual)

    @property
    def smallest_gain(self) -> float:
        """Gain in χ² below which no effect is worth adding."""
        return max(self.detection_limit, unexplained_excess(self.initial_excess))


def _promising(
    scores: Sequence[ScreeningScore], share: float
) -> tuple[list[ScreeningScore], list[ScreeningScore]]:
    """Scores not far behind the best, and others down the list.

    At most two starts a candidate and three an effect.
    """
    starts = Counter[str]()
    kept = []
    for score in scores:
        label, identifier = score.candidate.label, score.candidate.identifier
        if starts[label] < 2 and starts[identifier] < 3:
            starts.update((label, identifier))
            kept.append(score)
    near = [s for s in kept if s.explained >= share * scores[0].explained][:_MOST_FITS]
    down = [
        s
        for s in kept[len(near) :]
        if s.explained >= _LEAST[s.candidate.on_sensor] * scores[0].explained
    ]
    return near, down[: _MOST_LOOKED_AT - len(near)]


def _best_of_each(
    fitted: Sequence[FittedCandidate],
) -> tuple[tuple[FittedCandidate, ...], tuple[FittedCandidate, ...]]:
    """Best fit of each candidate that the data determine, and of the others; best first."""
    best: dict[str, FittedCandidate] = {}
    ended: dict[str, FittedCandidate] = {}
    for model in sorted(fitted, key=lambda model: -model.excess):
        (best if model.determined else ended)[model.added.label] = model
    return (
        tuple(sorted(best.values(), key=lambda model: model.excess)),
        tuple(reversed([m for label, m in ended.items() if label not in best])),
    )


Rivals = Mapping[str, list[FittedCandidate]]  # label of an effect → all it was chosen from


class ForwardSelection(NamedTuple):
    """Result of a forward selection."""

    model: FittedCandidate  # last model
    rivals: Rivals  # for every effect the models it was chosen from, best first
    first: CandidateSet | None  # all candidates for the first effect; None if none was added
    # at every addition the models that could have been chosen, best first
    rounds: list[list[FittedCandidate]]


def select_forward(
    context: SelectionContext,
    model: FittedCandidate,
    rivals: Rivals,
    seen: set[frozenset[str]],
) -> ForwardSelection:
    """Add the best effect to a model until none improves it.

    Of tied effects that improve it the simplest is added. After each addition the effects without
    which the model is as good are eliminated; selection ends when that leads back to an earlier
    model, of the labels in ``seen``, to which the models extended here are added.
    """
    rivals, first, rounds = dict(rivals), None, list[list[FittedCandidate]]()
    while len(model.fit.effects) < _MOST_EFFECTS and context.leaves_much(model):
        labels = frozenset(effect.label for effect in model.fit.effects)
        if labels in seen:
            break
        seen.add(labels)
        candidates = context.extend(model)
        first, ranked = first or candidates, list(candidates.fitted)
        improving = [other for other in ranked if context.improves(model, other)]
        if not improving:
            ranked = context.converged(model, ranked)
            improving = [other for other in ranked if context.improves(model, other)]
        if not improving:
            break
        rounds.append(ranked)
        chosen = context.optimise(context.simplest(improving))
        if context.leaves_much(chosen):
            chosen = context.at_other_places(chosen, ranked)
        others = [other for other in ranked if other.candidate != chosen.candidate]
        rivals[chosen.added.label] = sorted([chosen, *others], key=lambda m: m.excess)
        model = eliminate_backward(context, chosen)
    return ForwardSelection(model, rivals, first, rounds)


def eliminate_backward(context: SelectionContext, model: FittedCandidate) -> FittedCandidate:
    """Remove effects without which the model, fitted to convergence, is as good."""
    for candidate in model.fit.effects:
        reduced = context.without(model, candidate)
        if not context.improves(reduced, model):
            reduced = context.polish(reduced)
            if not context.improves(reduced, model):
                return eliminate_backward(context, reduced)
    return model


def backtrack(
    context: SelectionContext, selection: ForwardSelection, seen: set[frozenset[str]]
) -> ForwardSelection:
    """Select forward again from the second best of each of the first rounds; keep the best.

    What leads back to a model that was extended before, one in ``seen``, ends there.
    """
    best = selection
    for ranked in reversed(selection.rounds[:_ROUNDS]):
        if len(ranked) < 2 or best.model.excess <= context.detection_limit:
            continue
        rivals = {**selection.rivals, ranked[1].added.label: ranked}
        again = select_forward(context, context.polish(ranked[1]), rivals, seen)
        if context.improves(best.model, again.model):
            best = again
    return best


def swap(context: SelectionContext, selection: ForwardSelection) -> tuple[FittedCandidate, Rivals]:
    """Swap each effect of a model for one that leaves significantly less.

    An early choice may have imitated two effects. For the last effect all others were tried when it
    was added, unless one before it was swapped. Returns the model, and for each of its effects the
    models it was chosen from, best first.
    """
    model, rivals = selection.model, dict[str, list[FittedCandidate]]()
    for candidate in selection.model.fit.effects:
        others = selection.rivals[candidate.label]
        beside = _labels(model) - {candidate.label}  # of which one may have been eliminated since
        as_added = all(_labels(other) - {other.added.label} == beside for other in others)
        if model is not selection.model or not as_added:
            reduced = context.without(model, candidate)
            others = list(context.extend(reduced, _SWAP_SHARE, look_down=False).fitted)
        own = next((m for m in others if m.candidate == candidate), None)
        if own is None or own.excess > model.excess:
            own = FittedCandidate(candidate, model.fit, model.validation)
        ranked = [own, *(m for m in others if m.candidate != candidate)]
        ranked.sort(key=lambda m: m.excess)
        chosen, kept = simplest(ranked), candidate
        if chosen.candidate != candidate and not tied(chosen, own):
            model, kept = chosen, chosen.added
        rivals[kept.label] = ranked
    return model, rivals


def _labels(model: FittedCandidate) -> set[str]:
    return {effect.label for effect in model.fit.effects}


@dataclass(frozen=True, eq=False)
class Selection:
    """Result of a selection."""

    calibrated: FittedCandidate  # model with only the uncertain parameters fitted
    final: FittedCandidate  # model with the selected effects
    effects: tuple[SelectedEffect, ...]  # selected, those first without which the model leaves most
    # all candidates for the first of them; None if the calibrated model suffices
    first: CandidateSet | None = field(repr=False)


def select_effects(context: SelectionContext, calibrated: FittedCandidate) -> Selection:
    """Select effects forward, from a calibrated model; where little remains, backtrack and swap."""
    seen = set[frozenset[str]]()
    selection = select_forward(context, calibrated, {}, seen)
    first, little = selection.first, _LITTLE * max(context.initial_excess, 0.0)
    if not selection.model.fit.effects:
        calibrated = selection.model  # fitted further, where its only effect was eliminated
    if context.detection_limit < selection.model.excess < little:
        selection = backtrack(context, selection, seen)
    model, rivals = selection.model, selection.rivals
    if len(model.fit.effects) > 1 and model.excess < little:
        model, rivals = swap(context, selection)
    effects = [rate_effect(candidate, rivals[candidate.label]) for candidate in model.fit.effects]
    if len(effects) > 1:
        effects.sort(key=lambda e: -context.without(model, e.candidate).excess)
    return Selection(calibrated, model, tuple(effects), first)
