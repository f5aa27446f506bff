"""A rig's calibrated model, and the information of each of its recordings on every parameter.

Of recording k with residual r_k [noise] and derivatives J_k by the watched numbers, in probes, only

    A_k = J_kᵀ J_k,   b_k = J_kᵀ r_k

are kept. They decide, to first order, how much of χ² = Σ_k |r_k|² any change on any day explains,
with everything else fitted, so that the search for changes needs no further simulation. Session
terms are eliminated from both: fitted to that recording alone.

With m_j residuals of recording j of mean square s_j, leaving out recording k changes the fitted
values and the mean squares of the others by

    δ = C_k⁻¹ b_k,   C_k = Σ_{j≠k} A_j,   Δs_j = (2 δᵀ b_j + δᵀ A_j δ) / m_j.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import mujoco
import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import (
    CONVERGED,
    SMALLEST_EXCESS,
    STANDARD_ERRORS,
    Fit,
    Problem,
    Term,
    all_samples,
    candidates,
    check_recordings,
    check_simulation,
    describe_system,
    fit,
    search_step,
    session_terms,
    uncertain_terms,
    with_step,
    written,
)
from tendon_mj.lab.fleet.rigs import RigData
from tendon_mj.lab.parameter_names import name_in_session
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, suppress_unsolved_warnings
from tendon_mj.typing import BoolArray, FloatArray

Label = tuple[str, str, tuple[float, ...]]  # identifier, name, shape

SINGULAR = 1e-10  # relative eigenvalue below which a direction is left alone
_PARTS = 8  # of a recording
REPRODUCIBILITY = 0.01  # share of itself by which a number comes back from one to the next
_ZERO = np.sqrt(SMALLEST_EXCESS)  # by which the zero of a sensor comes back [noise]
_NOTABLE = 0.01  # of the residual of the better one, likewise


@dataclass(frozen=True)
class Number:
    """A number of a model that may change from one day to the next."""

    name: str  # of the parameters that it is
    identifier: str  # of the effect; empty for a parameter that the recordings call uncertain
    unit: str  # of the number
    probe: float  # a small change of it [unit]
    # of the effect's further numbers, which stay as they are [their units]
    shape: tuple[float, ...] = ()

    @property
    def label(self) -> Label:
        """Its identity on every rig; a probe may differ, as it depends on the measurement."""
        return self.identifier, self.name, self.shape


@dataclass(frozen=True)
class Watched:
    """A number with the term that writes it."""

    number: Number  # its names
    term: Term  # the number, with the parameters that it writes
    shape: tuple[Term, ...]  # further terms of an effect, which are the same on all days
    value: float  # at which the derivative is taken [the term's unit]


@suppress_unsolved_warnings()
def usable(data: RigData) -> list[str]:
    """Why each recording of a rig cannot be calibrated with the others; empty if it can."""
    kept, reasons = list[Recording](), list(data.reasons)
    for k, recording in enumerate(data.recordings):
        if recording is None or data.model is None:
            continue
        try:
            check_recordings([*kept, recording], ())
            simulate = Simulator([recording], model=data.model, threads=1)
            check_simulation(Problem((recording,), simulate, all_samples([recording])))
            kept.append(recording)
        except TendonError as error:
            reasons[k] = str(error)
    return reasons


@dataclass(frozen=True, eq=False)
class Calibrated:
    """A rig's model, fitted to all its recordings."""

    problem: Problem  # the recordings
    base: dict[str, float]  # parameter → value of the model
    fit: Fit  # of the uncertain parameters and the session terms
    watched: tuple[Watched, ...]  # the numbers that may change; the first are the uncertain ones


@dataclass(frozen=True, eq=False)
class Observation:
    """Information of a rig's recordings on the numbers that may change."""

    numbers: tuple[Number, ...]  # those that may change
    shared: int  # how many of the first are fitted to all recordings together
    terms: FloatArray  # (p,) all fitted values, in the order of the terms [their units]
    values: FloatArray  # (shared,) those of the shared numbers [their units]
    errors: FloatArray  # (shared,) their standard errors [their units]
    square: FloatArray  # (n,) mean square residual of each recording, calibrated [noise²]
    samples: FloatArray  # (n,) number of these residuals
    normal: FloatArray  # (n, w, w) A_k
    gradient: FloatArray  # (n, w) b_k

    @property
    def fitted(self) -> tuple[Number, ...]:
        """The shared numbers."""
        return self.numbers[: self.shared]


def calibrate(
    recordings: Sequence[Recording], model: mujoco.MjModel, start: Sequence[float] | None = None
) -> Calibrated:
    """Fit the uncertain parameters to all recordings of a rig.

    ``start``: values of the terms, where they were fitted before.
    """
    simulate = Simulator(recordings, model=model, threads=1)
    own = Problem(tuple(recordings), simulate, all_samples(recordings))
    system = describe_system(own)
    terms = (*uncertain_terms(own), *session_terms(recordings, simulate))
    problem = with_step(own, search_step(own))
    base = dict(system.values)
    inert = [term.inert for term in terms]
    begin = np.asarray(inert if start is None else start, float)
    fitted = fit(problem, base, terms, (), begin, evaluations=CONVERGED)
    watched = [
        Watched(_number(term), term, (), float(value))
        for term, value in zip(terms, fitted.values, strict=True)
        if not term.spread
    ]
    values = {**base, **fitted.parameters(base)}
    for candidate in (c for c in candidates(system) if c.acts_on(values)):
        strength, *shape = candidate.terms
        for starts in product(*(term.starts or (term.inert,) for term in shape)):
            number = _number(strength, candidate.identifier, starts)
            watched.append(Watched(number, strength, tuple(shape), strength.inert))
    return Calibrated(problem, base, fitted, tuple(watched))


def _number(term: Term, identifier: str = "", shape: tuple[float, ...] = ()) -> Number:
    return Number(", ".join(term.targets), identifier, term.unit, term.probe, shape)


def observe(recordings: Sequence[Recording], model: mujoco.MjModel) -> Observation:
    """Calibrate a rig, and keep A_k and b_k of each recording."""
    rig = calibrate(recordings, model)
    fitted, terms = rig.fit, rig.fit.terms
    uncertain = [k for k, term in enumerate(terms) if not term.spread]
    count = len(uncertain)
    slopes = [fitted.jacobian[:, k] for k in uncertain]
    slopes += [_derivative(rig, number) for number in rig.watched[count:]]
    seen = [k for k, slope in enumerate(slopes) if k < count or slope.any()]
    matrix = np.column_stack([slopes[k] for k in seen])
    watched = [rig.watched[k] for k in seen]
    parts = [
        _without_sessions(fitted, matrix, rig.problem.recording_of == k)
        for k in range(len(recordings))
    ]
    normal, gradient = (np.array(part) for part in zip(*parts, strict=True))
    square = mean_squares(fitted.residual, rig.problem)
    probes = np.array([one.term.probe for one in watched[:count]])
    return Observation(
        numbers=tuple(one.number for one in watched),
        shared=count,
        terms=fitted.values,
        values=np.array([one.value for one in watched[:count]]),
        errors=probes * _errors(np.sum(normal, axis=0)[:count, :count], square),
        square=square,
        samples=np.bincount(rig.problem.recording_of, minlength=len(recordings)).astype(float),
        normal=normal,
        gradient=gradient,
    )


def mean_squares(residual: FloatArray, problem: Problem) -> FloatArray:
    """(n,) mean square residual of each recording [noise²]."""
    rows = [problem.recording_of == k for k in range(len(problem.recordings))]
    return np.array([float(np.mean(residual[mine] ** 2)) for mine in rows])


@suppress_unsolved_warnings()
def _derivative(rig: Calibrated, watched: Watched) -> FloatArray:
    """(m,) change of the residuals with a number, by a probe [noise]; 0 if one fails."""
    term, value = watched.term, watched.value
    step = min(term.probe, term.high - term.low)
    sign = 1.0 if term.high - value >= step else -1.0  # the side that the range allows
    terms = (*rig.fit.terms, term, *watched.shape)
    values = [*rig.fit.values, value + sign * step, *watched.number.shape]
    moved = written(terms, np.array(values), rig.base)
    simulated = rig.problem.residuals([moved])[0] + rig.fit.correction
    trace = sign * (simulated - rig.fit.residual)
    return trace if np.isfinite(trace).all() else np.zeros_like(trace)


def _without_sessions(
    fitted: Fit, matrix: FloatArray, rows: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """A and b of the recording of these rows, with its session terms fitted to it alone."""
    own = np.array([term.spread > 0.0 for term in fitted.terms], bool)
    own &= np.abs(fitted.jacobian[rows]).max(axis=0, initial=0.0) > 0.0
    prior = fitted.weights[own]
    others = np.vstack([fitted.jacobian[np.ix_(rows, own)], np.diag(prior)])
    residual = np.append(fitted.residual[rows], prior * fitted.scaled[own])
    free = _beside(others, np.vstack([matrix[rows], np.zeros((prior.size, matrix.shape[1]))]))
    return free.T @ free, free.T @ residual


def _beside(others: FloatArray, x: FloatArray) -> FloatArray:
    """What is left of (m, …) x with (m, p) ``others`` fitted to it."""
    return np.asarray(x - others @ np.linalg.lstsq(others, x, rcond=None)[0], float)


def _errors(normal: FloatArray, square: FloatArray) -> FloatArray:
    """(p,) standard errors of values in probes, with residuals of this mean square."""
    if not len(normal):
        return np.zeros(0)
    variances = np.maximum(np.diag(inverse(normal)), 0.0)
    return np.sqrt(variances * max(1.0, float(square.mean())))


def inverse(normal: FloatArray) -> FloatArray:
    """(p, p) inverse of a sum of A_k; 0 in directions without information."""
    return np.asarray(np.linalg.pinv(normal, rcond=SINGULAR, hermitian=True), np.float64)


def one_out(observation: Observation) -> tuple[FloatArray, FloatArray]:
    """(n, shared) values and (n,) misfits [noise] without each recording; none of a single one."""
    shared, count = slice(0, observation.shared), len(observation.square)
    normal, gradient = observation.normal[:, shared, shared], observation.gradient[:, shared]
    probes = np.array([number.probe for number in observation.fitted])
    total = normal.sum(axis=0)
    values, misfits = np.empty((0, observation.shared)), np.empty(0)
    for k in range(count if count > 1 else 0):
        step = inverse(total - normal[k]) @ gradient[k]
        less = 2.0 * gradient @ step + normal @ step @ step
        square = np.delete(observation.square + less / observation.samples, k)
        values = np.vstack([values, observation.values + probes * step])
        misfits = np.append(misfits, np.sqrt(np.maximum(square, 0.0).mean()))
    return values, misfits


@dataclass(frozen=True, eq=False)
class NumberSeries:
    """A number day by day."""

    number: Number  # its names
    # the first parameter that it writes, and that one's unit
    parameter: str
    unit: str
    probe: float  # change of the parameter for a probe of the number [unit]
    values: FloatArray  # (n,) of that parameter [unit]
    errors: FloatArray  # (n,) standard errors from noise [unit]
    # (n,) values and standard errors if all fitted numbers and the sensors' zeros may differ from
    # recording to recording by their reproducibility, to first order [unit]
    apart: FloatArray
    errors_apart: FloatArray
    square: FloatArray  # (n,) mean square residual of each recording [noise²]
    range: FloatArray  # (2,) within which the parameter is fitted [unit]
    others: dict[str, float]  # parameter → value, of those fitted to all recordings with it


def fit_series(
    recordings: Sequence[Recording],
    model: mujoco.MjModel,
    start: Sequence[float],
    suspects: Mapping[Number, Sequence[float]],
    reproducibility: float = REPRODUCIBILITY,
) -> list[NumberSeries]:
    """Fit each of some numbers day by day; the one that explains most first.

    ``start``: values of all terms, see `Observation`; ``suspects``: number → its first-order change
    on each day, (n,) [probes]; ``reproducibility``: share of itself by which a number comes back.
    """
    rig = calibrate(recordings, model, start)
    names = [recording.name for recording in recordings]
    fitted = [
        _series(rig, watched, suspects[watched.number], names, reproducibility)
        for watched in rig.watched
        if watched.number in suspects
    ]
    return sorted(fitted, key=lambda series: float(series.square.mean()))


def _series(
    rig: Calibrated,
    watched: Watched,
    changes: Sequence[float],
    names: Sequence[str],
    reproducibility: float,
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
    values = np.array([_parameter(term, float(x), written) for x in numbers])
    probes = np.array([t.probe for t in fitted.terms])
    spread = np.array([t.spread for t in fitted.terms])
    comes_back = np.where(spread > 0.0, spread, reproducibility * np.abs(fitted.values)) / probes
    comes_back[len(kept) : len(kept) + len(watched.shape)] = 0.0  # the same on all days
    apart = np.array([_apart(rig, fitted, k, k - count, comes_back) for k in range(count)])
    return NumberSeries(
        number=watched.number,
        parameter=parameter,
        unit=rig.problem.simulate.parameters[parameter].unit,
        probe=probe,
        values=values,
        errors=errors,
        apart=values + probe * apart[:, 0],
        errors_apart=probe * apart[:, 1],
        square=square,
        range=np.sort([_parameter(term, end, written) for end in (term.low, term.high)]),
        others={t: written[t] for other, _ in kept if not other.spread for t in other.targets},
    )


def _apart(
    rig: Calibrated, fitted: Fit, k: int, number: int, comes_back: FloatArray
) -> tuple[float, float]:
    """Shift of recording k's ``number`` and its standard error if the rest may differ too [probes].

    With the derivatives s of its residuals r by that number, and S by what may differ, each over
    its deviation σ in ``comes_back`` (p,) [probes] or the zero of a sensor, the shift is δ of

        min |r + s δ + S n|² + |n|²   over δ and n,

    to first order. Noise is no less than what the parts of the recording say, as what a model lacks
    is none. A number that changes nothing has a shift of 0, and an infinite error.
    """
    rows = rig.problem.recording_of == k
    columns = [mine for of, _, mine in rig.problem.signals if of == k]
    zeros = np.zeros((len(rows), len(columns)))
    for c, mine in enumerate(columns):
        zeros[mine, c] = _ZERO
    differ = np.hstack([fitted.jacobian * comes_back, zeros])[rows]
    count = differ.shape[1]
    others = np.vstack([differ, np.eye(count)])
    expected = np.zeros(count)
    expected[: len(comes_back)] = fitted.weights * fitted.scaled
    slope = np.append(fitted.jacobian[rows, number], np.zeros(count))
    free = _beside(others, slope)
    information = float(free @ slope)
    if not information > 0.0:
        return 0.0, np.inf
    residual = np.append(fitted.residual[rows], expected)
    shift = -float(free @ residual) / information
    left = _beside(others, residual + shift * slope)[:-count]
    by_noise = max(float(left @ left) / left.size, 1.0) * float(free[:-count] @ free[:-count])
    variance = max(by_noise, _of_parts(free[:-count] * left)) + float(free[-count:] @ free[-count:])
    return shift, np.sqrt(variance) / information


def _of_parts(products: FloatArray) -> float:
    """Sum of squares of what the parts of a recording have of a gradient.

    Over the information squared it is the variance that these parts give, whatever is in them.
    """
    parts = np.array_split(products, _PARTS)
    return float(sum(part.sum() ** 2 for part in parts)) * _PARTS / (_PARTS - 1)


def _parameter(term: Term, number: float, values: Mapping[str, float]) -> float:
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
        if not float(less.mean()) > max(
            STANDARD_ERRORS * error, _NOTABLE * float(best.square.mean())
        ):
            alike.append(other)
    first = min(alike, key=lambda series: bool(series.number.identifier))  # else the first
    return first, [other for other in alike if other is not first]
