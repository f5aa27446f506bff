"""Identifiability: what measured columns and a motion can tell of a rig, before a recording.

The rig is simulated as described, and again with one effect of the catalogue. The model is fitted
to each simulation in its uncertain numbers; what it leaves then is the trace of the effect. The
effect is noticed from the strength at which the mean square of its trace is the detection limit of
a diagnosis. Of twice that strength, and of that at which it leaves as much as no proven model
does, the least counts at which every other effect of the catalogue, fitted in its place, leaves
more than the detection limit: from there it is named, and below it may be taken for the others.

Each effect is simulated at these few strengths. Two are compared by what was simulated of both, and
further simulations are of those only of which that does not tell whether they are alike.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
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
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Term
from tendon_mj.lab.diagnosis.limits import LARGEST_EXCESS, SMALLEST_EXCESS, chance_excess
from tendon_mj.lab.diagnosis.proof import is_narrower
from tendon_mj.lab.diagnosis.rehearsal import rehearse
from tendon_mj.lab.diagnosis.selection import SelectionContext
from tendon_mj.lab.diagnosis.statistics import half_widths, intervals, with_slope
from tendon_mj.lab.diagnosis.traces import NEAR, Match, Trace, Traces
from tendon_mj.lab.parameter_names import parameter_of
from tendon_mj.lab.progress import Progress, counted, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, suppress_unsolved_warnings
from tendon_mj.lab.units import si_name, unit_fault
from tendon_mj.typing import FloatArray

_TWICE = 2.0  # times the strength from which an effect is noticed
_FITS = 10  # at most to find that strength, each at the one that the one before promises
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
            f" {named}; uncertain numbers determined, with any one noticed effect fitted too,"
            f" {sure} of {len(self.numbers)} (an effect that is not fitted may move them beyond"
            f" their intervals); pairs not told apart {len(alike)}."
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
    for candidate in counted(progress, "compare effects", judge.candidates):
        effect, others = judge.effect(candidate)
        effects.append(effect)
        pairs += others
    numbers = tuple(judge.numbers({e.label for e in effects if e.noticed is not None}))
    return Identifiability(tuple(chosen.values()), numbers, tuple(effects), tuple(pairs))


class _Judge:
    """The rig as described, against which effects are judged by a detection limit."""

    def __init__(self, context: SelectionContext, limit: float) -> None:
        self.context, self.limit = context, limit
        model = context.fit_model((), [term.inert for term in context.calibrated], evaluations=1)
        self.fit, self.candidates = model.fit, context.further(model)
        self.traces = Traces(context.problem, context.base, model.fit, limit)
        self.of = {
            c: [Trace(c, s) for s in product(*(_shapes(t) for t in c.terms[1:]))]
            for c in self.candidates
        }
        self.noticed = self._strengths()
        self.decided = dict[frozenset[Candidate], str]()  # two effects → what decides between them

    def _strengths(self) -> dict[Candidate, float]:
        """Scaled strengths of the effects at which their mean square is the limit.

        It grows as their square, but where a number comes to the end of its range.
        """
        scaled = {c: 1.0 if own[0].ends[1] > 0.0 else -1.0 for c, own in self.of.items()}
        between = {c: [0.0, math.inf] for c in scaled}
        going = {c: own[0].within(scaled[c]) for c, own in self.of.items()}
        for _ in range(_FITS):
            self.context.progress("find strengths", len(scaled) - len(going), len(scaled))
            self.traces.simulate((self.of[c][0], z) for c, at in going.items() for z in (0.0, at))
            for c, at in going.items():
                excess = np.clip(self._excess(self.of[c][0], at), 1e-30, _STEEPEST * self.limit)
                between[c][int(excess > self.limit)] = abs(at)
                least, most = between[c]
                size = abs(at) * float(np.sqrt(self.limit / excess))
                size = size if least < size < most else math.sqrt(least * most)
                scaled[c] = math.copysign(size, at)
            after = {c: self.of[c][0].within(scaled[c]) for c in going}
            going = {c: z for c, z in after.items() if abs(z - going[c]) >= NEAR * abs(z)}
        for first, *others in self.of.values():
            for other in others:
                other.known[0.0] = first.known[0.0]
        twice = {c: own[0].within(_TWICE * scaled[c]) for c, own in self.of.items()}
        self.traces.simulate((trace, twice[c]) for c, own in self.of.items() for trace in own)
        return scaled

    def _excess(self, trace: Trace, scaled: float) -> float:
        """Mean square of what the numbers leave of an effect."""
        self.traces.simulate([(trace, scaled)])
        data = trace.data(scaled)
        return self.traces.numbers(data)[1] if np.isfinite(data).all() else math.inf

    def effect(self, candidate: Candidate) -> tuple[Tellable, list[Pair]]:
        """Strengths of an effect that are noticed and named, and what it is taken for."""
        target, own = candidate.terms[0].targets[0], self.of[candidate][0]
        (low, high), scaled = own.ends, self.noticed[candidate]
        noticed, named = self._change(own, scaled) if low < scaled < high else None, None
        told, rivals = dict[str, float](), dict[str, str]()
        for z in (_TWICE * scaled, scaled * float(np.sqrt(LARGEST_EXCESS / self.limit))):
            if named is not None or not low < z < high:  # at an end it is not determined
                continue
            if self._excess(own, z) < math.inf:
                before, rivals, change = rivals, self._rivals(own, z), self._change(own, z)
                told |= {name: change for name in before if name not in rivals}
                named = None if rivals else change
        pairs = [Pair((candidate.label, name), below, "") for name, below in told.items()]
        for name, decided_by in rivals.items():
            pairs.append(Pair((candidate.label, name), None, decided_by))
        unit = self.context.problem.simulate.parameters[parameter_of(target)].unit
        named_by = candidate.identifier, candidate.where, target, unit
        return Tellable(*named_by, noticed, named), pairs

    def numbers(self, noticed: Collection[str]) -> Iterator[Number]:
        """The uncertain numbers, with the effect of those noticed that widens each most."""
        fitted, problem = self.fit, self.context.problem
        alone, free = intervals(problem, fitted), np.append(fitted.free, True)
        wider = dict[str, FloatArray]()
        for candidate, (first, *_) in self.of.items() if fitted.terms else ():
            if candidate.label in noticed:
                twice = first.within(_TWICE * self.noticed[candidate])
                slope = -first.data(twice) / twice
                extended = with_slope(fitted, candidate, slope)
                wider[candidate.label] = half_widths(problem, extended, free)
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

    def _change(self, trace: Trace, scaled: float) -> float:
        """Change of the first parameter of an effect by that strength [its unit]."""
        target = trace.candidate.terms[0].targets[0]
        there, here = (self.traces.parameters(trace, z)[target] for z in (scaled, 0.0))
        return float(there - here)

    def _rivals(self, own: Trace, scaled: float) -> dict[str, str]:
        """Other effects that explain one of that strength, and what decides between them.

        What ends at a strength that was not simulated is compared again with that.
        """
        data = own.data(scaled)
        numbers, excess = self.traces.numbers(data)
        most = min(excess, 0.5 * (excess + self.limit))  # half of what has to be explained
        others = [t for c, traces in self.of.items() if c != own.candidate for t in traces]
        found = dict[Trace, Match]()
        for _ in range(_FITS):
            matches = self.traces.matches(data, numbers, others, most)
            others = [trace for trace, match in matches.items() if self._is_open(match)]
            found |= {trace: m for trace, m in matches.items() if trace not in others}
            if not others:
                break
            times = scaled / self.noticed[own.candidate]
            self.traces.simulate((t, self._further(t, matches[t], times)) for t in others)
            for trace in others:
                self.traces.move(matches[trace].numbers)
        near = {trace: match for trace, match in found.items() if match.left < self.limit}
        left = self.traces.left(data, near)
        if not any(rest < self.limit for rest in left.values()):  # half way, by their ratio
            close = sorted(found, key=lambda trace: -found[trace].left)
            close = [trace for trace in close if found[trace].left ** 2 < self.limit * excess]
            for trace in {trace.candidate: trace for trace in close}.values():
                if trace.shape or self.traces.compensates(found[trace]):
                    left[trace] = self.traces.refined(data, trace, found[trace])
        alike = sorted((t for t in left if left[t] < self.limit), key=left.__getitem__)
        best = {trace.candidate: trace for trace in reversed(alike)}
        for other, trace in best.items():
            pair = frozenset({own.candidate, other})
            if pair not in self.decided:
                self.decided[pair] = self._decide(own.candidate, data, numbers, trace)
        return {other.label: self.decided[frozenset({own.candidate, other})] for other in best}

    def _further(self, trace: Trace, match: Match, times: float) -> float:
        """Strength at which to simulate an effect that may explain another.

        Beyond all before, that many ``times`` the strength from which it is noticed, like the
        other: from there on its trace is as large.
        """
        if not math.isinf(match.doubt):
            return match.strength if match.doubt else 0.0
        size = max(abs(match.strength), times * abs(self.noticed[trace.candidate]))
        return trace.within(math.copysign(size, match.strength))

    def _is_open(self, match: Match) -> bool:
        """Return whether more simulations may show whether an effect explains another."""
        moved = self.traces.moved(self.traces.beside(match.numbers), match.numbers)
        doubt = match.doubt + (math.sqrt(moved) if moved >= self.limit else 0.0)
        return abs(math.sqrt(match.left) - math.sqrt(self.limit)) < doubt

    def _decide(self, own: Candidate, data: FloatArray, numbers: FloatArray, rival: Trace) -> str:
        """What decides between an effect, to whose readings the numbers are fitted, and another."""
        problem = self.context.problem
        left = {
            self.traces.matches(data, numbers, [rival], math.inf, column)[rival].left: column
            for column in problem.unused
        }
        if left and max(left) > self.limit:
            return f"measure {problem.recordings[0].written(left[max(left)])} too"
        one, other = own.effect, rival.candidate.effect
        record = one.next_experiment or other.next_experiment
        otherwise = f"record {record}" if record else "measure one of them and state it in [known]"
        pair = frozenset({one.identifier, other.identifier})
        sentence = DISCRIMINATING_EXPERIMENTS.get(pair, otherwise).rstrip(".")
        return sentence[:1].lower() + sentence[1:]


def _shapes(term: Term) -> tuple[float, ...]:
    """Values of a shape to begin from, and the ends of its range."""
    return (*term.starts, term.low, term.high) if term.starts else (term.inert,)
