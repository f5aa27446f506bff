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
from tendon_mj.lab.diagnosis.data import (
    Problem,
    all_samples,
    describe_system,
    make_problem,
    search_step,
    session_terms,
    uncertain_terms,
)
from tendon_mj.lab.diagnosis.effects import (
    CATALOGUE,
    DISCRIMINATING_EXPERIMENTS,
    Effects,
    by_identifier,
    candidates,
)
from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.fitting import Fit, fit, written
from tendon_mj.lab.diagnosis.proof import is_narrower
from tendon_mj.lab.diagnosis.rehearsal import rehearse
from tendon_mj.lab.diagnosis.search import ScreeningScore, screen
from tendon_mj.lab.diagnosis.selection import SelectionContext
from tendon_mj.lab.diagnosis.statistics import half_widths, intervals, with_slope
from tendon_mj.lab.diagnosis.verdict import LARGEST_EXCESS, SMALLEST_EXCESS, chance_excess
from tendon_mj.lab.parameter_names import parameter_of
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, suppress_unsolved_warnings
from tendon_mj.lab.units import si_name, unit_fault
from tendon_mj.typing import FloatArray

_TWICE = 2.0  # times the strength from which an effect is noticed
_FITS = 4  # to find that strength, each at the one that the one before promises
_NEAR = 0.05  # of a strength, by which it changes when it is found
_SWITCHED_OFF = 1e-9  # of a probe
_STEEPEST = 1e4  # times the limit: a larger trace, or a failed simulation, counts as this


class Number(NamedTuple):
    """An uncertain number, and how well the columns determine it."""

    name: str
    unit: str  # of all that follows
    value: float  # as described
    half: float  # of its 95 % interval, at most its range
    determined: bool  # whether that excludes enough of the range, see `is_narrower`
    unless: str  # effect with which it trades places most; empty if none matters
    half_then: float  # of the interval if the rig may have that effect


class Pair(NamedTuple):
    """An effect, and another for which it may be taken."""

    effects: tuple[str, str]  # at their places
    below: float | None  # which strength of the first [its unit]; None: at all that were tried
    decided_by: str  # a further column, or an experiment, if it is at all


class Tellable(NamedTuple):
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
            sum(strength is not None for strength in strengths)
            for strengths in zip(*((e.noticed, e.named) for e in self.effects), strict=True)
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
        rows = {kind: [row._asdict() for row in getattr(self, kind)] for kind in kinds}
        return {"sentence": self.sentence, "signals": self.signals, **rows}


@suppress_unsolved_warnings()
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
    columns = {column: made[0].written(column) for r in made for column in r.measured}
    if not columns:
        raise RecordingError(f"recording {made[0].name!r}: nothing is [measured]")
    chosen = {n if unit_fault(n, si=False) else si_name(n)[0]: n for n in signals} or columns
    for column, name in chosen.items():
        if column not in columns:
            raise UnknownNameError("measured column", name, columns.values(), "--signals")
    own = [replace(r, measured={c: m for c, m in r.measured.items() if c in chosen}) for r in made]
    narrow = Problem(tuple(own), Simulator(own), all_samples(own))
    system = describe_system(narrow)
    bound = candidates(system, catalogue=by_identifier(catalogue))
    simulate = Simulator(made).in_steps(search_step(narrow) or 1.0)
    whole = make_problem(made, simulate, all_samples(made))
    by_noise = -whole.residuals([{}])[0]  # with which the residual of the rig is 0
    whole = replace(whole, unused=frozenset(columns) - chosen.keys(), by_guides=by_noise)
    terms = (*uncertain_terms(narrow), *session_terms(own, narrow.simulate))
    moving = tuple(c for c in bound if not (narrow.at_rest and c.effect.in_motion))
    context = SelectionContext(whole, system.values, terms, moving, 0.0, 0.0, progress)
    limit = max(SMALLEST_EXCESS, chance_excess(narrow, int(whole.in_train.sum())))
    judge, effects, pairs = _Judge(context, limit), list[Tellable](), list[Pair]()
    for k, candidate in enumerate(judge.candidates):
        progress("compare effects", k, len(judge.candidates))
        effect, others = judge.effect(candidate)
        effects.append(effect)
        pairs += others
    progress("compare effects", len(effects), len(effects))
    noticed = {effect.label for effect in effects if effect.noticed is not None}
    numbers = tuple(judge.numbers(noticed))
    return Identifiability(tuple(chosen.values()), numbers, tuple(effects), tuple(pairs))


class _Rival(NamedTuple):
    """An effect that may explain another one."""

    problem: Problem  # with the readings of the other one
    own: Fit  # of the uncertain numbers to these
    score: ScreeningScore

    def left(self, base: Mapping[str, float], column: str = "") -> float:
        """Mean square that it leaves, fitted to the same readings, or to a further column too."""
        problem = replace(self.problem, unused=self.problem.unused - {column})
        known = self.own.calibrated, (self.score.candidate,), self.score.start
        jacobian, seen = self.score.jacobian(self.own), self.score.seen
        return _excess(problem, fit(problem, base, *known, jacobian=jacobian, seen=seen))


class _Judge:
    """The rig as described, against which effects are judged by a detection limit."""

    def __init__(self, context: SelectionContext, limit: float) -> None:
        self.context, self.limit = context, limit
        start = [term.inert for term in context.calibrated]
        model = context.fit_model((), start, evaluations=1)
        self.fit, self.candidates = model.fit, context.further(model)
        self.slopes = context.slopes_at(model, self.candidates)
        self.absent = dict[str, FloatArray]()  # effect → (m,) residual with next to nothing of it
        self.decided = dict[frozenset[str], str]()  # two effects → what decides between them

    def effect(self, candidate: Candidate) -> tuple[Tellable, list[Pair]]:
        """Strengths of an effect that are noticed and named, and what it is taken for."""
        strength, target = candidate.terms[0], candidate.terms[0].targets[0]
        low, high = sorted((strength.scaled(strength.low), strength.scaled(strength.high)))
        at, scaled = 0.0, 1.0 if high > 0.0 else -1.0
        for _ in range(_FITS):
            at, last = min(max(scaled, low), high), at
            if abs(at - last) < _NEAR * abs(at):
                break
            excess = np.clip(_excess(*self._fitted(candidate, at)), 1e-30, _STEEPEST * self.limit)
            scaled = at * float(np.sqrt(self.limit / excess))
        noticed, named = self._change(candidate, scaled) if low < scaled < high else None, None
        told, rivals = dict[str, float](), dict[str, _Rival]()
        for z in (_TWICE * scaled, scaled * float(np.sqrt(LARGEST_EXCESS / self.limit))):
            if named is None and low < z < high:  # at an end it is not determined
                before, rivals, change = (
                    rivals,
                    self._rivals(candidate, z),
                    self._change(candidate, z),
                )
                told |= {name: change for name in before if name not in rivals}
                named = None if rivals else change
        pairs = [Pair((candidate.label, name), below, "") for name, below in told.items()]
        for name, rival in rivals.items():
            labels = candidate.label, name
            if frozenset(labels) not in self.decided:
                self.decided[frozenset(labels)] = self._decide(candidate, rival)
            pairs.append(Pair(labels, None, self.decided[frozenset(labels)]))
        unit = self.context.problem.simulate.parameters[parameter_of(target)].unit
        named_by = candidate.identifier, candidate.where, target, unit
        return Tellable(*named_by, noticed, named), pairs

    def numbers(self, noticed: Collection[str]) -> Iterator[Number]:
        """The uncertain numbers, with the effect of those noticed that widens each most."""
        fitted, problem = self.fit, self.context.problem
        alone, free = intervals(problem, fitted), np.append(fitted.free, True)
        wider, effects = dict[str, FloatArray](), {c.label: c for c in self.candidates}
        for (label, _), slope in self.slopes.items() if fitted.terms else ():
            if label in noticed:
                extended = with_slope(fitted, effects[label], slope)
                wider[label] = half_widths(problem, extended, free)
        for k, term in enumerate(fitted.terms):
            value, half = float(fitted.values[k]), 0.5 * float(np.ptp(alone[k]))
            other = max(wider, key=lambda label: wider[label][k], default="")
            then = (
                min(wider[other][k] * term.probe, 0.5 * (term.high - term.low)) if other else half
            )
            determined = bool(fitted.free[k]) and is_narrower(alone[k], term)
            unless = other if determined and then - half > MATTERS * abs(value) else ""
            for name in term.targets:
                yield Number(name, term.unit, value, half, determined, unless, max(half, then))

    def _parameters(self, candidate: Candidate, scaled: float) -> dict[str, float]:
        """Parameters of the rig with an effect of that scaled strength, in its first shape."""
        strength, *shape = candidate.terms
        own = [strength.natural(scaled), *(t.starts[0] if t.starts else t.inert for t in shape)]
        terms, values = (*self.fit.terms, *candidate.terms), np.array([*self.fit.values, *own])
        return written(terms, values, self.context.base)

    def _change(self, candidate: Candidate, scaled: float) -> float:
        """Change of the first parameter of an effect by that strength [its unit]."""
        target = candidate.terms[0].targets[0]
        there, here = (self._parameters(candidate, z)[target] for z in (scaled, 0.0))
        return float(there - here)

    def _fitted(self, candidate: Candidate, scaled: float) -> tuple[Problem, Fit]:
        """The problem with a rig that has an effect as data, and the fit of the model to it.

        Its readings change from those with next to nothing of it: a play in the model, closed,
        changes them already.
        """
        near, problem, label = self.fit, self.context.problem, candidate.label
        sets = [self._parameters(candidate, z) for z in (scaled, _SWITCHED_OFF)]
        there, *off = problem.residuals(sets[: 1 if label in self.absent else 2])
        trace = there - self.absent.setdefault(label, off[0] if off else near.residual)
        problem = replace(problem, by_guides=problem.by_guides - trace)
        known = problem, self.context.base, near.calibrated, (), near.values
        return problem, fit(*known, jacobian=near.jacobian, seen=near.residual - trace)

    def _rivals(self, candidate: Candidate, scaled: float) -> dict[str, _Rival]:
        """Other effects that explain one of that strength.

        If screening finds none, those that it finds to explain half are fitted.
        """
        problem, own = self._fitted(candidate, scaled)
        excess, base = _excess(problem, own), self.context.base
        share = 0.5 * max(0.0, 1.0 - self.limit / excess)
        others = [other for other in self.candidates if other.label != candidate.label]
        known = problem, base, own, others, silent, dict(self.slopes)
        rivals = [_Rival(problem, own, score) for score in screen(*known, (share, share))]
        left = [excess - rival.score.explained for rival in rivals]
        if not any(rest < self.limit for rest in left):
            rivals = [rival for rival in rivals if rival.score.explained >= share * excess]
            left = [rival.left(base) for rival in rivals]
        found = [rival for rival, rest in zip(rivals, left, strict=True) if rest < self.limit]
        return {rival.score.candidate.label: rival for rival in reversed(found)}

    def _decide(self, candidate: Candidate, rival: _Rival) -> str:
        """What decides between an effect, to whose readings the model was fitted, and another."""
        problem, base = rival.problem, self.context.base
        left = {rival.left(base, column): column for column in problem.unused}
        if left and max(left) > self.limit:
            return f"measure {problem.recordings[0].written(left[max(left)])} too"
        one, other = candidate.effect, rival.score.candidate.effect
        record = one.next_experiment or other.next_experiment
        otherwise = f"record {record}" if record else "measure one of them and state it in [known]"
        pair = frozenset({one.identifier, other.identifier})
        sentence = DISCRIMINATING_EXPERIMENTS.get(pair, otherwise).rstrip(".")
        return sentence[:1].lower() + sentence[1:]


def _excess(problem: Problem, fitted: Fit) -> float:
    """Mean square that a fit to data without noise leaves."""
    return float(np.mean(fitted.residual[problem.in_train] ** 2))
