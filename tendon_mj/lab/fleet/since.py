"""Since when a series of values is another: the course that fits it, by weighted least squares.

A series x_k with standard deviations s_k is x_0 + Σ_j δ_j w_jk for the templates w_j of a course:
one step, one ramp, or two steps, there and back. Of each kind the one with the smallest sum of
squares z² = Σ_k (what is left of x_k / s_k)² is taken; a ramp has to leave notably less than a step
to be one. A course fits where what it leaves, √(z²/n), is no more than 3 standard deviations, or
than 15 % of the change. One that does not fit all recordings may fit all but one, which is then
told apart. Where none fits, the number varies.

A change has to be large, measured by its standard error, whichever recording is left out, so that
one odd day is none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.lab.fleet.changes import LEAST_DAYS, Template, templates
from tendon_mj.typing import FloatArray

Shape = Literal["step", "ramp", "there and back", "varying"]

_CLEARER = 9.0  # by which a ramp leaves less than a step [variances]
_SCATTER = 3.0  # root mean square of what a course may leave [standard deviations]
_CURVED = 0.15  # likewise [of the change]: a growth is seldom a straight line


@dataclass(frozen=True)
class Change:
    """A change of a number of a rig.

    Attributes:
        course: at once, "step"; growing, "ramp"; at once and later at once to a further value,
            "there and back"; or "varying", where none of these fits.
        last_same: date of the last recording without it.
        since: date of the first recording with it.
        before, after: value before and at the end [the number's unit]; of what varies, on the first
            and on the last day.
        error: standard error of the difference [the number's unit].
        significance: the least difference, whichever recording is left out, over that error [-].
        between, until: of "there and back" alone, the value since then [the number's unit], and the
            date of the last recording with it.
        apart: date of the one recording that the course does not fit; it decides none of the
            values above.
    """

    course: Shape
    last_same: datetime
    since: datetime
    before: float
    after: float
    error: float
    significance: float
    between: float | None = None
    until: datetime | None = None
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
    """The change that explains a series best.

    Args:
        dates: of the values, growing; four at least.
        values: (n,) day by day.
        deviations: (n,) standard deviations where nothing changes, > 0.
        within: (2,) what the number may be; a course that ends a little beyond is told at its end.
    """
    change = _best_change(dates, values, deviations)
    low, high = np.asarray(within, float)

    def told(value: float) -> float:
        return float(np.clip(value, low, high))

    between = None if change.between is None else told(change.between)
    return replace(change, before=told(change.before), after=told(change.after), between=between)


def _best_change(dates: Sequence[datetime], values: FloatArray, deviations: FloatArray) -> Change:
    once = _at_once_or_growing(dates, values, deviations)
    for found in (once, _there_and_back(dates, values, deviations)):
        if found is not None and found.fits:
            return _change(found, dates, values, deviations)
    return _but_for_one(dates, values, deviations) or replace(
        _change(once, dates, values, deviations),
        course="varying",
        last_same=dates[0],
        since=dates[1],
        before=float(values[0]),
        after=float(values[-1]),
    )


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


def _there_and_back(
    dates: Sequence[datetime], values: FloatArray, deviations: FloatArray
) -> _Fitted | None:
    steps = [template for template in templates(dates) if template.course == "step"]
    pairs = [p for p in combinations(steps, 2) if p[1].first - p[0].first >= LEAST_DAYS]
    fits = [_fit(pair, values, deviations) for pair in pairs]
    return min(fits, key=lambda f: f.left, default=None)


def _but_for_one(
    dates: Sequence[datetime], values: FloatArray, deviations: FloatArray
) -> Change | None:
    """The step or ramp that fits all recordings but one, where there are enough for that."""
    found: dict[int, _Fitted] = {}
    for k in range(len(dates) if len(dates) > 2 * LEAST_DAYS else 0):
        used = np.arange(len(dates)) != k
        others = [date for date, is_used in zip(dates, used, strict=True) if is_used]
        found[k] = _at_once_or_growing(others, values[used], deviations[used])
    fitting = {k: one for k, one in found.items() if one.fits}
    if not fitting:
        return None
    odd = min(fitting, key=lambda k: fitting[k].left)
    used = np.arange(len(dates)) != odd
    others = [date for date in dates if date != dates[odd]]
    change = _change(fitting[odd], others, values[used], deviations[used])
    return replace(change, apart=dates[odd])


def _change(
    found: _Fitted, dates: Sequence[datetime], values: FloatArray, deviations: FloatArray
) -> Change:
    first, *back = found.parts
    after = found.before + float(found.changes.sum())
    larger = int(np.argmax(np.abs(found.changes)))
    error = float(found.errors[larger])
    least = _least(found, larger, values, deviations)
    change = Change(
        course=first.course,
        last_same=dates[first.first - 1],
        since=dates[first.first],
        before=found.before,
        after=after,
        error=error,
        significance=least / error if error > 0.0 else 0.0,
    )
    if not back:
        return change
    between, until = found.before + float(found.changes[0]), dates[back[0].first - 1]
    return replace(change, course="there and back", between=between, until=until)


def _least(found: _Fitted, part: int, values: FloatArray, deviations: FloatArray) -> float:
    """The least size of a part's change, whichever recording is left out; 0 if it turns about."""
    change = float(found.changes[part])
    sizes = [0.0] if change == 0.0 else []
    for k in range(len(values)):
        used = np.arange(len(values)) != k
        some = tuple(replace(t, weights=t.weights[used]) for t in found.parts)
        sizes.append(np.sign(change) * _fit(some, values[used], deviations[used]).changes[part])
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
