"""What a fitted model would leave on data that it was not fitted to.

The stretches of time of a `Problem` are left out in turn. Refitting each time would cost as many
fits as there are stretches; to first order the refit is one Gauss-Newton step from the common
solution, and needs no simulation: with J_b, r_b the rows of stretch b,

    Δ_b = (JᵀJ − J_bᵀJ_b)⁻¹ J_bᵀ r_b,     left-out residual r_b + J_b Δ_b.

Where a tendon sticks and slips, slopes hold for a hair's breadth, and the step would lead anywhere:
beside a non-smooth effect nothing is left out, which leaves it to the held-out data to refute it.

Neighbouring residuals are correlated, as model and rig differ by more than white noise, so nothing
here counts samples: stretches are what is compared, each as a whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.fit import Fit
from tendon_mj.diagnosis.problem import Problem

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Leftover:
    """Power that a model leaves, stretch by stretch, each left out of the fit in its turn.

    Attributes:
        power: (stretches,) sum of squared residuals in units of noise.
        samples: in all of them.
    """

    power: FloatArray
    samples: int

    @property
    def gap(self) -> float:
        """Mean square of what is not noise, in units of the noise's [-]; below 0 by chance."""
        return float(self.power.sum()) / self.samples - 1.0


def leave_out(problem: Problem, fit: Fit) -> Leftover:
    """Leave out each stretch in turn."""
    used = problem.chosen
    residual, segments = fit.residual[used], problem.segments[used]
    shifting = fit.free & (not any(effect.non_smooth for effect in fit.effects))
    jacobian = fit.jacobian[used][:, shifting]
    numbers, first = np.unique(segments, return_inverse=True)
    whole = jacobian.T @ jacobian
    power = np.empty(numbers.size)
    ridge = 1e-9 * np.diag(np.diag(whole))
    for b in range(numbers.size):
        rows = first == b
        j, r = jacobian[rows], residual[rows]
        if j.shape[1]:
            shift = np.linalg.lstsq(whole - j.T @ j + ridge, j.T @ r, rcond=None)[0]
            r = r + j @ shift
        power[b] = float(r @ r)
    return Leftover(power, int(used.sum()))


@dataclass(frozen=True)
class Gain:
    """How much less one model leaves than another.

    Attributes:
        mean: difference of their gaps [noise power].
        error: by how much it may be chance. An effect may show in two stretches of thirty and be
            sure all the same; what speaks against it are the stretches that it makes worse. By
            chance as many get better by as much, hence √(2 Σ worse²).
    """

    mean: float
    error: float


def gain(worse: Leftover, better: Leftover) -> Gain:
    """What the second leaves less than the first, and how sure that is."""
    difference = worse.power - better.power
    against = np.minimum(difference, 0.0)
    error = float(np.sqrt(2.0 * against @ against))
    return Gain(float(difference.sum()) / worse.samples, error / worse.samples)
