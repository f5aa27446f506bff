"""Leave-one-block-out cross-validation of a fitted model.

Blocks of time of a `Problem` are left out of the fit in turn. To first order the refit is one
Gauss-Newton step from the common solution and needs no simulation: with J_b, r_b the rows of
block b,

    Δ_b = (JᵀJ − J_bᵀJ_b)⁻¹ J_bᵀ r_b,     left-out residual r_b + J_b Δ_b.

With an effect whose cost is non-smooth the linearisation does not hold, so no block is left out and
the held-out data alone can refute the effect.

Neighbouring residuals are correlated, as model and rig differ by more than white noise. Models are
therefore compared block by block, never sample by sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.data.problem import Problem
from tendon_mj.diagnosis.model_selection.fit import Fit

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """Cross-validated χ² of a model.

    Attributes:
        chi2: (blocks,) sum of squared left-out residuals in units of noise.
        samples: number in all blocks.
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
    residual, blocks = fit.residual[used], problem.blocks[used]
    refitted = fit.free & (not any(effect.non_smooth for effect in fit.effects))
    jacobian = fit.jacobian[used][:, refitted]
    names, block_of = np.unique(blocks, return_inverse=True)
    normal = jacobian.T @ jacobian
    chi2 = np.empty(names.size)
    ridge = 1e-9 * np.diag(np.diag(normal))
    for b in range(names.size):
        rows = block_of == b
        j, r = jacobian[rows], residual[rows]
        if j.shape[1]:
            shift = np.linalg.lstsq(normal - j.T @ j + ridge, j.T @ r, rcond=None)[0]
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
