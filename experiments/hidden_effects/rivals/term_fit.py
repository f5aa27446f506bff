"""Least squares of terms to recordings, with the session parameters of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from experiments.hidden_effects.rivals.rig import Rig, Values, noise
from tendon_mj.lab.diagnosis import Term
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

DIFFERENCE = 1e-2  # of a term's scale, for the Jacobian
EVALUATIONS = 8  # points at most
TOLERANCE = 1e-3  # relative change of the cost at which a fit ends
MARGIN = 1e-3  # of a range: a fit starts this far inside it
OWN = " @ "  # before the recording that a value is for


@dataclass(frozen=True, eq=False)
class TermFit:
    """Terms at the values that fit best.

    Attributes:
        terms: all that were fitted.
        values: (p,) [their units].
        residual: (m,) [noise].
        jacobian: (m, p) by the scaled terms.
    """

    terms: tuple[Term, ...]
    values: FloatArray
    residual: FloatArray
    jacobian: FloatArray

    @property
    def cost(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residual @ self.residual)

    def parameters(self, base: Values) -> dict[str, float]:
        """Parameter → value that the terms write."""
        return written(self.terms, self.values, base)


def written(
    terms: Sequence[Term], values: Sequence[float] | FloatArray, base: Values
) -> dict[str, float]:
    """Parameter → value; terms relative to another parameter see what the others write."""
    parameters: dict[str, float] = {}
    for relative in (False, True):
        for term, value in zip(terms, values, strict=True):
            if bool(term.depends_on) == relative:
                parameters |= term.write(float(value), {**base, **parameters})
    return parameters


def fit_terms(
    rig: Rig, terms: Sequence[Term], start: Sequence[float] | FloatArray, fixed: Values
) -> TermFit:
    """Minimise the squared residuals, with those of session parameters from their stated means.

    Args:
        rig: data.
        terms: to fit, those of sessions among them.
        start: (p,) values to begin from [their units].
        fixed: parameter → value, not fitted any more.
    """
    if not terms:
        return TermFit((), np.empty(0), rig.residuals([fixed])[0], np.empty((rig.owner.size, 0)))
    solver = _Solver(rig, tuple(terms), fixed)
    low, high = solver.bounds
    margin = MARGIN * (high - low)
    scaled = [term.scaled(float(value)) for term, value in zip(terms, start, strict=True)]
    result = least_squares(
        solver.residual,
        np.clip(scaled, low + margin, high - margin),
        jac=solver.jacobian,
        bounds=(low, high),
        ftol=TOLERANCE,
        xtol=TOLERANCE,
        max_nfev=EVALUATIONS,
    )
    size = rig.owner.size
    return TermFit(
        tuple(terms), solver.natural(result.x), result.fun[:size].copy(), result.jac[:size].copy()
    )


class _Solver:
    """Residuals and Jacobian of terms as SciPy's solver sees them: scaled, and with priors."""

    def __init__(self, rig: Rig, terms: tuple[Term, ...], fixed: Values) -> None:
        self.rig, self.terms, self.fixed = rig, terms, fixed
        self.base = {**rig.base, **fixed}
        self.bounds = np.array([[t.scaled(t.low), t.scaled(t.high)] for t in terms]).T
        # prior residual of each term over its scaled value
        self.prior = np.array([t.probe / t.spread if t.spread else 0.0 for t in terms])
        owners = [term.targets[0].partition(OWN)[2] for term in terms]
        self.acts = np.array(
            [(rig.owner == o) if o else np.ones(rig.owner.size, bool) for o in owners]
        )
        groups: dict[str, list[int]] = {}
        for k, (term, owner) in enumerate(zip(terms, owners, strict=True)):
            groups.setdefault(term.targets[0].partition(OWN)[0] if owner else str(k), []).append(k)
        # terms of one parameter in different recordings are moved in one simulation
        self.groups = list(groups.values())
        self._last: tuple[bytes, FloatArray] = (b"", np.empty(0))

    def natural(self, point: FloatArray) -> FloatArray:
        """(p,) values of the terms [their units]."""
        return np.array([t.natural(float(z)) for t, z in zip(self.terms, point, strict=True)])

    def residual(self, point: FloatArray) -> FloatArray:
        """(m + p,) residuals [noise], and priors."""
        return np.concatenate([self._simulated(point), self.prior * point])

    def jacobian(self, point: FloatArray) -> FloatArray:
        """(m + p, p) by one-sided differences, away from the nearer bound."""
        steps = np.where(point > self.bounds.mean(axis=0), -DIFFERENCE, DIFFERENCE)
        moved = []
        for group in self.groups:
            shifted = point.copy()
            shifted[group] += steps[group]
            moved.append(self._parameters(shifted))
        matrix = np.empty((self.rig.owner.size, point.size))
        at = self._simulated(point)
        for group, row in zip(self.groups, self.rig.residuals(moved), strict=True):
            for k in group:
                matrix[:, k] = (row - at) * self.acts[k] / steps[k]
        return np.vstack([matrix, np.diag(self.prior)])

    def _parameters(self, point: FloatArray) -> dict[str, float]:
        return {**self.fixed, **written(self.terms, self.natural(point), self.base)}

    def _simulated(self, point: FloatArray) -> FloatArray:
        key = point.tobytes()
        if self._last[0] != key:
            self._last = key, self.rig.residuals([self._parameters(point)])[0]
        return self._last[1]


def predict(recordings: Sequence[Recording], parameters: Values) -> FloatArray:
    """(m,) residuals of held-out recordings [noise], with the model's own step.

    Session parameters are fitted to each of them, as a diagnosis does.
    """
    rig = Rig(recordings, 1.0)
    shared = {name: value for name, value in parameters.items() if " @ " not in name}
    terms = rig.sessions
    return fit_terms(rig, terms, [term.inert for term in terms], shared).residual


def errors(recordings: Sequence[Recording], residual: FloatArray) -> dict[str, Any]:
    """``gap`` of a result: rms over all signals [noise], and of each in its own unit.

    Args:
        recordings: that were held out.
        residual: (m,) by recording, column and sample [noise].
    """
    squares: dict[str, list[FloatArray]] = {}
    first = 0
    for recording in recordings:
        for column in recording.measured:
            own = residual[first : first + recording.time.size] * noise(recording, column)
            squares.setdefault(column, []).append(own**2)
            first += recording.time.size
    return {
        "held_out": {
            "unit": "noise",
            "after": float(np.sqrt(np.mean(residual**2))),
            "signals": {
                column: {"after": float(np.sqrt(np.mean(np.concatenate(parts))))}
                for column, parts in squares.items()
            },
        }
    }
