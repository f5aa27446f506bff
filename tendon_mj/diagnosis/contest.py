"""Candidates fitted side by side, and judged on stretches that they were not fitted to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_mj.diagnosis.around import look_around, slopes_hold
from tendon_mj.diagnosis.effects.effect import Candidate, Term
from tendon_mj.diagnosis.fit import Fit, fit
from tendon_mj.diagnosis.held_out import Gain, Leftover, gain, leave_out
from tendon_mj.diagnosis.problem import Problem
from tendon_mj.diagnosis.screen import Report, Sight, screen

SMALLEST_GAP = 0.2  # mean square, in noise power (0.45 noise rms): less is not worth a name
GRAIN = 0.0025  # of a signal's range: what lumping and stepping leave, and no more a name
CLOSED = 0.985  # of the gap, in noise rms: a model that closes less explains it not
SURE = 2.0  # standard errors
_MOST_FITS = 4
_TRIALS = 5  # points: a look has led near where a fit ends
POLISH = 25  # points: to the end of a fit
_PROMISING = 0.6  # of what the best candidate explains, to be fitted


@dataclass(frozen=True, eq=False)
class Entrant:
    """A fitted model and what it leaves on stretches that it was not fitted to.

    Attributes:
        candidate: the effect that was added or put in another's place; None for the model as it is.
        fit: of all its terms.
        leftover: see `leave_out`.
    """

    candidate: Candidate | None
    fit: Fit
    leftover: Leftover

    @property
    def gap(self) -> float:
        """Mean square beyond noise, left out [noise power]."""
        return self.leftover.gap


@dataclass(frozen=True, eq=False)
class Field:
    """Candidates for one more effect.

    Attributes:
        sights: of all that leave a trace, the most promising first.
        entrants: of those that were fitted and whose strength the data hold, the one that leaves
            least first.
    """

    sights: tuple[Sight, ...]
    entrants: tuple[Entrant, ...]


@dataclass(frozen=True, eq=False)
class Setting:
    """What stays the same during a diagnosis.

    Attributes:
        problem: the data.
        base: parameters that the model has.
        calibrated: terms of what the recordings call uncertain.
        candidates: the catalogue on this model.
        floor: mean square that the steps of the simulation alone may leave, see `step_error`
            [noise power].
        report: of progress.
    """

    problem: Problem
    base: Mapping[str, float]
    calibrated: tuple[Term, ...]
    candidates: tuple[Candidate, ...]
    floor: float
    report: Report

    def enter(
        self,
        effects: Sequence[Candidate],
        start: Sequence[float] | np.ndarray,
        candidate: Candidate | None = None,
        *,
        near: Fit | None = None,
        trials: int = _TRIALS,
    ) -> Entrant:
        """Fit a model with these effects, from ``start``; ``near`` is a fit not far from there."""
        fitted = fit(
            self.problem,
            self.base,
            self.calibrated,
            effects,
            np.asarray(start, float),
            refined=None if near is None else near.refined,
            trials=trials,
        )
        return Entrant(candidate, fitted, leave_out(self.problem, fitted))

    def rivals(self, model: Entrant, share: float = _PROMISING) -> Field:
        """Models with one more effect each.

        Fitted are those that explain, at a look, at least ``share`` of what the best one does.
        """
        taken = frozenset[str]().union(*(effect.targets for effect in model.fit.effects))
        others = [candidate for candidate in self.candidates if not candidate.targets & taken]
        sights = screen(self.problem, self.base, model.fit, others, self.report)
        tried = _promising(sights, share)
        entrants = []
        for k, sight in enumerate(tried):
            self.report("fit", k, len(tried))
            effects = (*model.fit.effects, sight.candidate)
            entrants.append(self.enter(effects, sight.start, sight.candidate, near=model.fit))
        if tried:
            self.report("fit", len(tried), len(tried))
        best: dict[str, Entrant] = {}
        for entrant in sorted(entrants, key=lambda entrant: -entrant.gap):
            if entrant.candidate is not None and entrant.fit.measures(entrant.candidate):
                best[entrant.candidate.label] = entrant
        return Field(tuple(sights), tuple(sorted(best.values(), key=lambda entrant: entrant.gap)))

    def without(self, model: Entrant, candidate: Candidate) -> Entrant:
        """Fit a model with one of its effects left out, from where the others stood."""
        fitted = model.fit
        rest = tuple(effect for effect in fitted.effects if effect != candidate)
        start = [
            fitted.values[: len(fitted.calibrated)],
            *(fitted.values[fitted.own(e)] for e in rest),
        ]
        return self.enter(rest, np.concatenate(start), model.candidate, near=fitted)

    def polish(self, entrant: Entrant) -> Entrant:
        """Fit on from where a fit ended, so that nothing is added to mend an early end."""
        fitted = entrant.fit
        return self.enter(
            fitted.effects, fitted.values, entrant.candidate, near=fitted, trials=POLISH
        )

    def settle(self, entrant: Entrant, whole: float) -> Entrant:
        """Fit on to the end; of an added non-smooth effect to the end of its best."""
        settled = self.polish(entrant)
        if settled.candidate is not None and settled.candidate.non_smooth:
            for widely in (True, False):
                if not self._lost(settled, whole):
                    break
                settled = self._look(settled, widely=widely)
        return settled

    def settle_again(self, entrant: Entrant, whole: float) -> Entrant:
        """The same in other steps: from there on, and not over all ranges."""
        settled = self.polish(entrant)
        non_smooth = any(effect.non_smooth for effect in settled.fit.effects)
        lost = non_smooth and self._lost(settled, whole)
        return self._look(settled, widely=False) if lost else settled

    def _lost(self, entrant: Entrant, whole: float) -> bool:
        """Whether a fit leaves what is worth a look, and least squares may be the reason."""
        worth = entrant.gap > max(self.least, may_remain(whole))
        return worth and not slopes_hold(self.problem, self.base, entrant.fit)

    def _look(self, entrant: Entrant, *, widely: bool) -> Entrant:
        """The better of a fit and one from around it.

        ``widely``: from all that the effect added last may be.
        """
        fitted, last = entrant.fit, entrant.candidate
        terms = fitted.own(last) if widely and last is not None else slice(0)
        start = look_around(self.problem, self.base, fitted, terms, self.report)
        around = self.enter(fitted.effects, start, last, near=fitted, trials=POLISH)
        return min(entrant, around, key=lambda end: end.gap)

    def helps(self, before: Entrant, after: Entrant, whole: float) -> bool:
        """Whether the second leaves less, beyond chance, numerics and what is worth a name."""
        got = gain(before.leftover, after.leftover)
        return got.mean > max(self.least, may_remain(whole), SURE * got.error)

    @cached_property
    def least(self) -> float:
        """Gap below which nothing is called missing [noise power]."""
        return least_gap(self.problem, self.floor)


def may_remain(whole: float) -> float:
    """Gap that a model may leave of a ``whole`` one and have closed it [noise power]."""
    before = np.sqrt(1.0 + max(whole, 0.0)) - 1.0
    return float((1.0 + (1.0 - CLOSED) * before) ** 2 - 1.0)


def least_gap(problem: Problem, floor: float) -> float:
    """Gap below which nothing is worth a name, for a simulation with that floor [noise power]."""
    return max(SMALLEST_GAP, floor, grain(problem))


def grain(problem: Problem) -> float:
    """Mean square of `GRAIN` over all residuals [noise power]."""
    powers = [
        (GRAIN * float(np.ptp(problem.recordings[k].columns[column])) / problem.noise[k][column])
        ** 2
        for k, column, _ in problem.blocks()
    ]
    return float(np.mean(powers))


def tied(best: Entrant, other: Entrant) -> bool:
    """Whether these data can't tell the two models apart."""
    got = difference(best, other)
    return got.mean < max(SURE * got.error, tie_width(best))


def tie_width(best: Entrant) -> float:
    """Difference of gaps that says nothing: a quarter of what the best model cannot explain."""
    return 0.02 + 0.25 * max(best.gap, 0.0)


def difference(best: Entrant, other: Entrant) -> Gain:
    """What the other model leaves more."""
    return gain(other.leftover, best.leftover)


def _promising(sights: Sequence[Sight], share: float) -> list[Sight]:
    """Those to be fitted: not far behind the best, and no effect many times.

    Of each candidate the two best starts, of each effect the three best, wherever it is.
    """
    if not sights:
        return []
    least, starts = share * sights[0].explained, Counter[str]()
    kept = []
    for sight in sights:
        label, identifier = sight.candidate.label, sight.candidate.identifier
        if sight.explained >= least and starts[label] < 2 and starts[identifier] < 3:
            starts.update((label, identifier))
            kept.append(sight)
    return kept[:_MOST_FITS]
