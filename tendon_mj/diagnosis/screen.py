"""First look: which candidates could explain a residual at all, without fitting any of them.

Each candidate is switched on by a little, and its trace s in the residuals, freed of what the
fitted terms could imitate, is held against the residual r: the best strength is a = −(s·r)/(s·s),
within its range, and the power that it would take away is what it is ranked by. A second look does
the same at that strength, for traces that do not grow in proportion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.effect import Candidate, Term
from tendon_mj.diagnosis.fit import Fit, write
from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]
Report = Callable[[str, int, int], None]

_INVISIBLE = 1e-8  # mean square trace, in noise, below which an effect has no place on a model
_BATCH = 8  # parameter sets that are simulated between two reports


@dataclass(frozen=True, eq=False)
class Sight:
    """A candidate after a look at it.

    Attributes:
        candidate: which.
        start: (terms,) values to begin a fit from [their units].
        explained: mean square that it would take off the residual [noise power].
    """

    candidate: Candidate
    start: FloatArray
    explained: float


def screen(
    problem: Problem,
    base: Mapping[str, float],
    fitted: Fit,
    candidates: Sequence[Candidate],
    report: Report,
) -> list[Sight]:
    """Candidates that leave a trace, the most promising first.

    Args:
        problem, base: the data, and the parameters that the model has.
        fitted: the model so far.
        candidates: to look at.
        report: called with a label, how many looks are done, and of how many.
    """
    first = [
        Sight(candidate, np.array([_near(candidate.terms[0]), *shape]), 0.0)
        for candidate in candidates
        for shape in product(*(term.starts for term in candidate.terms[1:]))
    ]
    second = _look(problem, base, fitted, first, report, "first look")
    third = _look(problem, base, fitted, second, report, "second look")
    best: dict[str, Sight] = {}
    for sight in third:
        label = sight.candidate.label
        if label not in best or sight.explained > best[label].explained:
            best[label] = sight
    return sorted(best.values(), key=lambda sight: -sight.explained)


def _near(term: Term) -> float:
    """A probe away from inert, on the side where there is room."""
    return term.inert + (term.probe if term.high - term.inert >= term.probe else -term.probe)


def _look(
    problem: Problem,
    base: Mapping[str, float],
    fitted: Fit,
    sights: Sequence[Sight],
    report: Report,
    label: str,
) -> list[Sight]:
    """Switch each on at its start, and say at which strength it explains how much."""
    used = problem.chosen
    left = fitted.residual[used]
    imitable, _ = np.linalg.qr(fitted.jacobian[used][:, fitted.free])
    residual = left - imitable @ (imitable.T @ left)
    found = []
    for k in range(0, len(sights), _BATCH):
        report(label, k, len(sights))
        part = sights[k : k + _BATCH]
        sets = [
            write(
                (*fitted.terms, *sight.candidate.terms),
                np.concatenate([fitted.values, sight.start]),
                base,
            )
            for sight in part
        ]
        for sight, row in zip(part, problem.residuals(sets), strict=True):
            trace = row[used] - left
            if not np.isfinite(trace).all():
                continue
            trace = trace - imitable @ (imitable.T @ trace)
            power = float(trace @ trace)
            if power < _INVISIBLE * trace.size:
                continue
            strength = sight.candidate.terms[0]
            tried = sight.start[0] - strength.inert
            best = np.clip(
                strength.inert - tried * float(trace @ residual) / power,
                strength.low,
                strength.high,
            )
            share = (best - strength.inert) / tried
            explained = -float(2.0 * share * (trace @ residual) + share**2 * power)
            if explained > 0.0:
                start = np.array([best, *sight.start[1:]])
                found.append(Sight(sight.candidate, start, explained / trace.size))
    report(label, len(sights), len(sights))
    return found
