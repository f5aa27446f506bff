"""A number of a rig day by day: fitted to each recording, everything else to all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis import Term, fit
from tendon_mj.lab.fleet.number import Number
from tendon_mj.lab.fleet.observation import Calibrated, calibrate, terms_without
from tendon_mj.lab.fleet.watched import Watched, per_recording
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_CONVERGED = 6  # evaluations, from near the best values
_NOTABLE = 0.01  # of what the better one leaves, likewise
_RESOLVED = 2.0  # standard errors of the mean, by which two explanations differ


@dataclass(frozen=True, eq=False)
class Series:
    """A number day by day.

    Attributes:
        number: what it is.
        parameter, unit: the first parameter that it writes, and that one's unit.
        values: (n,) of that parameter [unit].
        errors: (n,) standard errors from noise [unit].
        probe: change of the parameter for a probe of the number [unit].
        range: (2,) within which the parameter is fitted [unit].
        square: (n,) mean square residual of each recording with them [noise²].
        before: (n,) likewise with one value for all recordings.
        others: parameter → value of what was fitted to all recordings beside it.
    """

    number: Number
    parameter: str
    unit: str
    probe: float
    values: FloatArray
    errors: FloatArray
    square: FloatArray
    before: FloatArray
    range: FloatArray
    others: dict[str, float]

    def plain(self) -> dict[str, Any]:
        """Its fields, for JSON."""
        arrays = {name: getattr(self, name).tolist() for name in _ARRAYS}
        plain = {name: getattr(self, name) for name in _PLAIN}
        return {"number": self.number.plain(), **plain, **arrays}

    @classmethod
    def from_plain(cls, fields: Mapping[str, Any]) -> Series:
        """That of `plain`."""
        given: dict[str, Any] = {name: fields[name] for name in _PLAIN}
        given |= {name: np.array(fields[name], float) for name in _ARRAYS}
        return cls(number=Number.from_plain(fields["number"]), **given)


_PLAIN = ("parameter", "unit", "probe", "others")
_ARRAYS = ("values", "errors", "square", "before", "range")


@dataclass(frozen=True)
class Asked:
    """A number that may have changed, and how much from day to day, (n,) [probes]."""

    number: Number
    changes: tuple[float, ...]


def fit_series(
    recordings: Sequence[Recording],
    start: Sequence[float],
    asked: Sequence[Asked],
    model: mujoco.MjModel | None = None,
) -> list[Series]:
    """Fit each of some numbers day by day; the one that explains most first.

    Args:
        recordings: of a rig, in the order of time.
        start: what was fitted to all of them, see `Observation`.
        asked: the numbers.
        model: that the recordings name, where its file is not at hand.
    """
    rig = calibrate(recordings, model, start)
    changes = {one.number: one.changes for one in asked}
    found = [
        _series(rig, watched, changes[watched.number], [r.name for r in recordings])
        for watched in rig.watched
        if watched.number in changes
    ]
    return sorted(found, key=lambda series: float(series.square.mean()))


def _series(
    rig: Calibrated, watched: Watched, changes: Sequence[float], names: Sequence[str]
) -> Series:
    own, term, count = per_recording(watched, names), watched.term, len(names)
    kept, values = terms_without(rig.fit, (term,))
    daily = np.clip(watched.value + term.probe * np.array(changes), term.low, term.high)
    found = fit(
        rig.problem,
        rig.base,
        (*kept, *watched.shape, *own),
        (),
        np.concatenate([values, watched.number.shape, daily]),
        correction=rig.fit.correction,
        evaluations=_CONVERGED,
    )
    problem, owner = rig.problem, rig.problem.recording_of
    square = _mean_squares(found.residual, owner, count)
    slopes = found.jacobian[:, -count:]
    information = np.einsum("mk,mk->k", slopes, slopes)
    written = {**rig.base, **found.parameters(rig.base)}
    numbers, parameter = found.values[-count:], term.targets[0]
    middle = float(np.mean(numbers))
    probe = abs(_parameter(term, middle + term.probe, written) - _parameter(term, middle, written))
    with np.errstate(divide="ignore"):
        errors = probe * np.sqrt(np.maximum(square, 1.0) / information)
    return Series(
        number=watched.number,
        parameter=parameter,
        unit=problem.simulate.parameters[parameter].unit,
        probe=probe,
        values=np.array([_parameter(term, float(x), written) for x in numbers]),
        errors=errors,
        square=square,
        range=np.sort([_parameter(term, end, written) for end in (term.low, term.high)]),
        before=_mean_squares(rig.fit.residual, owner, count),
        others={t: written[t] for one in kept if not one.spread for t in one.targets},
    )


def _parameter(term: Term, number: float, values: Mapping[str, float]) -> float:
    """The first parameter that a number writes."""
    return term.write(number, values)[term.targets[0]]


def explanation(found: Sequence[Series]) -> tuple[Series, list[Series]]:
    """What explains the recordings, and what explains them as well.

    Two are told apart where the mean, over the recordings, of how much less one leaves is more
    than twice its standard error, and a hundredth of what is left. Among those that are not, a
    parameter that the recordings call uncertain is the likelier one.

    Args:
        found: the one that leaves least first.
    """
    best, *rest = found
    alike = [best]
    for other in rest:
        less = other.square - best.square
        error = float(np.std(less, ddof=1)) / np.sqrt(less.size)
        if not float(less.mean()) > max(_RESOLVED * error, _NOTABLE * float(best.square.mean())):
            alike.append(other)
    first = min(alike, key=lambda series: bool(series.number.identifier))  # else the first
    return first, [other for other in alike if other is not first]


def _mean_squares(residual: FloatArray, owner: NDArray[np.int64], count: int) -> FloatArray:
    return np.array([float(np.mean(residual[owner == k] ** 2)) for k in range(count)])
