"""Changes of a rig over time: the search for them, to first order, and their courses.

A number x that is x_0 before a day and x_0 + δ after it (a step), or grows from that day on to
x_0 + δ on the last (a ramp), or is x_0 + δ between two days (there and back), changes the residual
of recording k by J_k δ w_k with w_k in 0…1.
With A_k and b_k of `Observation`, and all shared numbers fitted with it, the best δ and the χ²
that it explains are

    δ = −β/α,   gain = β²/α,   α = Σ w_k² A_k − c C⁻¹ cᵀ,   β = Σ w_k b_k − c C⁻¹ Σ b_k,

where C = Σ A_k of the shared numbers and c = Σ w_k A_k of the number with them. The
reproducibility of a number, its standard deviation from day to day if nothing changed, is
estimated from the differences between successive days of all rigs; their median ignores a few
changes.

A number that was fitted to each recording is a series x_k with standard deviations s_k. It is x_0 +
Σ_j δ_j w_jk for the templates w_j of a course: one step, one ramp, or two steps, there and back. Of
each kind the one with the smallest z² = Σ_k (residual of x_k / s_k)² is taken; a ramp has to leave
notably less than a step. A course fits where √(z²/n) is at most 3 standard deviations, or 15 % of
the change. One that does not fit all recordings may fit all but one. If none fits, the number
varies. A change has to be significant whichever recording is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import combinations
from typing import Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike

from tendon_mj.lab.fleet.observation import SINGULAR, Label, Observation, inverse
from tendon_mj.typing import FloatArray

Course = Literal["step", "ramp", "there and back"]
Shape = Literal["step", "ramp", "there and back", "varying"]

SIGNIFICANT = 5.0  # standard deviations; among 10⁴ numbers and days one of 4.5 is to be expected
LEAST_DAYS = 2  # recordings on either side of a change
_NEAR = 0.6  # of the best gain, for a number to be looked at more closely
_MOST = 6  # numbers looked at more closely
_CLEARER = 9.0  # by which a ramp leaves less than a step [variances]
_SCATTER = 3.0  # largest rms residual of a course [standard deviations]
_CURVED = 0.15  # likewise [of the change]: a growth is seldom a straight line


@dataclass(frozen=True)
class Template:
    """A course of a change: its kind, the recording at which it begins, and the share w_k there."""

    course: Course
    first: int
    weights: FloatArray


@dataclass(frozen=True)
class Suspect:
    """A number that may have changed."""

    index: int  # of the watched number
    template: Template  # course that explains most
    change: float  # δ [probes]
    gain: float  # of χ² [noise²]
    significance: float  # change over the standard deviation expected from its reproducibility [-]


def templates(dates: Sequence[datetime]) -> list[Template]:
    """Candidate courses of a lasting change, with enough recordings before and after it begins."""
    seconds = np.array([(date - dates[0]).total_seconds() for date in dates])
    courses = list[Template]()
    for k in range(LEAST_DAYS, len(dates) - LEAST_DAYS + 1):
        courses.append(Template("step", k, (np.arange(len(dates)) >= k).astype(float)))
        before = k - 1  # the last without a change
        if k < len(dates) - LEAST_DAYS and seconds[-1] > seconds[before]:
            share = (seconds - seconds[before]) / (seconds[-1] - seconds[before])
            courses.append(Template("ramp", k, np.clip(share, 0.0, 1.0)))
    return courses


def _two_steps(dates: Sequence[datetime]) -> list[tuple[Template, Template]]:
    steps = [template for template in templates(dates) if template.course == "step"]
    return [p for p in combinations(steps, 2) if p[1].first - p[0].first >= LEAST_DAYS]


def daily_deviations(observations: Sequence[Observation]) -> dict[Label, float]:
    """Number → standard deviation from day to day [its unit], of all rigs together."""
    differences: dict[Label, list[FloatArray]] = {}
    floors: dict[Label, list[float]] = {}
    for rig in observations:
        probes = np.array([number.probe for number in rig.numbers])
        information = np.einsum("kii->ki", rig.normal)
        noise = np.sqrt(np.maximum(rig.square, 1.0))[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            best = np.where(information > 0.0, -rig.gradient / information, np.nan)  # [probes]
            floor = probes * np.median(noise / np.sqrt(information), axis=0)
        steps = probes * np.diff(best, axis=0) / np.sqrt(2.0)
        for k, number in enumerate(rig.numbers):
            differences.setdefault(number.label, []).append(steps[:, k])
            floors.setdefault(number.label, []).append(float(floor[k]))
    spreads, median = {}, scipy.stats.norm.ppf(0.75)  # of |x| of a standard normal variable
    for label, parts in differences.items():
        every = np.concatenate(parts)
        every = np.abs(every[np.isfinite(every)])
        spread = float(np.median(every) / median) if every.size else np.inf
        spreads[label] = max(spread, float(np.median(floors[label])))
    return spreads


def suspects(
    observation: Observation, dates: Sequence[datetime], spreads: Mapping[Label, float]
) -> list[Suspect]:
    """Numbers that may have changed, those that explain most first; none if nothing did.

    A change that is undone later is sought if no lasting one stands out.
    """
    undone = [
        Template("there and back", there.first, there.weights - back.weights)
        for there, back in _two_steps(dates)
    ]
    return _standing_out(observation, templates(dates), spreads) or _standing_out(
        observation, undone, spreads
    )


def _standing_out(
    observation: Observation, courses: Sequence[Template], spreads: Mapping[Label, float]
) -> list[Suspect]:
    best = dict[int, Suspect]()
    for template in courses:
        change, gain = explained(observation, template.weights)
        lever = float(np.sqrt(((template.weights - template.weights.mean()) ** 2).sum()))
        for k, number in enumerate(observation.numbers):
            if k not in best or gain[k] > best[k].gain:
                significance = float(abs(change[k])) * number.probe * lever / spreads[number.label]
                best[k] = Suspect(k, template, float(change[k]), float(gain[k]), significance)
    ranked = sorted(best.values(), key=lambda s: -s.gain)
    if not ranked or ranked[0].significance < SIGNIFICANT:
        return []
    gains = np.array([best[k].gain for k in range(len(best))])
    return [best[k] for k in most_promising(observation, gains)]


def most_promising(observation: Observation, gains: FloatArray) -> list[int]:
    """Numbers of which a change explains most, (w,) ``gains``; the first shape of each effect."""
    by_name = dict[tuple[str, str], int]()
    for k in np.argsort(-gains, kind="stable"):
        if gains[k] >= _NEAR * gains.max():
            number = observation.numbers[k]
            by_name.setdefault((number.identifier, number.name), int(k))
    return list(by_name.values())[:_MOST]


def explained(observation: Observation, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(w,) best changes [probes] and their gains [noise²] for a course (n,)."""
    normal, gradient, count = observation.normal, observation.gradient, observation.shared
    shared = slice(0, count)
    of_shared = inverse(normal[:, shared, shared].sum(axis=0))
    cross = np.einsum("k,kws->ws", weights, normal[:, :, shared])
    alone = np.einsum("k,kww->w", weights**2, normal)
    alpha = alone - np.einsum("ws,st,wt->w", cross, of_shared, cross)
    beta = weights @ gradient - cross @ of_shared @ gradient[:, shared].sum(axis=0)
    solid = alpha > SINGULAR * alone
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(solid, -beta / alpha, 0.0)
        gain = np.where(solid, beta**2 / alpha, 0.0)
    return change, gain


@dataclass(frozen=True)
class Change:
    """A change of a number of a rig."""

    # at once, "step"; growing, "ramp"; at once and later at once to a further value, "there and
    # back"; or "varying", if none of these fits
    course: Shape
    last_same: datetime  # date of the last recording without it
    since: datetime  # date of the first recording with it
    # value before and at the end [the number's unit]; of a varying number, on the first and on the
    # last day
    before: float
    after: float
    error: float  # standard error of the difference [the number's unit]
    # the least difference, whichever recording is left out, over that error [-]
    significance: float
    # of "there and back" alone, the value in between [the number's unit], and the date of the last
    # recording with it
    between: float | None = None
    until: datetime | None = None
    # date of the one recording that the course does not fit, which the values above ignore
    apart: datetime | None = None


@dataclass(frozen=True)
class _Fitted:
    """A course fitted to a series: z², x_0, (j,) δ_j and their errors, and whether it fits."""

    parts: tuple[Template, ...]
    left: float
    before: float
    changes: FloatArray
    errors: FloatArray
    fits: bool


def find_change(
    dates: Sequence[datetime],
    values: FloatArray,
    deviations: FloatArray,
    within: ArrayLike = (-math.inf, math.inf),
) -> Change:
    """The change that explains (n,) values best, which are four or more, in the order of ``dates``.

    ``deviations``: (n,) standard deviations if nothing changes, > 0; ``within``: (2,) range of
    the number, to which the values of the change are clipped.
    """
    once = _at_once_or_growing(dates, values, deviations)
    pairs = [_fit(pair, values, deviations) for pair in _two_steps(dates)]
    twice = min(pairs, key=lambda fitted: fitted.left, default=once)
    if once.fits or twice.fits:
        change = _change(once if once.fits else twice, dates, values, deviations)
    else:
        change = _but_for_one(dates, values, deviations) or replace(
            _change(once, dates, values, deviations),
            course="varying",
            last_same=dates[0],
            since=dates[1],
            before=float(values[0]),
            after=float(values[-1]),
        )
    low, high = np.asarray(within, float)
    before, after = (float(np.clip(x, low, high)) for x in (change.before, change.after))
    between = None if change.between is None else float(np.clip(change.between, low, high))
    return replace(change, before=before, after=after, between=between)


def _at_once_or_growing(
    dates: Sequence[datetime], values: FloatArray, deviations: FloatArray
) -> _Fitted:
    fits = [_fit((template,), values, deviations) for template in templates(dates)]
    best = {
        course: min((f for f in fits if f.parts[0].course == course), key=lambda f: f.left)
        for course in {f.parts[0].course for f in fits}
    }
    if "ramp" in best and best["ramp"].left < best["step"].left - _CLEARER:
        return best["ramp"]
    return best["step"]


def _but_for_one(
    dates: Sequence[datetime], values: FloatArray, deviations: FloatArray
) -> Change | None:
    """The step or ramp that fits all recordings but one, if there are enough for that."""
    best: tuple[float, Change] | None = None
    for k in range(len(dates) if len(dates) > 2 * LEAST_DAYS else 0):
        others = [*dates[:k], *dates[k + 1 :]]
        rest = np.delete(values, k), np.delete(deviations, k)
        fitted = _at_once_or_growing(others, *rest)
        if fitted.fits and (best is None or fitted.left < best[0]):
            change = _change(fitted, others, *rest)
            best = fitted.left, replace(change, apart=dates[k])
    return best and best[1]


def _change(
    fitted: _Fitted, dates: Sequence[datetime], values: FloatArray, deviations: FloatArray
) -> Change:
    first, *back = fitted.parts
    after = fitted.before + float(fitted.changes.sum())
    larger = int(np.argmax(np.abs(fitted.changes)))
    error = float(fitted.errors[larger])
    least = _least(fitted, larger, values, deviations)
    change = Change(
        course=first.course,
        last_same=dates[first.first - 1],
        since=dates[first.first],
        before=fitted.before,
        after=after,
        error=error,
        significance=least / error if error > 0.0 else 0.0,
    )
    if not back:
        return change
    between, until = fitted.before + float(fitted.changes[0]), dates[back[0].first - 1]
    return replace(change, course="there and back", between=between, until=until)


def _least(fitted: _Fitted, part: int, values: FloatArray, deviations: FloatArray) -> float:
    """Least size of a part's change, whichever recording is left out; 0 if its sign changes."""
    change = float(fitted.changes[part])
    sizes = [0.0] if change == 0.0 else []
    for k in range(len(values)):
        parts = tuple(replace(t, weights=np.delete(t.weights, k)) for t in fitted.parts)
        without = _fit(parts, np.delete(values, k), np.delete(deviations, k))
        sizes.append(np.sign(change) * without.changes[part])
    return max(0.0, float(min(sizes)))


def _fit(parts: tuple[Template, ...], values: FloatArray, deviations: FloatArray) -> _Fitted:
    columns = [np.ones_like(values), *(template.weights for template in parts)]
    matrix = np.column_stack(columns) / deviations[:, None]
    scaled = values / deviations
    solution = np.asarray(np.linalg.lstsq(matrix, scaled, rcond=None)[0], float)
    errors: FloatArray = np.sqrt(np.diag(np.linalg.pinv(matrix.T @ matrix, hermitian=True)))
    left = float(((scaled - matrix @ solution) ** 2).sum())
    size = float(np.abs(solution[1:]).max()) / deviations
    allowed = max(_SCATTER**2, float(np.mean((_CURVED * size) ** 2)))
    fits = left <= allowed * len(values)
    return _Fitted(parts, left, float(solution[0]), solution[1:], errors[1:], fits)
