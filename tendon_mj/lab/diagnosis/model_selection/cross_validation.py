"""Cross-validation of a fitted model.

The parts of a `Problem` are left out of the fit in turn: blocks of time, or whole recordings where
these are of different states of the rig. To first order the refit is one Gauss-Newton step from the
common solution and needs no simulation: with J_b, r_b the rows of part b and W the weights of terms
with an expected spread,

    Δ_b = (JᵀJ + W² − J_bᵀJ_b)⁻¹ J_bᵀ r_b,     left-out residual r_b + J_b Δ_b,

with Δ_b held within the terms' ranges.
What was set anew for a recording no other one can tell. With that recording left out, its own terms
are therefore held in Δ_b, and then fitted to it.

With an effect whose cost is non-smooth the linearisation does not hold, so no block is left out and
the held-out data alone can refute the effect.

Neighbouring residuals are correlated, as model and rig differ by more than white noise. Models are
therefore compared block by block, never sample by sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.model_selection.fit import Fit
from tendon_mj.typing import FloatArray


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """Cross-validated χ² of a model.

    Attributes:
        chi2: (parts,) sum of squared left-out residuals in units of noise.
        samples: number in all parts.
    """

    chi2: FloatArray
    samples: int

    @property
    def excess(self) -> float:
        """Reduced χ² − 1 [-]; below 0 by chance."""
        return float(self.chi2.sum()) / self.samples - 1.0


def cross_validate(problem: Problem, fit: Fit) -> CrossValidation:
    """Cross-validate a fit on the training data."""
    used = problem.in_train
    residual, parts = fit.residual[used], problem.parts[used]
    refitted = fit.free & (not any(effect.non_smooth for effect in fit.effects))
    jacobian = fit.jacobian[used][:, refitted]
    names, part_of = np.unique(parts, return_inverse=True)
    weights, shared = fit.weights[refitted] ** 2, fit.shared[refitted]
    normal = jacobian.T @ jacobian
    chi2 = np.empty(names.size)
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
    return CrossValidation(chi2, int(used.sum()))


@dataclass(frozen=True)
class Gain:
    """Reduction of the cross-validated reduced χ² from one model to another.

    Attributes:
        mean: difference of the reduced χ² [-].
        standard_error: of the mean [-]. An effect may show in two blocks of thirty and be certain;
            only the blocks that it makes worse speak against it. By chance as many improve by as
            much, hence √(2 Σ worse²).
    """

    mean: float
    standard_error: float


def gain(before: CrossValidation, after: CrossValidation) -> Gain:
    """Gain of the second model over the first."""
    difference = before.chi2 - after.chi2
    worse = np.minimum(difference, 0.0)
    error = float(np.sqrt(2.0 * worse @ worse))
    return Gain(float(difference.sum()) / before.samples, error / before.samples)
