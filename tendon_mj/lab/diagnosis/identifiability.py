"""Identifiability: what measured columns and a motion can tell of a rig, before a recording.

The rig is simulated as described, and again with one effect of the catalogue. The model is fitted
to each simulation in its uncertain numbers; what it leaves then is the trace of the effect. The
effect is noticed from the strength at which the mean square of its trace is the detection limit of
a diagnosis. Of twice that strength, and of that at which it leaves as much as no proven model
does, the least counts at which every other effect of the catalogue, fitted in its place, leaves
more than the detection limit: from there it is named, and below it may be taken for the others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tendon_mj.errors import RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis.alternatives import MATTERS
from tendon_mj.lab.diagnosis.check import check_simulation
from tendon_mj.lab.diagnosis.data import (
    Problem,
    all_samples,
    describe_system,
    make_problem,
    search_step,
    session_terms,
    step_error,
    uncertain_terms,
    with_more_guides,
    with_step,
)
from tendon_mj.lab.diagnosis.effects import (
    CATALOGUE,
    DISCRIMINATING_EXPERIMENTS,
    Effects,
    by_identifier,
    candidates,
)
from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.fitting import Fit, bounded_least_squares, fit, written
from tendon_mj.lab.diagnosis.proof import is_narrower
from tendon_mj.lab.diagnosis.rehearsal import rehearse
from tendon_mj.lab.diagnosis.search import SWITCHED_OFF, ScreeningScore, Slopes, screen
from tendon_mj.lab.diagnosis.selection import SelectionContext
from tendon_mj.lab.diagnosis.statistics import FittedCandidate, half_widths, intervals
from tendon_mj.lab.diagnosis.verdict import LARGEST_EXCESS, detection_limit
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording, si_name, unit_fault
from tendon_mj.lab.replay import Simulator, parameter_of, suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_SECANTS = 2  # simulations of an effect, and then fits, each at the strength before it promises
_TWICE = 2.0  # times the strength from which an effect is noticed


@dataclass(frozen=True)
class Number:
    """An uncertain number, and how well the columns determine it."""

    name: str
    unit: str  # of all that follows
    value: float  # as described
    half: float  # of its 95 % interval, at most its range
    determined: bool  # whether that excludes a part of the range
    unless: str  # effect with which it trades places most; empty if none matters
    half_then: float  # of the interval if the rig may have that effect


@dataclass(frozen=True)
class Pair:
    """An effect, and another for which it may be taken."""

    effects: tuple[str, str]  # at their places
    below: float | None  # which strength of the first [its unit]; None: at all that were tried
    decided_by: str  # a further column, or an experiment, if it is at all


@dataclass(frozen=True)
class Tellable:
    """An effect of the catalogue, and the strengths that the columns can tell.

    Strengths are changes of its first parameter from the value in the model.
    """

    identifier: str
    where: str
    parameter: str
    unit: str
    noticed: float | None  # least strength that is noticed; None if there is none
    named: float | None  # least strength, of those tried, at which it is no other effect

    @property
    def label(self) -> str:
        """Identifier and place."""
        return f"{self.identifier} ({self.where})"


@dataclass(frozen=True)
class Identifiability:
    """What columns can tell: numbers, effects, and pairs that they cannot tell apart."""

    signals: tuple[str, ...]
    numbers: tuple[Number, ...]
    effects: tuple[Tellable, ...]
    pairs: tuple[Pair, ...]

    @property
    def untold(self) -> list[Pair]:
        """Each pair that is not told apart, once."""
        open_ones = (pair for pair in reversed(self.pairs) if pair.below is None)
        return [*reversed({frozenset(pair.effects): pair for pair in open_ones}.values())]

    @property
    def sentence(self) -> str:
        """Summary, with what would decide most pairs."""
        noticed, named = (
            sum(getattr(effect, kind) is not None for effect in self.effects)
            for kind in ("noticed", "named")
        )
        sure = sum(number.determined and not number.unless for number in self.numbers)
        alike = [pair.decided_by for pair in self.untold]
        text = (
            f"{', '.join(self.signals)}: effects noticed {noticed} of {len(self.effects)}, named"
            f" {named}; uncertain numbers determined whatever effect there is {sure} of"
            f" {len(self.numbers)}; pairs not told apart {len(alike)}."
        )
        most = max(dict.fromkeys(alike), key=alike.count, default="")
        return f"{text} To decide most of these pairs, {most}." if most else text

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        kinds = ("numbers", "effects", "pairs")
        rows = {kind: [vars(row) for row in getattr(self, kind)] for kind in kinds}
        return {"sentence": self.sentence, "signals": self.signals, **rows}


def identify(
    recordings: Sequence[Recording],
    signals: Collection[str] = (),
    *,
    catalogue: Effects = CATALOGUE,
    progress: Progress = silent,
) -> Identifiability:
    """State what measured columns can tell of a rig in the motions of recordings.

    Only the driven columns of the recordings count, and the noise that they state.

    Args:
        recordings: of one model.
        signals: measured columns that would be recorded; by default all. The others are proposed
            where they decide between effects that these cannot tell apart.
        catalogue: effects to judge, and to compare them with.
        progress: called with a label, how much is done, and of how much.

    Raises:
        RecordingError: nothing is measured, or a noise is neither stated nor can be estimated.
        UnknownNameError: a signal is not a measured column.
    """
    made, _ = rehearse(recordings, {})
    columns = dict.fromkeys(column for recording in made for column in recording.measured)
    if not columns:
        raise RecordingError(f"recording {made[0].name!r}: nothing is [measured]")
    names = {c: made[0].written(c) for c in columns}
    chosen = {n if unit_fault(n, si=False) else si_name(n)[0]: n for n in signals} or names
    for column, name in chosen.items():
        if column not in columns:
            raise UnknownNameError("measured column", name, names.values(), "--signals")
    own = [replace(r, measured={c: m for c, m in r.measured.items() if c in chosen}) for r in made]
    narrow = make_problem(own, Simulator(own), all_samples(own))
    check_simulation(narrow)
    stepped = with_step(narrow, search_step(narrow))
    residual = stepped.residuals([{}])[0]
    error = step_error(stepped.extrapolate({}, residual) - residual)
    system = describe_system(narrow)
    effects = candidates(system, catalogue=by_identifier(catalogue))
    whole = make_problem(made, Simulator(made), all_samples(made))
    by_noise = -whole.residuals([{}])[0]  # with which the residual of the rig is 0
    whole = replace(whole, unused=frozenset(columns) - chosen.keys(), by_guides=by_noise)
    context = SelectionContext(
        problem=whole,
        base=system.values,
        calibrated=(*uncertain_terms(narrow), *session_terms(own, narrow.simulate)),
        candidates=tuple(c for c in effects if not (narrow.at_rest and c.effect.in_motion)),
        step_error=error,
        initial_excess=0.0,
        progress=progress,
    )
    limit = detection_limit(with_more_guides(narrow, {}), error)
    return _Identifying(context, limit).run(tuple(chosen.values()))


class _Identifying:
    def __init__(self, context: SelectionContext, limit: float) -> None:
        self.context, self.limit, problem = context, limit, context.problem
        self.used = problem.in_train
        start = [term.inert for term in context.calibrated]
        self.model: FittedCandidate = context.fit_model((), start, evaluations=1)
        self.candidates = context.further(self.model)
        self.slopes: Slopes = context.slopes_at(self.model, self.candidates)
        self.decided = dict[frozenset[str], str]()  # two effects → what decides between them
        self.absent = dict[str, FloatArray]()  # effect → (m,) residual with next to nothing of it

    @suppress_unsolved_warnings()
    def run(self, signals: tuple[str, ...]) -> Identifiability:
        """Judge all numbers and effects."""
        noticed, effects, pairs = self._noticed(), list[Tellable](), list[Pair]()
        progress, units = self.context.progress, self.context.problem.simulate.parameters
        for k, candidate in enumerate(self.candidates):
            progress("compare effects", k, len(self.candidates))
            scaled, target = noticed.get(candidate.label), candidate.terms[0].targets[0]
            named, rivals = None, list[Pair]()
            if scaled is not None:
                named, rivals = self._named(candidate, scaled)
            effects.append(
                Tellable(
                    candidate.identifier,
                    candidate.where,
                    target,
                    units[parameter_of(target)].unit,
                    None if scaled is None else self._change(candidate, scaled),
                    None if named is None else self._change(candidate, named),
                )
            )
            pairs += rivals
        progress("compare effects", len(self.candidates), len(self.candidates))
        return Identifiability(signals, tuple(self._numbers(noticed)), tuple(effects), tuple(pairs))

    def _numbers(self, noticed: Collection[str]) -> Iterator[Number]:
        """The uncertain numbers, with the effect of those noticed that widens each most."""
        fitted, problem = self.model.fit, self.context.problem
        alone = intervals(problem, fitted)
        wider = {
            label: half_widths(
                problem,
                replace(fitted, jacobian=np.column_stack([fitted.jacobian, slope])),
                np.append(fitted.free, True),
            )[:-1]
            for (label, _), slope in self.slopes.items()
            if label in noticed
        }
        places = np.cumsum(fitted.free) - 1  # of the free terms among themselves
        for k, term in enumerate(fitted.terms):
            value, half = float(fitted.values[k]), 0.5 * float(np.ptp(alone[k]))
            other, then = "", half
            if fitted.free[k] and wider:
                other = max(wider, key=lambda label: wider[label][places[k]])
                most = 0.5 * (term.high - term.low)
                then = min(float(wider[other][places[k]]) * term.probe, most)
            determined = bool(fitted.free[k]) and is_narrower(alone[k], term)
            unless = other if determined and then - half > MATTERS * abs(value) else ""
            for name in term.targets:
                yield Number(name, term.unit, value, half, determined, unless, then)

    def _parameters(self, candidate: Candidate, scaled: float) -> dict[str, float]:
        """Parameters of the rig with an effect of that scaled strength, in its first shape."""
        fitted, (strength, *shape) = self.model.fit, candidate.terms
        own = [strength.natural(scaled), *(t.starts[0] if t.starts else t.inert for t in shape)]
        terms = (*fitted.terms, *candidate.terms)
        return written(terms, np.array([*fitted.values, *own]), self.context.base)

    def _change(self, candidate: Candidate, scaled: float) -> float:
        """Change of the first parameter of an effect by that strength [its unit]."""
        target = candidate.terms[0].targets[0]
        ends = [self._parameters(candidate, z)[target] for z in (scaled, 0.0)]
        return float(ends[0] - ends[1])

    def _noticed(self) -> dict[str, float]:
        """Effect → least scaled strength that is noticed, of those that are within their range."""
        strengths = dict[str, float]()
        for candidate in self.candidates:
            if (candidate.label, 0) in self.slopes:
                left = self._trace(self.slopes[candidate.label, 0])
                side = 1.0 if candidate.terms[0].high > candidate.terms[0].inert else -1.0
                strengths[candidate.label] = side * self._times(left)
        for _ in range(_SECANTS):
            strengths = {c.label: _inside(c, strengths[c.label]) for c in self._of(strengths)}
            rows = self._rows(strengths)
            for label, row in rows.items():
                strengths[label] *= self._times(self._trace(row)) if np.isfinite(row).all() else 0.5
        for candidate in self._of(strengths):
            for _ in range(_SECANTS):
                strength = _inside(candidate, strengths[candidate.label])
                excess = self._excess(self._fitted(candidate, strength)[1])
                strengths[candidate.label] = strength * self._times(excess)
        return {
            c.label: strengths[c.label]
            for c in self._of(strengths)
            if _inside(c, strengths[c.label]) == strengths[c.label]
        }

    def _fitted(self, candidate: Candidate, scaled: float) -> tuple[Problem, Fit]:
        """The problem with a rig that has an effect as data, and the fit of the model to it."""
        near, context = self.model.fit, self.context
        (trace,) = self._rows({candidate.label: scaled}).values()
        problem = replace(context.problem, by_guides=context.problem.by_guides - trace)
        return problem, fit(
            problem,
            context.base,
            near.calibrated,
            (),
            near.values,
            jacobian=near.jacobian,
            seen=near.residual - trace,
        )

    def _excess(self, fitted: Fit) -> float:
        """Mean square that a fit to data without noise leaves."""
        return float(np.mean(fitted.residual[self.used] ** 2))

    def _of(self, labels: Collection[str]) -> list[Candidate]:
        return [candidate for candidate in self.candidates if candidate.label in labels]

    def _rows(self, strengths: Mapping[str, float]) -> dict[str, FloatArray]:
        """Effect → (m,) change of the readings by it [noise].

        From those with next to nothing of it: a play in the model, closed, changes them already.
        """
        new = self._of(strengths.keys() - self.absent.keys())
        sets = [self._parameters(c, SWITCHED_OFF) for c in new]
        sets += [self._parameters(c, strengths[c.label]) for c in self._of(strengths)]
        rows = [*self.context.problem.residuals(sets)]
        self.absent |= {c.label: rows.pop(0) for c in new}
        return {
            c.label: row - self.absent[c.label]
            for c, row in zip(self._of(strengths), rows, strict=True)
        }

    def _times(self, trace: float) -> float:
        """Factor of a strength by which a trace of that mean square comes to the limit."""
        return float(np.sqrt(self.limit / max(trace, np.finfo(float).tiny)))

    def _trace(self, row: FloatArray) -> float:
        """Mean square of what a fit of the numbers leaves of a change of the readings (m,)."""
        fitted, left = self.model.fit, row[self.used]
        if fitted.terms:
            slopes, bounds = fitted.jacobian[self.used], fitted.bounds - fitted.scaled
            left = left + slopes @ bounded_least_squares(slopes, left, bounds)
        return float(np.mean(left**2))

    def _named(self, candidate: Candidate, noticed: float) -> tuple[float | None, list[Pair]]:
        """Least scaled strength of those tried at which no other effect is as good; the pairs."""
        largest = noticed * float(np.sqrt(LARGEST_EXCESS / self.limit))
        told, rivals = dict[str, float](), dict[str, _Rival]()
        for scaled in dict.fromkeys(_inside(candidate, z) for z in (_TWICE * noticed, largest)):
            before, rivals = rivals, self._rivals(candidate, scaled)
            told |= {n: self._change(candidate, scaled) for n in before.keys() - rivals.keys()}
            if not rivals:
                break
        pairs = [Pair((candidate.label, name), below, "") for name, below in told.items()]
        for name, rival in rivals.items():
            labels = candidate.label, name
            if frozenset(labels) not in self.decided:
                self.decided[frozenset(labels)] = self._decide(candidate, rival)
            pairs.append(Pair(labels, None, self.decided[frozenset(labels)]))
        return None if rivals else scaled, pairs

    def _rivals(self, candidate: Candidate, scaled: float) -> dict[str, _Rival]:
        """Other effects that explain one of that strength.

        If screening finds none, those that it finds to explain half are fitted.
        """
        problem, own = self._fitted(candidate, scaled)
        excess = self._excess(own)
        share = 0.5 * max(0.0, 1.0 - self.limit / excess)
        others = [other for other in self.candidates if other.label != candidate.label]
        known = problem, self.context.base, own, others, silent, dict(self.slopes)
        rivals = [_Rival(problem, own, score) for score in screen(*known, (share, share))]
        left = [excess - rival.score.explained for rival in rivals]
        if not any(rest < self.limit for rest in left):
            rivals = [rival for rival in rivals if rival.score.explained >= share * excess]
            left = [rival.left(problem, self.context.base) for rival in rivals]
        found = [rival for rival, rest in zip(rivals, left, strict=True) if rest < self.limit]
        return {rival.score.candidate.label: rival for rival in reversed(found)}

    def _decide(self, candidate: Candidate, rival: _Rival) -> str:
        """What decides between an effect, to whose readings the model was fitted, and another."""
        left, problem = dict[str, float](), rival.problem
        for column in problem.unused:
            more = replace(problem, unused=problem.unused - {column})
            left[column] = rival.left(more, self.context.base)
        best = max(left, key=lambda column: left[column], default="")
        if best and left[best] > self.limit:
            return f"measure {problem.recordings[0].written(best)} too"
        one, other = candidate.effect, rival.score.candidate.effect
        sentence = DISCRIMINATING_EXPERIMENTS.get(frozenset({one.identifier, other.identifier}))
        record = one.next_experiment or other.next_experiment
        if sentence:
            return sentence[:1].lower() + sentence[1:].rstrip(".")
        return f"record {record}" if record else "measure one of them and state it in [known]"


class _Rival(NamedTuple):
    """An effect that may explain another one."""

    problem: Problem  # with the readings of the other one
    own: Fit  # of the uncertain numbers to these
    score: ScreeningScore

    def left(self, problem: Problem, base: Mapping[str, float]) -> float:
        """Mean square that it leaves, fitted to the same readings or to more of them."""
        own, score = self.own, self.score
        fitted = fit(
            problem,
            base,
            own.calibrated,
            (score.candidate,),
            score.start,
            jacobian=score.jacobian(own),
            seen=score.seen,
        )
        return float(np.mean(fitted.residual[problem.in_train] ** 2))


def _inside(candidate: Candidate, scaled: float) -> float:
    """The scaled strength within its range."""
    term = candidate.terms[0]
    return min(max(scaled, term.scaled(term.low)), term.scaled(term.high))
