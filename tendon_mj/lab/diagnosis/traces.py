"""Traces of effects: how they change the readings, simulated at a few strengths.

An effect in one of its shapes leads the readings along a curve. What it leaves of a residual, with
its strength and the uncertain numbers fitted, follows from a few simulations on that curve: it is
taken for straight between their strengths, and the numbers for linear about points where they were
simulated. Effects that trade places leave traces of the same size, so that strengths simulated once
serve in all comparisons. How far from them one ends bounds what is missed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.fitting import (
    Fit,
    bounded_least_squares,
    fit,
    natural_in_range,
    written,
)
from tendon_mj.typing import FloatArray

NEAR = 0.05  # of a strength, to which it is found
_BATCH = 8  # parameter sets simulated together
_STEPS = 5  # of the numbers, from points where they were simulated, at most
_SWITCHED_OFF = 1e-9  # of a probe: a play in the model, closed, changes the readings already


@dataclass(frozen=True, eq=False)
class Trace:
    """Change of the residuals by an effect in one shape."""

    candidate: Candidate
    shape: tuple[float, ...]  # values of its other terms [their units]
    # scaled strength → (m,) change; at 0, with next to nothing of it
    known: dict[float, FloatArray] = field(default_factory=dict)

    @property
    def ends(self) -> tuple[float, float]:
        """Least and largest scaled strength."""
        term = self.candidate.terms[0]
        low, high = sorted((term.scaled(term.low), term.scaled(term.high)))
        return low, high

    def within(self, scaled: float) -> float:
        """The scaled strength, or the end of the range before it."""
        low, high = self.ends
        return min(max(scaled, low), high)

    def data(self, scaled: float) -> FloatArray:
        """(m,) residual that a model without the effect leaves of a rig with that strength."""
        return self.known[0.0] - self.known[scaled]

    def distance(self, scaled: float) -> float:
        """How far a strength is from those simulated; 0 if as near as strengths are found.

        Beyond them all nothing is known.
        """
        least = min(abs(scaled - z) for z in self.known)
        if least <= NEAR * abs(scaled):
            return 0.0
        return least if min(self.known) < scaled < max(self.known) else math.inf

    def pieces(self) -> Iterator[tuple[float, FloatArray, FloatArray, tuple[float, float]]]:
        """Strength, change there, slope, and how far each straight piece reaches from there.

        The outer ones go on to the ends of the range, but where a simulation failed.
        """
        low, high = self.ends
        kept = sorted(z for z, change in self.known.items() if np.isfinite(change).all())
        for a, b in pairwise(kept):
            first = low if a == min(self.known) else a
            last = high if b == max(self.known) else b
            yield a, self.known[a], (self.known[b] - self.known[a]) / (b - a), (first - a, last - a)


class Match(NamedTuple):
    """An effect in the place of another."""

    left: float  # mean square [-]
    strength: float  # scaled
    doubt: float  # rms change of the readings [-] from the nearest strength that was simulated
    numbers: FloatArray  # (p,) scaled
    slope: FloatArray  # (m,) of the effect there


@dataclass(frozen=True, eq=False)
class Traces:
    """Traces on one rig as described, beside its uncertain numbers."""

    problem: Problem
    base: Mapping[str, float]
    fitted: Fit  # of the numbers to the rig as described
    little: float  # mean square that is not noticed
    # the numbers where they were simulated, with the change of the residuals
    points: list[Fit] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        """Begin with the numbers as described."""
        self.points.append(replace(self.fitted, residual=np.zeros_like(self.fitted.residual)))

    def parameters(
        self, trace: Trace, scaled: float, numbers: FloatArray | None = None
    ) -> dict[str, float]:
        """Parameters of the rig with that strength of an effect, and with other scaled numbers."""
        fitted, (first, *_) = self.fitted, trace.candidate.terms
        own = fitted.values if numbers is None else natural_in_range(fitted.terms, numbers)
        values = [*own, first.natural(scaled), *trace.shape]
        return written((*fitted.terms, *trace.candidate.terms), values, self.base)

    def simulate(self, wanted: Iterable[tuple[Trace, float]]) -> None:
        """Simulate effects at scaled strengths, where that was not done."""
        new = [(trace, z) for trace, z in dict.fromkeys(wanted) if z not in trace.known]
        for k in range(0, len(new), _BATCH):
            part = new[k : k + _BATCH]
            at = [z or trace.within(_SWITCHED_OFF) or -_SWITCHED_OFF for trace, z in part]
            sets = [self.parameters(trace, z) for (trace, _), z in zip(part, at, strict=True)]
            for (trace, z), row in zip(part, self.problem.residuals(sets), strict=True):
                trace.known[z] = row - self.fitted.residual

    def move(self, scaled: FloatArray) -> None:
        """Simulate the numbers at scaled values (p,), if what they change since is noticed."""
        if self.moved(self.beside(scaled), scaled) >= self.little:
            values = natural_in_range(self.fitted.terms, scaled)
            there = self.problem.residuals([self.fitted.parameters(self.base, values)])[0]
            if np.isfinite(there).all():
                change = there - self.fitted.residual
                self.points.append(replace(self.fitted, scaled=scaled, residual=change))

    @cached_property
    def normal(self) -> FloatArray:
        """(p, p) products of the slopes by the numbers, over the count of readings."""
        jacobian = self.fitted.jacobian[self.problem.in_train]
        return jacobian.T @ jacobian / max(len(jacobian), 1)

    def moved(self, own: Fit, scaled: FloatArray) -> float:
        """Mean square change of the readings since a point of the numbers."""
        step = scaled - own.scaled
        return float(step @ self.normal @ step)

    def compensates(self, match: Match) -> bool:
        """Return whether numbers make up for each other, far from where they were simulated."""
        steps = match.numbers - self.beside(match.numbers).scaled
        return float(np.diag(self.normal) @ steps**2) >= self.little

    def beside(self, scaled: FloatArray) -> Fit:
        """The nearest numbers that were simulated."""
        return min(self.points, key=lambda own: self.moved(own, scaled))

    def numbers(self, data: FloatArray) -> tuple[FloatArray, float]:
        """(p,) scaled numbers, fitted to a rig of which they leave that (m,), and what is left."""
        own = self.points[0]
        for _ in range(_STEPS):
            left, step = self.least(own, data, self.problem.in_train)
            scaled, before = own.scaled + step[:-1], own
            self.move(scaled)
            own = self.beside(scaled)
            if own is before:
                break
        return scaled, left

    def matches(
        self,
        data: FloatArray,
        scaled: FloatArray,
        traces: Iterable[Trace],
        most: float,
        column: str = "",
    ) -> dict[Trace, Match]:
        """Where traces leave least of a residual (m,), with numbers from ``scaled`` on.

        If less than ``most``; the unused ``column`` counts too.
        """
        used = replace(self.problem, unused=self.problem.unused - {column}).in_train
        basis, found = np.linalg.qr(self.fitted.jacobian[used]).Q, dict[Trace, Match]()
        for trace in traces:
            numbers = scaled
            for _ in range(_STEPS):
                own, ends = self.beside(numbers), list[Match]()
                for at, change, slope, reach in trace.pieces():
                    rows, along = (data + own.residual + change)[used], slope[used]
                    free, turned = (x - basis @ (basis.T @ x) for x in (rows, along))
                    size = max(float(turned @ turned), np.finfo(float).tiny)
                    there = free + np.clip(-(free @ turned) / size, *reach) * turned
                    if np.mean(there**2) < most:  # it is more with the numbers within their ranges
                        left, step = self.least(own, data + change, used, slope, reach)
                        strength, numbers = at + float(step[-1]), own.scaled + step[:-1]
                        doubt = trace.distance(strength) * float(np.sqrt(size / rows.size))
                        ends.append(Match(left, strength, doubt, numbers, slope))
                best = min(ends, key=lambda end: end.left, default=None)
                if best is None or best.left >= most:
                    break
                found[trace], numbers = best, best.numbers
                if self.beside(numbers) is own:
                    break
        return found

    def left(self, data: FloatArray, found: Mapping[Trace, Match]) -> dict[Trace, float]:
        """Mean squares that effects leave, simulated with the numbers where these move too."""
        left, origin = {trace: match.left for trace, match in found.items()}, self.points[0]
        moved = [t for t, m in found.items() if self.moved(origin, m.numbers) >= self.little]
        sets = [self.parameters(t, found[t].strength, found[t].numbers) for t in moved]
        for trace, row in zip(moved, self.problem.residuals(sets) if sets else (), strict=True):
            match, ends = found[trace], np.array(trace.ends)
            own = replace(origin, scaled=match.numbers, residual=row - self.fitted.residual)
            reach = ends - match.strength
            left[trace], _ = self.least(own, data, self.problem.in_train, match.slope, reach)
        return left

    def refined(self, data: FloatArray, trace: Trace, match: Match) -> float:
        """Mean square that an effect leaves, fitted with the numbers and in its shape."""
        near, candidate, used = self.fitted, trace.candidate, self.problem.in_train
        rig = replace(self.problem, by_guides=self.problem.by_guides + data - near.residual)
        numbers = natural_in_range(near.terms, match.numbers)
        start = [*numbers, candidate.terms[0].natural(match.strength), *trace.shape]
        shapes = np.full((data.size, len(trace.shape)), np.nan)
        jacobian = np.column_stack([near.jacobian, match.slope, shapes])
        known = rig, self.base, near.calibrated, (candidate,), np.array(start)
        return float(np.mean(fit(*known, jacobian=jacobian).residual[used] ** 2))

    def least(
        self,
        own: Fit,
        data: FloatArray,
        used: NDArray[np.bool_],
        slope: FloatArray | float = 0.0,
        reach: Sequence[float] | FloatArray = (-1.0, 1.0),
    ) -> tuple[float, FloatArray]:
        """Mean square that the numbers and a slope within ``reach`` leave, and their steps.

        A number's range counts as one reading's noise: those of which the readings tell nothing
        stay, where the others would have them far off for next to nothing.
        """
        rows = (data + own.residual)[used]
        along = np.broadcast_to(slope, own.residual.shape)[used]
        matrix = np.column_stack([own.jacobian[used], along])
        bounds = np.column_stack([own.bounds - own.scaled, reach])
        pull = np.hypot(own.weights, 1.0 / np.ptp(own.bounds, axis=0))
        aim = np.concatenate([rows, pull * own.scaled, [0.0]])
        pulled = np.vstack([matrix, np.diag(np.append(pull, 0.0))])
        step = bounded_least_squares(pulled, aim, bounds)
        return float(np.mean((rows + matrix @ step) ** 2)), step
