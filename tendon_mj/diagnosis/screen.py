"""First looks: which candidates could explain a residual at all, without fitting any of them.

Each candidate is switched on by a little. Its trace t in the residuals and the slopes J of what is
fitted already say, to first order, with which strength and which corrections of the others the
residual r would be smallest: min |r + J Δ + t a|. The next look is a simulation at just that point,
which tells what really is left and how the trace has changed; those that promise little drop out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import lsq_linear

from tendon_mj.diagnosis.effects.effect import Candidate, Term
from tendon_mj.diagnosis.fit import Fit, natural, write
from tendon_mj.diagnosis.problem import Problem
from tendon_mj.replay.suppression import suppress_unsolved_warnings

FloatArray = NDArray[np.float64]
Report = Callable[[str, int, int], None]

_INVISIBLE = 1e-8  # mean square trace, in noise, below which an effect has no place on a model
_NOTHING = 1e-9  # of a probe: no switching on
_LARGER, _TRIES = 1e3, 3  # a probe that leaves none is enlarged by so much, so often
_BATCH = 8  # parameter sets that are simulated between two reports
_KEPT = (0.05, 0.15)  # of what the best explains, to be looked at again
_LOOKS = ("first look", "second look", "third look")


@dataclass(frozen=True, eq=False)
class Sight:
    """A candidate after a look at it.

    Attributes:
        candidate: which.
        start: (fitted terms and its own,) values to begin a fit from [their units].
        explained: mean square that this would take off the residual [noise power].
        attempt: which of the candidate's starts it came from.
    """

    candidate: Candidate
    start: FloatArray
    explained: float
    attempt: int


@suppress_unsolved_warnings()
def screen(
    problem: Problem,
    base: Mapping[str, float],
    fitted: Fit,
    candidates: Sequence[Candidate],
    report: Report,
) -> list[Sight]:
    """Candidates that leave a trace, the most promising first, once for each of their starts.

    Args:
        problem, base: the data, and the parameters that the model has.
        fitted: the model so far.
        candidates: to look at.
        report: called with a label, how many looks are done, and of how many.
    """
    sights = [
        Sight(candidate, np.array([*fitted.values, _near(candidate.terms[0]), *shape]), 0.0, k)
        for candidate in candidates
        for k, shape in enumerate(product(*(term.starts for term in candidate.terms[1:])))
    ]
    best: dict[tuple[str, int], Sight] = {}
    for number, label in enumerate(_LOOKS):
        seen = _look(problem, base, fitted, sights, report, label)
        if number == 0:
            seen += _look_harder(problem, base, fitted, sights, seen, report)
        for achieved, _ in seen:
            key = achieved.candidate.label, achieved.attempt
            if key not in best or achieved.explained > best[key].explained:
                best[key] = achieved
        promised = [promise for _, promise in seen]
        if number < len(_KEPT):
            least = _KEPT[number] * max((s.explained for s in promised), default=0.0)
            sights = [s for s in promised if s.explained > 0.0 and s.explained >= least]
    ranked = sorted(best.values(), key=lambda sight: -sight.explained)
    return [sight for sight in ranked if sight.explained > 0.0]


def _look_harder(
    problem: Problem,
    base: Mapping[str, float],
    fitted: Fit,
    sights: Sequence[Sight],
    seen: Sequence[tuple[Sight, Sight]],
    report: Report,
) -> list[tuple[Sight, Sight]]:
    """Look again at those that left no trace, with larger probes.

    What is large for a hinge, in N m/rad, is next to nothing for a slide, in N/m.
    """
    found: list[tuple[Sight, Sight]] = []
    for _ in range(_TRIES):
        traced = {(s.candidate.label, s.attempt) for s, _ in [*seen, *found]}
        sights = [
            _enlarged(sight, len(fitted.terms))
            for sight in sights
            if (sight.candidate.label, sight.attempt) not in traced
        ]
        if not sights:
            break
        found += _look(problem, base, fitted, sights, report, _LOOKS[0])
    return found


def _enlarged(sight: Sight, place: int) -> Sight:
    """The same with a larger probe; ``place`` is that of its strength among the values."""
    strength, *shape = sight.candidate.terms
    room = max(strength.high - strength.inert, strength.inert - strength.low)
    strength = replace(strength, probe=min(_LARGER * strength.probe, room))
    start = sight.start.copy()
    start[place] = _near(strength)
    candidate = replace(sight.candidate, terms=(strength, *shape))
    return replace(sight, candidate=candidate, start=start)


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
) -> list[tuple[Sight, Sight]]:
    """What each explains where it stands, and where it would explain most."""
    used = problem.chosen
    residual, slopes = fitted.residual[used], fitted.jacobian[used]
    seen = []
    for k in range(0, len(sights), _BATCH):
        report(label, k, len(sights))
        part = sights[k : k + _BATCH]
        sets = [write((*fitted.terms, *s.candidate.terms), s.start, base) for s in part]
        for sight, row in zip(part, problem.residuals(sets), strict=True):
            if np.isfinite(row).all():
                seen += _weigh(sight, (row + fitted.refined)[used], residual, slopes, fitted)
    report(label, len(sights), len(sights))
    return seen


def _weigh(
    sight: Sight, row: FloatArray, residual: FloatArray, slopes: FloatArray, fitted: Fit
) -> list[tuple[Sight, Sight]]:
    """Judge one simulation (m,) of a candidate; nothing where it leaves no trace."""
    strength, count = sight.candidate.terms[0], len(fitted.terms)
    terms = fitted.terms
    scaled = np.array([t.scaled(v) for t, v in zip(terms, sight.start[:count], strict=True)])
    tried = sight.start[count] - strength.inert
    trace = row - residual - slopes @ (scaled - fitted.scaled)
    nothing = abs(tried) < _NOTHING * strength.probe
    if nothing or float(trace @ trace) < _INVISIBLE * trace.size:
        return []
    achieved = replace(sight, explained=float(residual @ residual - row @ row) / row.size)
    matrix = np.column_stack([slopes, trace])
    shares = sorted((end - strength.inert) / tried for end in (strength.low, strength.high))
    room = np.column_stack([fitted.bounds - fitted.scaled, shares])
    step = _least(matrix, residual, room)
    left = residual + matrix @ step
    values = natural(terms, fitted.scaled + step[:-1])
    promise = replace(
        sight,
        start=np.array([*values, strength.inert + step[-1] * tried, *sight.start[count + 1 :]]),
        explained=float(residual @ residual - left @ left) / row.size,
    )
    return [(achieved, promise)]


def _least(matrix: FloatArray, residual: FloatArray, room: FloatArray) -> FloatArray:
    """(p,) step that makes |r + M x| least within ``room`` (2, p)."""
    normal = matrix.T @ matrix
    normal += 1e-9 * np.diag(np.diag(normal)) + 1e-12 * np.eye(len(normal))
    factor = cholesky(normal)  # as small as p, and as good as all samples
    aim = solve_triangular(factor, -matrix.T @ residual, trans="T")
    step: FloatArray = lsq_linear(factor, aim, (room[0], room[1])).x
    return step
