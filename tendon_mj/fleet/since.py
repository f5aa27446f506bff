"""Since when a series of values is another: a step or a ramp, by least squares.

A series x_k with standard deviations s_k is x_0 + δ w_k for a template w; for each the best x_0 and
δ are those of weighted least squares, and the template with the smallest sum of squares is taken.
A ramp has to leave notably less than a step to be one. A change has to be large, measured by its
standard error, whichever recording is left out, so that one odd day is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tendon_mj.fleet.changes import Course, Template, templates

FloatArray = NDArray[np.float64]

_CLEARER = 9.0  # by which a ramp leaves less than a step [variances]


@dataclass(frozen=True)
class Change:
    """A change of a number of a rig.

    Attributes:
        course: at once, "step", or growing, "ramp".
        last_same: date of the last recording without it.
        since: date of the first recording with it.
        before, after: value before and at the end [the number's unit].
        error: standard error of the difference [the number's unit].
        significance: the least difference, whichever recording is left out, over that error [-].
    """

    course: Course
    last_same: datetime
    since: datetime
    before: float
    after: float
    error: float
    significance: float


def find_change(dates: Sequence[datetime], values: FloatArray, deviations: FloatArray) -> Change:
    """The change that explains a series best.

    Args:
        dates: of the values, growing; four at least.
        values: (n,) day by day.
        deviations: (n,) standard deviations where nothing changes, > 0.
    """
    fits = [(_fit(t, values, deviations), t) for t in templates(dates)]
    best = {
        course: min(((f, t) for f, t in fits if t.course == course), key=lambda p: p[0][0])
        for course in {t.course for _, t in fits}
    }
    (left, before, change, error), template = best["step"]
    if "ramp" in best and best["ramp"][0][0] < left - _CLEARER:
        (left, before, change, error), template = best["ramp"]
    return Change(
        course=template.course,
        last_same=dates[template.first - 1],
        since=dates[template.first],
        before=before,
        after=before + change,
        error=error,
        significance=_least(change, template, values, deviations) / error if error > 0.0 else 0.0,
    )


def _least(change: float, template: Template, values: FloatArray, deviations: FloatArray) -> float:
    """The least size of a change, whichever recording is left out; 0 if it turns about."""
    sizes = [0.0] if change == 0.0 else []
    for k in range(len(values)):
        used = np.arange(len(values)) != k
        some = replace(template, weights=template.weights[used])
        sizes.append(np.sign(change) * _fit(some, values[used], deviations[used])[2])
    return max(0.0, float(min(sizes)))


def _fit(
    template: Template, values: FloatArray, deviations: FloatArray
) -> tuple[float, float, float, float]:
    """Sum of squares left, value before, change, and its standard error."""
    matrix = np.column_stack([np.ones_like(values), template.weights]) / deviations[:, None]
    scaled = values / deviations
    solution, *_ = np.linalg.lstsq(matrix, scaled, rcond=None)
    covariance = np.linalg.pinv(matrix.T @ matrix, hermitian=True)
    left = float(((scaled - matrix @ solution) ** 2).sum())
    return left, float(solution[0]), float(solution[1]), float(np.sqrt(covariance[1, 1]))
