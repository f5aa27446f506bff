"""Statistics of fits: cross-validation, comparison of models, 95 % intervals, correlations.

Cross-validation leaves the parts of a `Problem` out of the fit in turn: blocks of time, or whole
recordings if these are of different states of the rig. To first order the refit is one
Gauss-Newton step from the common solution and needs no simulation: with J_b, r_b the rows of part b
and W the weights of terms with an expected spread,

    Δ_b = (JᵀJ + W² − J_bᵀJ_b)⁻¹ J_bᵀ r_b,     left-out residual r_b + J_b Δ_b,

with Δ_b held within the terms' ranges. This holds near a minimum, where the response is linear. A
part of which it foretells far more than the fit leaves is left out of another fit, as where a fit
was stopped on its way, or a friction starts the other way round for other values. A value that was
set anew for a recording is determined by no other one: with that recording left out, its own terms
are held in Δ_b, and then fitted to it. With an effect whose cost is non-smooth the linearisation
does not hold, so no block is left out and the held-out data alone can refute the effect.
Neighbouring residuals are correlated, as model and rig differ by more than white noise. Models are
therefore compared block by block, never sample by sample, and intervals come from how the gradient
varies between whole blocks of time (a clustered sandwich estimate):

    Cov = A⁻¹ (Σ_b g_b g_bᵀ) A⁻¹,   A = JᵀJ,   g_b = J_bᵀ r_b.

Unmodelled structure biases the values: an error of mean square g with correlation ρ to a column of
J shifts the value by ρ √(g m (A⁻¹)_kk). The fit has removed the correlated part from the residual,
so ρ = 0.2 is assumed of the rest; the error of the simulation's step is added to g. Where the error
e of sheaths lumped into guides was measured, by twice as many guides, the shift |A⁻¹ Jᵀ e| that it
causes is added to half of the interval. While a value moves, those that compensate it stay within
their ranges, on the side to which they go; one that neither data nor ranges hold has no interval.
If recordings are of different states of the rig, blocks of one recording repeat each other too. The
interval is then no narrower than that of the jackknife over recordings, of variance
(R−1)/R Σ_b Δ_b², with Δ_b the shift of the value where recording b is left out of the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import Problem, step_error
from tendon_mj.lab.diagnosis.effects.effect import Candidate
from tendon_mj.lab.diagnosis.fitting import (
    Fit,
    bounded_least_squares,
    differences,
    inward,
    natural_in_range,
    rings,
    written,
)
from tendon_mj.lab.diagnosis.limits import STANDARD_ERRORS
from tendon_mj.lab.replay import suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_LEVEL = 0.95
_ROUNDING = 1e-12  # singular value of J with columns of length 1
_PART = 0.1  # of a term in a direction of which nothing is told
_LEAST_ROOM = 1e-3  # to an end of a range, of the probe of a term
_FAR = 4.0  # left-out χ² over that in the fit, beyond which the others are fitted again
_MATTERS = 0.1  # of the χ² of all parts, that it must be worth
_MOST_REFITTED = 3  # parts
_SIGMAS = 3.0  # standard deviations of what chance makes of a sum of squares
_WIDENED = 2  # times that a width follows the one before
_COMPENSATED = 3  # simulations of a move, each with the others fitted to the one before, at most
_CLOSE = 0.02  # of a change or a width, by which it need not come nearer
_CORRELATION = 0.2  # ρ, of unmodelled structure with a column of J


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """Cross-validated χ² of a model."""

    chi2: FloatArray  # (parts,) sum of squared left-out residuals in units of noise
    samples: int  # number in all parts

    @property
    def excess(self) -> float:
        """Reduced χ² − 1 [-]; below 0 by chance."""
        return float(self.chi2.sum()) / self.samples - 1.0


def cross_validate(
    problem: Problem, fit: Fit, refit: Callable[[int], Fit] | None = None
) -> CrossValidation:
    """Cross-validate a fit on the training data.

    ``refit`` maps a part to a fit of the same terms to all others; see above for where it is asked.
    """
    used = problem.in_train
    residual, parts = fit.residual[used], problem.parts[used]
    refitted = fit.free & (not any(candidate.effect.non_smooth for candidate in fit.effects))
    jacobian = fit.jacobian[used][:, refitted]
    names, part_of = np.unique(parts, return_inverse=True)
    weights, shared = fit.weights[refitted] ** 2, fit.shared[refitted]
    normal = jacobian.T @ jacobian
    chi2, own_terms = np.empty(names.size), []
    room = (fit.bounds - fit.scaled)[:, refitted]
    regular = np.diag(1e-9 * np.diag(normal) + weights)
    for b in range(names.size):
        rows = part_of == b
        j, r = jacobian[rows], residual[rows]
        own = ~shared & ~jacobian[~rows].any(axis=0)  # of this recording alone
        kept = ~own
        shift = np.zeros(j.shape[1])
        if kept.any():
            others = (normal + regular - j.T @ j)[np.ix_(kept, kept)]
            shift[kept] = np.linalg.lstsq(others, j[:, kept].T @ r, rcond=None)[0]
            shift = np.clip(shift, *room)
        if own.any():
            alone = j[:, own].T @ j[:, own] + regular[np.ix_(own, own)]
            shift[own] = -np.linalg.solve(alone, j[:, own].T @ (j @ shift))
        r = r + j @ shift
        chi2[b] = float(r @ r)
        own_terms.append(own)
    inside = np.bincount(part_of, residual**2)
    beyond = np.where(chi2 > _FAR * inside, chi2 - inside, 0.0)
    for b in np.argsort(-beyond)[:_MOST_REFITTED]:
        if refit is None or beyond[b] <= _MATTERS * chi2.sum():
            break
        again, rows, own = refit(int(names[b])), part_of == b, own_terms[b]
        r, j = again.residual[used][rows], again.jacobian[used][rows][:, refitted][:, own]
        pull = j.T @ r + (weights * again.scaled[refitted])[own]
        r = r - j @ np.linalg.solve(j.T @ j + regular[np.ix_(own, own)], pull)
        chi2[b] = float(r @ r) if np.isfinite(r).all() else chi2[b]
    return CrossValidation(chi2, int(used.sum()))


@dataclass(frozen=True)
class Gain:
    """Reduction of the cross-validated reduced χ² from one model to another."""

    mean: float  # difference of the reduced χ² [-]
    # of the mean [-]. An effect may show in two blocks of thirty and be certain; only the blocks
    # that it makes worse speak against it. By chance as many improve by as much, hence √(2 Σ
    # worse²)
    standard_error: float


def gain(before: CrossValidation, after: CrossValidation) -> Gain:
    """Gain of the second model over the first."""
    difference = before.chi2 - after.chi2
    worse = np.minimum(difference, 0.0)
    error = float(np.sqrt(2.0 * worse @ worse))
    return Gain(float(difference.sum()) / before.samples, error / before.samples)


@dataclass(frozen=True, eq=False)
class FittedCandidate:
    """A model fitted with a candidate effect, and its cross-validation."""

    # effect that was added or swapped in last; None for the calibrated model
    candidate: Candidate | None
    fit: Fit  # of all terms of the model
    validation: CrossValidation  # on blocks left out of the fit

    def __repr__(self) -> str:
        model = self.candidate.label if self.candidate else "calibrated model"
        return f"FittedCandidate({model}: excess χ² {self.excess:.3g})"

    @property
    def excess(self) -> float:
        """Cross-validated excess χ² (reduced χ² − 1) [-]."""
        return self.validation.excess

    @property
    def added(self) -> Candidate:
        """The candidate of a model that has one."""
        assert self.candidate is not None
        return self.candidate

    @property
    def determined(self) -> bool:
        """Whether the candidate's strength is held by the data, not by an end of its range."""
        return self.fit.determines(self.added)


def tied(best: FittedCandidate, other: FittedCandidate) -> bool:
    """Return whether the data cannot tell the two models apart."""
    lost = gain(other.validation, best.validation)
    return lost.mean < max(STANDARD_ERRORS * lost.standard_error, tie_width(best))


def tie_width(best: FittedCandidate) -> float:
    """Insignificant difference of excess χ²: a quarter of the excess of the best model."""
    return 0.02 + 0.25 * max(best.excess, 0.0)


def simplest(ranked: Sequence[FittedCandidate]) -> FittedCandidate:
    """Simplest model tied with the first.

    Single parameters before effects, effects of the rig before those of its sensors, and few terms
    before many.
    """
    equal = [model for model in ranked if tied(ranked[0], model)]
    return min(equal, key=lambda model: (_complexity(model.candidate), model.excess))


def is_wrong_number(model: FittedCandidate) -> bool:
    """Return whether the last effect of a model is a number that the model had wrong."""
    return not _complexity(model.candidate)[0]


def _complexity(candidate: Candidate | None) -> tuple[bool, bool, int]:
    if candidate is None:
        return (False, False, 0)
    count = len(candidate.terms)
    return (candidate.effect.kind == "missing" or count > 1, candidate.on_sensor, count)


@dataclass(frozen=True, eq=False)
class SelectedEffect:
    """An effect in the final model, and its rivals."""

    candidate: Candidate  # the effect
    rivals: tuple[Candidate, ...]  # others that the data cannot tell from it
    confidence: float  # that it is this one and not another effect, 0 … 1
    # those that were fitted with the rivals, in their order
    models: tuple[FittedCandidate, ...] = ()


def rate_effect(candidate: Candidate, ranked: Sequence[FittedCandidate]) -> SelectedEffect:
    """Compare an effect with the models it was chosen from, best first.

    With d_k the χ² that another effect k leaves more and w_k the width of a tie, the confidence is
    1/(1 + Σ_k exp(−d_k/w_k)).
    """
    own = next((m for m in ranked if m.candidate == candidate), ranked[0])
    rivals, models, odds = list[Candidate](), list[FittedCandidate](), 1.0
    for model in ranked:
        other = model.candidate
        if other is None or other == candidate:
            continue
        lost = gain(model.validation, own.validation)
        useless = lost.mean > -STANDARD_ERRORS * lost.standard_error
        if len(other.terms) > len(candidate.terms) and useless:
            continue  # more terms, and nothing gained by them
        width = max(lost.standard_error, tie_width(own))
        if other.identifier != candidate.identifier:
            odds += float(np.exp(-max(lost.mean, 0.0) / width))
        if tied(own, model):
            rivals.append(other)
            models.append(model)
    return SelectedEffect(candidate, tuple(rivals), 1.0 / odds, tuple(models))


def intervals(
    problem: Problem,
    fit: Fit,
    refits: Sequence[Fit] = (),
    moving: NDArray[np.bool_] | None = None,
) -> FloatArray:
    """(p, 2) 95 % intervals of a fit's values [the terms' units]; the range where not free.

    ``refits`` are of the same model, with each recording left out in turn. A calibrated term or a
    strength at an end of its range, beyond which the data would not take it, may still trade
    places with others: it counts as free in theirs. ``moving`` (p,) are other terms to count so.
    """
    ranges = np.array([[term.low, term.high] for term in fit.terms]).reshape(-1, 2)
    moving = fit.free | at_rest_on_bounds(problem, fit) if moving is None else moving
    reach = sides(problem, fit, moving)
    if len(refits) > 1:
        reach = np.maximum(reach, _jackknife(fit, refits))
    for k in np.flatnonzero(fit.free):
        term, (below, above) = fit.terms[k], reach[:, k]
        ends = [term.natural(scaled) for scaled in (fit.scaled[k] - below, fit.scaled[k] + above)]
        ranges[k] = np.clip(sorted(ends), *sorted(ranges[k]))
    return ranges


@suppress_unsolved_warnings()
def over_intervals(
    problem: Problem, base: Mapping[str, float], fit: Fit, near: tuple[float, float]
) -> Fit:
    """The fit with a Jacobian J that holds over its intervals.

    Over a distance the response to a small step is of no use if friction sticks or a play closes,
    and values that compensate each other do so along a curve. Each number is therefore moved to
    the ends of its interval, and all others are fitted to it. Of its two moves that which changes
    the residual less is a column of S (p, k), and the change one of R (m, k). J is corrected to
    J S = R, of which what is random in a simulation that rings, by the `near_differences`, takes
    its part off.
    """
    numbers = np.flatnonzero(fit.free & fit.shared)
    random = near[1] / np.sqrt(3.0)  # in a difference of two simulations
    least = 0.0
    if rings(near):  # less than a probe is moved by is lost in what rounding does
        fit, least = _over_a_probe(problem, base, fit, numbers), 1.0
    for _ in range(_WIDENED if numbers.size else 0):
        halves = half_widths(problem, fit, fit.free)
        distances = np.maximum(halves[numbers], least)
        moves = _least_moves(problem, base, fit, numbers, distances)
        steps, changes = (np.column_stack(part) for part in zip(*moves, strict=True))
        left, _, right = np.linalg.svd(changes, full_matrices=False)
        by_chance = 0.5 * random**2 * (np.eye(numbers.size) + 1.0)  # all from one simulation
        by_chance *= 1.0 + _SIGMAS * np.sqrt(2.0 / np.count_nonzero(problem.in_train))
        squares, ways = np.linalg.eigh(changes.T @ changes - by_chance)
        changes = left @ right @ (ways * np.sqrt(np.maximum(squares, 0.0))) @ ways.T
        lengths = np.maximum(np.abs(steps).max(axis=1)[numbers], np.finfo(float).tiny)
        by_length = np.linalg.pinv(steps[numbers] / lengths[:, None], _PART)
        over = fit.jacobian.copy()
        over[:, numbers] += (changes - fit.jacobian @ steps) @ by_length / lengths
        wider = replace(fit, jacobian=np.where(fit.jacobian == 0.0, 0.0, over))
        grown, before = half_widths(problem, wider, fit.free).sum(), halves.sum()
        if not grown > before:
            break  # values that compensate each other nearby do so less far off
        fit = wider
        if grown < (1.0 + _CLOSE) * before:
            break
    return fit


def _over_a_probe(
    problem: Problem, base: Mapping[str, float], fit: Fit, numbers: NDArray[np.intp]
) -> Fit:
    """The fit with derivatives by some terms over a probe of each, inward."""
    point, jacobian = fit.scaled, fit.jacobian.copy()
    room = np.abs(fit.bounds.mean(axis=0) - point)
    moved = np.isin(np.arange(point.size), numbers)
    step = inward(point, fit.bounds) * np.minimum(1.0, room) * moved

    def parameters(scaled: FloatArray) -> dict[str, float]:
        return written(fit.terms, natural_in_range(fit.terms, scaled), base)

    there = differences(problem, fit.terms, parameters, point, step, fit.residual - fit.correction)
    found = np.isfinite(there).all(axis=0) & (step != 0.0)
    jacobian[:, found] = there[:, found]
    return replace(fit, jacobian=jacobian)


def _least_moves(
    problem: Problem,
    base: Mapping[str, float],
    fit: Fit,
    numbers: NDArray[np.intp],
    distances: FloatArray,
) -> list[tuple[FloatArray, FloatArray]]:
    """Moves (p,) by which each number goes that far to either side, and the changes (m,) by them.

    Where a simulation fails, the move and the change are those to its other side, or 0. All others
    are fitted until that promises to lessen no change by more than its share `_CLOSE`.
    """
    used, room = problem.in_train, fit.bounds - fit.scaled
    jacobian, left = fit.jacobian[used], fit.residual[used]
    least = dict.fromkeys(numbers, np.inf)
    found = {k: (np.zeros(fit.scaled.size), np.zeros(used.size)) for k in numbers}
    moves = {}
    for k, distance in zip(numbers, distances, strict=True):
        for way in (-1.0, 1.0):
            move = np.zeros(fit.scaled.size)
            move[k] = np.clip(way * distance, *room[:, k])
            if move[k] != 0.0:
                moves[k, way] = move
    changes = {key: fit.jacobian @ move for key, move in moves.items()}
    for again in range(_COMPENSATED):
        for key, move in list(moves.items()):
            others = fit.free & (np.arange(move.size) != key[0])
            slopes, change, within = jacobian[:, others], changes[key][used], room - move
            step = np.zeros(0)
            if others.any():
                step = bounded_least_squares(slopes, left + change, within[:, others])
            less = np.sum((change + slopes @ step) ** 2) < (1.0 - _CLOSE) * np.sum(change**2)
            if again and not less:
                del moves[key]
            else:
                move[others] += step
        if not moves:
            break
        values = [natural_in_range(fit.terms, fit.scaled + move) for move in moves.values()]
        there = problem.residuals([written(fit.terms, v, base) for v in values])
        for (key, move), simulated in zip(list(moves.items()), there, strict=True):
            changes[key] = change = simulated - (fit.residual - fit.correction)
            if not np.isfinite(change).all():
                del moves[key]
                continue
            slope = float(np.mean(change[used] ** 2) / move[key[0]] ** 2)
            if slope < least[key[0]]:
                least[key[0]], found[key[0]] = slope, (move.copy(), change)
    return list(found.values())


def correlation_matrix(problem: Problem, fit: Fit, chosen: NDArray[np.bool_]) -> FloatArray:
    """(k, k) correlations of the estimates of ``chosen`` (p,) terms, with the others free.

    Those of independent residuals, A⁻¹ scaled to a unit diagonal.
    """
    free = fit.free | chosen
    jacobian = fit.jacobian[problem.in_train][:, free]
    solved = _pseudo_inverse(jacobian)
    inverse = solved @ solved.T
    scale = 1.0 / np.sqrt(np.maximum(np.diag(inverse), np.finfo(float).tiny))
    correlations: FloatArray = (inverse * np.outer(scale, scale))[chosen[free]][:, chosen[free]]
    return np.clip(correlations, -1.0, 1.0)


def beyond_range(problem: Problem, fit: Fit, near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(p,) which of the terms ``near`` a bound the data would take beyond it.

    By more than half of the 95 % interval that they would have without the bound.
    """
    used, freed = problem.in_train, (fit.free | near) & (np.abs(fit.jacobian).max(axis=0) > 0.0)
    jacobian = fit.jacobian[used][:, freed]
    step = np.zeros(len(fit.terms))
    step[freed] = -np.linalg.pinv(jacobian) @ fit.residual[used]
    half = half_widths(problem, fit, freed)
    low, high = fit.bounds
    out = np.where(
        fit.scaled > 0.5 * (low + high), fit.scaled + step - high, low - fit.scaled - step
    )
    beyond: NDArray[np.bool_] = near & freed & (out > half)
    return beyond


def on_bounds(fit: Fit) -> NDArray[np.bool_]:
    """(p,) which calibrated terms and strengths are held by a bound, the same in all recordings."""
    numbers = np.arange(len(fit.terms)) < len(fit.calibrated)
    for candidate in fit.effects:
        numbers[fit.terms_of(candidate).start] = True
    visible = np.abs(fit.jacobian).max(axis=0, initial=0.0) > 0.0
    held: NDArray[np.bool_] = numbers & fit.shared & visible & ~fit.free
    return held


def at_rest_on_bounds(problem: Problem, fit: Fit) -> NDArray[np.bool_]:
    """(p,) which of the terms `on_bounds` would not go beyond without the bound."""
    held = on_bounds(fit)
    return held & ~beyond_range(problem, fit, held) if held.any() else held


def half_widths(problem: Problem, fit: Fit, free: NDArray[np.bool_]) -> FloatArray:
    """(p,) the longer of the `sides`."""
    longer: FloatArray = sides(problem, fit, free).max(axis=0)
    return longer


def sides(problem: Problem, fit: Fit, free: NDArray[np.bool_]) -> FloatArray:
    """(2, p) how far the 95 % intervals reach below and above scaled terms; 0 if not ``free``.

    While a term moves the others stay within their ranges: in 95 % of cases they go no farther than
    to the end that they go to.
    """
    used, terms = problem.in_train, np.flatnonzero(free)
    jacobian, residual = fit.jacobian[used][:, free], fit.residual[used]
    blocks = problem.blocks[used]
    names = np.unique(blocks)
    basis, triangle = np.linalg.qr(jacobian)  # QR = J, with all its digits where terms are alike
    scores = np.array([basis[blocks == b].T @ residual[blocks == b] for b in names])
    solved = _pseudo_inverse(triangle)
    clusters = np.sum((solved @ scores.T) ** 2, axis=1)
    clusters *= names.size / max(names.size - free.sum(), 1)
    alone = np.maximum(np.sum(solved**2, axis=1), np.finfo(float).tiny)
    remains = max(float(np.mean(residual**2)) - 1.0, 0.0) + step_error(fit.correction[used])
    larger = np.maximum(clusters / alone, 1.0)
    larger += _CORRELATION**2 * remains * residual.size  # variance over that of independent noise
    quantile = float(scipy.stats.t.ppf(0.5 + _LEVEL / 2.0, max(names.size - int(free.sum()), 1)))
    room = np.maximum(np.abs(fit.bounds - fit.scaled)[:, free], _LEAST_ROOM)
    shift = np.zeros(alone.size) if problem.lumped is None else jacobian.T @ problem.lumped[used]
    reach: FloatArray = np.where(free, [[np.inf], [np.inf]], 0.0)
    for k, variance in enumerate(larger):
        held = np.sqrt(variance) * quantile / room
        goes_with = _row(triangle, k, held.min(axis=0))
        for side, sign in enumerate((-1.0, 1.0)):
            row = _row(triangle, k, np.where(sign * goes_with > 0.0, held[1], held[0]))
            if row[k] > 0.0:
                reach[side, terms[k]] = quantile * np.sqrt(variance * row[k]) + abs(
                    float(row @ shift)
                )
    return reach


def _row(triangle: FloatArray, k: int, held: FloatArray) -> FloatArray:
    """Row ``k`` of the inverse of JᵀJ, where the others count as residuals times ``held`` (p,).

    0 if the data tell nothing of term k.
    """
    others = np.where(np.arange(held.size) == k, 0.0, held)
    solved = _pseudo_inverse(np.vstack([triangle, np.diag(others)]))
    row: FloatArray = solved @ solved[k]
    return row


def with_slope(fit: Fit, candidate: Candidate, slope: FloatArray) -> Fit:
    """A fit whose Jacobian has the ``slope`` (m,) of a further effect, with its range."""
    strength = candidate.terms[0]
    ends = sorted((strength.scaled(strength.low), strength.scaled(strength.high)))
    return replace(
        fit,
        jacobian=np.column_stack([fit.jacobian, slope]),
        scaled=np.append(fit.scaled, strength.scaled(strength.inert)),
        bounds=np.column_stack([fit.bounds, ends]),
    )


def _jackknife(fit: Fit, refits: Sequence[Fit]) -> FloatArray:
    """(p,) half of the 95 % intervals of the scaled terms from leaving out whole recordings."""
    shifts = np.array([refitted.scaled for refitted in refits]) - fit.scaled
    count = len(refits)
    quantile = scipy.stats.t.ppf(0.5 + _LEVEL / 2.0, count - 1)
    widths: FloatArray = quantile * np.sqrt((count - 1) / count * (shifts**2).sum(axis=0))
    return widths


def _pseudo_inverse(matrix: FloatArray) -> FloatArray:
    """(p, n) pseudo-inverse of M (n, p); a row is 0 of a term that has a part in no row of M."""
    lengths = np.linalg.norm(matrix, axis=0)
    seen = lengths > 0.0
    left, values, vectors = np.linalg.svd(matrix[:, seen] / lengths[seen], full_matrices=False)
    kept = values > _ROUNDING
    told = (np.abs(vectors[~kept]) < _PART).all(axis=0)
    part = (vectors[kept].T / values[kept]) @ left[:, kept].T
    inverse = np.zeros((lengths.size, len(matrix)))
    inverse[seen] = part * (told / lengths[seen])[:, None]
    return inverse
