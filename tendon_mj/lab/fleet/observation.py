"""One rig looked at: its calibrated model, and what each of its recordings says of every number.

Of recording k with residual r_k [noise] and derivatives J_k by the watched numbers, in probes, only

    A_k = J_kᵀ J_k,   b_k = J_kᵀ r_k

are kept. They decide, to first order, how much of χ² = Σ_k |r_k|² any change on any day explains,
whatever else is fitted beside it, so that the search for changes needs no further simulation. What
was set anew for each recording is eliminated from both: fitted to that recording alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from tendon_mj.lab.diagnosis import (
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
from tendon_mj.lab.fleet.number import Number
from tendon_mj.lab.fleet.watched import Watched, watched_numbers
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_CONVERGED, _AGAIN = 25, 2  # evaluations, from anywhere and from where a fit ended
_INVISIBLE = 1e-8  # mean square of a derivative [noise per probe], below which there is none
SINGULAR = 1e-10  # relative, below which a direction is left alone


@dataclass(frozen=True, eq=False)
class Calibrated:
    """A rig's model, fitted to all its recordings.

    Attributes:
        problem: the recordings.
        base: parameter → value of the model.
        fit: of what the recordings call uncertain, and of what was set anew for each.
        watched: the numbers that may change; the first are the uncertain ones.
    """

    problem: Problem
    base: dict[str, float]
    fit: Fit
    watched: tuple[Watched, ...]


@dataclass(frozen=True, eq=False)
class Observation:
    """What the recordings of a rig say.

    Attributes:
        numbers: those that may change.
        shared: how many of the first are fitted, to all recordings together.
        terms: (p,) all that was fitted, in the order of the terms [their units].
        values: (shared,) of these, what holds in all recordings.
        errors: (shared,) their standard errors [their units].
        square: (n,) mean square residual of each recording, calibrated [noise²].
        samples: (n,) number of these residuals.
        normal: (n, w, w) A_k.
        gradient: (n, w) b_k.
    """

    numbers: tuple[Number, ...]
    shared: int
    terms: FloatArray
    values: FloatArray
    errors: FloatArray
    square: FloatArray
    samples: FloatArray
    normal: FloatArray
    gradient: FloatArray

    def plain(self) -> dict[str, Any]:
        """Its fields, for JSON."""
        arrays = {name: np.asarray(getattr(self, name)).tolist() for name in _ARRAYS}
        numbers = [number.plain() for number in self.numbers]
        return {"numbers": numbers, "shared": self.shared, **arrays}

    @classmethod
    def from_plain(cls, fields: Mapping[str, Any]) -> Observation:
        """That of `plain`."""
        numbers = tuple(Number.from_plain(one) for one in fields["numbers"])
        arrays = {name: np.array(fields[name], float) for name in _ARRAYS}
        return cls(numbers=numbers, shared=int(fields["shared"]), **arrays)


_ARRAYS = ("terms", "values", "errors", "square", "samples", "normal", "gradient")


def calibrate(
    recordings: Sequence[Recording],
    model: mujoco.MjModel | None = None,
    start: Sequence[float] | None = None,
) -> Calibrated:
    """Fit what is uncertain to all recordings of a rig.

    Args:
        recordings: of one rig, in the order of time.
        model: that the recordings name, where its file is not at hand.
        start: values of the terms, where they were fitted before.

    Raises:
        RecordingError: see `tendon_mj.diagnose`.
    """
    check_recordings(recordings, ())
    simulate = Simulator(recordings, model=model, threads=1)
    own = Problem(tuple(recordings), simulate, all_samples(recordings))
    check_simulation(own)
    system = describe_system(own)
    terms = (*uncertain_terms(own), *session_terms(recordings, simulate))
    problem = with_step(own, search_step(own))
    base = dict(system.values)
    inert = [term.inert for term in terms]
    begin, most = (inert, _CONVERGED) if start is None else (start, _AGAIN)
    found = fit(problem, base, terms, (), np.asarray(begin, float), evaluations=most)
    shared = [k for k, term in enumerate(terms) if not term.spread]
    values = {**base, **found.parameters(base)}
    acting = [c for c in candidates(system) if c.acts_on(values)]
    watched = watched_numbers([terms[k] for k in shared], [found.values[k] for k in shared], acting)
    return Calibrated(problem, base, found, watched)


def observe(recordings: Sequence[Recording], model: mujoco.MjModel | None = None) -> Observation:
    """Calibrate a rig, and find what each recording says of every number that may change."""
    rig = calibrate(recordings, model)
    fitted, terms = rig.fit, rig.fit.terms
    own = np.array([term.spread > 0.0 for term in terms], bool)
    uncertain = [k for k, term in enumerate(terms) if not term.spread]
    slopes = [fitted.jacobian[:, k] for k in uncertain]
    slopes += [_derivative(rig, one) for one in rig.watched[len(uncertain) :]]
    seen = [k < len(uncertain) or _visible(slope) for k, slope in enumerate(slopes)]
    matrix = np.column_stack(
        [slope for slope, is_seen in zip(slopes, seen, strict=True) if is_seen]
    )
    sessions = fitted.jacobian[:, own]
    prior = fitted.weights[own]
    deviation = (prior * fitted.scaled[own]) if own.any() else np.zeros(0)
    normals, gradients, squares = [], [], []
    for k in range(len(recordings)):
        rows = rig.problem.recording_of == k
        normal, gradient = _eliminated(
            matrix[rows], sessions[rows], fitted.residual[rows], prior, deviation
        )
        normals.append(normal)
        gradients.append(gradient)
        squares.append(float(np.mean(fitted.residual[rows] ** 2)))
    watched = tuple(one for one, is_seen in zip(rig.watched, seen, strict=True) if is_seen)
    count = len(uncertain)
    probes = np.array([one.term.probe for one in watched[:count]])
    return Observation(
        numbers=tuple(one.number for one in watched),
        shared=count,
        terms=fitted.values,
        values=np.array([one.value for one in watched[:count]]),
        errors=probes * _errors(np.sum(normals, axis=0)[:count, :count], np.array(squares)),
        square=np.array(squares),
        samples=np.bincount(rig.problem.recording_of, minlength=len(recordings)).astype(float),
        normal=np.array(normals),
        gradient=np.array(gradients),
    )


@suppress_unsolved_warnings()
def _derivative(rig: Calibrated, watched: Watched) -> FloatArray:
    """(m,) change of the residuals with a number, by a probe [noise]; 0 where one fails."""
    terms, values = watched.moved(watched.probe)
    moved = written((*rig.fit.terms, *terms), np.array([*rig.fit.values, *values]), rig.base)
    simulated = rig.problem.residuals([moved])[0] + rig.fit.correction
    sign = np.sign(watched.probe)
    trace = sign * (simulated - rig.fit.residual)
    return trace if np.isfinite(trace).all() else np.zeros_like(trace)


def _visible(slope: FloatArray) -> bool:
    return float(slope @ slope) >= _INVISIBLE * slope.size


def _eliminated(
    matrix: FloatArray,
    sessions: FloatArray,
    residual: FloatArray,
    prior: FloatArray,
    deviation: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """A and b of one recording, with what was set anew for it fitted to it alone.

    Args:
        matrix: (m, w) derivatives by the watched numbers.
        sessions: (m, s) those by what was set anew for any recording.
        residual: (m,).
        prior, deviation: (s,) weight of each, and its deviation from the expected value in these.
    """
    normal, gradient = matrix.T @ matrix, matrix.T @ residual
    mine = np.abs(sessions).max(axis=0, initial=0.0) > 0.0
    if mine.any():
        own = sessions[:, mine]
        inner = own.T @ own + np.diag(prior[mine] ** 2)
        cross = matrix.T @ own
        solved = np.linalg.solve(
            inner, np.column_stack([cross.T, own.T @ residual + prior[mine] * deviation[mine]])
        )
        normal, gradient = normal - cross @ solved[:, :-1], gradient - cross @ solved[:, -1]
    return normal, gradient


def _errors(normal: FloatArray, square: FloatArray) -> FloatArray:
    """(p,) standard errors of values in probes, with residuals of this mean square."""
    if not len(normal):
        return np.zeros(0)
    variances = np.maximum(np.diag(inverse(normal)), 0.0)
    errors: FloatArray = np.sqrt(variances * max(1.0, float(square.mean())))
    return errors


def inverse(normal: FloatArray) -> FloatArray:
    """(p, p) inverse of a sum of A_k; 0 in directions of which the recordings say nothing."""
    return np.asarray(np.linalg.pinv(normal, rcond=SINGULAR, hermitian=True), np.float64)


def terms_without(fitted: Fit, replaced: Sequence[Term]) -> tuple[tuple[Term, ...], FloatArray]:
    """Terms and values of a fit but for those that write the same parameters as others."""
    taken = {target for term in replaced for target in term.targets}
    kept = [k for k, term in enumerate(fitted.terms) if not {*term.targets} & taken]
    return tuple(fitted.terms[k] for k in kept), fitted.values[kept]
