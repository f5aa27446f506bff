"""A number of a rig day by day: fitted to each recording, everything else to all recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from tendon_mj.lab.diagnosis import Term, fit
from tendon_mj.lab.fleet.observation import (
    Calibrated,
    Number,
    Watched,
    calibrate,
    mean_squares,
)
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import name_in_session
from tendon_mj.typing import FloatArray

_CONVERGED = 6  # evaluations, from near the best values
_NOTABLE = 0.01  # of the residual of the better one, likewise
_RESOLVED = 2.0  # standard errors of the mean, by which two explanations differ


@dataclass(frozen=True, eq=False)
class NumberSeries:
    """A number day by day.

    Attributes:
        number: its names.
        parameter, unit: the first parameter that it writes, and that one's unit.
        values: (n,) of that parameter [unit].
        errors: (n,) standard errors from noise [unit].
        probe: change of the parameter for a probe of the number [unit].
        range: (2,) within which the parameter is fitted [unit].
        square: (n,) mean square residual of each recording [noise²].
        others: parameter → value, of those fitted to all recordings with it.
    """

    number: Number
    parameter: str
    unit: str
    probe: float
    values: FloatArray
    errors: FloatArray
    square: FloatArray
    range: FloatArray
    others: dict[str, float]


def fit_series(
    recordings: Sequence[Recording],
    model: mujoco.MjModel,
    start: Sequence[float],
    suspects: Mapping[Number, Sequence[float]],
) -> list[NumberSeries]:
    """Fit each of some numbers day by day; the one that explains most first.

    ``start``: values of all terms, see `Observation`; ``suspects``: number → its first-order change
    on each day, (n,) [probes].
    """
    rig = calibrate(recordings, model, start)
    names = [recording.name for recording in recordings]
    fitted = [
        _series(rig, watched, suspects[watched.number], names)
        for watched in rig.watched
        if watched.number in suspects
    ]
    return sorted(fitted, key=lambda series: float(series.square.mean()))


def _series(
    rig: Calibrated, watched: Watched, changes: Sequence[float], names: Sequence[str]
) -> NumberSeries:
    term, count = watched.term, len(names)
    own = [
        replace(term, targets=tuple(name_in_session(t, name) for t in term.targets), spread=0.0)
        for name in names
    ]
    pairs = zip(rig.fit.terms, rig.fit.values, strict=True)
    kept = [(other, x) for other, x in pairs if not {*other.targets} & {*term.targets}]
    daily = np.clip(watched.value + term.probe * np.array(changes), term.low, term.high)
    fitted = fit(
        rig.problem,
        rig.base,
        (*(other for other, _ in kept), *watched.shape, *own),
        (),
        np.array([*(x for _, x in kept), *watched.number.shape, *daily]),
        correction=rig.fit.correction,
        evaluations=_CONVERGED,
    )
    square = mean_squares(fitted.residual, rig.problem)
    slopes = fitted.jacobian[:, -count:]
    information = np.einsum("mk,mk->k", slopes, slopes)
    written = {**rig.base, **fitted.parameters(rig.base)}
    numbers, parameter = fitted.values[-count:], term.targets[0]
    middle = float(np.mean(numbers))
    probe = abs(_parameter(term, middle + term.probe, written) - _parameter(term, middle, written))
    with np.errstate(divide="ignore"):
        errors = probe * np.sqrt(np.maximum(square, 1.0) / information)
    return NumberSeries(
        number=watched.number,
        parameter=parameter,
        unit=rig.problem.simulate.parameters[parameter].unit,
        probe=probe,
        values=np.array([_parameter(term, float(x), written) for x in numbers]),
        errors=errors,
        square=square,
        range=np.sort([_parameter(term, end, written) for end in (term.low, term.high)]),
        others={t: written[t] for other, _ in kept if not other.spread for t in other.targets},
    )


def _parameter(term: Term, number: float, values: Mapping[str, float]) -> float:
    """The first parameter that a number writes."""
    return term.write(number, values)[term.targets[0]]


def explanation(ranked: Sequence[NumberSeries]) -> tuple[NumberSeries, list[NumberSeries]]:
    """The series that explains the recordings, and those that explain them as well.

    Two series differ if the mean reduction in residual over the recordings exceeds both twice its
    standard error and 1 % of the residual. Among those that do not differ, a parameter that the
    recordings call uncertain comes first. ``ranked``: the smallest residual first.
    """
    best, *rest = ranked
    alike = [best]
    for other in rest:
        less = other.square - best.square
        error = float(np.std(less, ddof=1)) / np.sqrt(less.size)
        if not float(less.mean()) > max(_RESOLVED * error, _NOTABLE * float(best.square.mean())):
            alike.append(other)
    first = min(alike, key=lambda series: bool(series.number.identifier))  # else the first
    return first, [other for other in alike if other is not first]
