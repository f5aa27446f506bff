"""Direct fit of the MuJoCo model: least squares from the best of many random starts.

Every law of friction gets the same: as many starts, spread evenly over all ranges (Sobol points),
as many of them refined, by the same solver with as many steps at most.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from experiments.measured_joint.joint_model import Number, named, narrowed, values_in
from experiments.measured_joint.prediction import Series
from experiments.measured_joint.recording import COLUMNS, noise
from experiments.measured_joint.wound_in import WoundIn
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_STARTS, _REFINED, _STEPS = 32, 2, 20
_LONGER = 2.0  # times the model's step, in the fit
_DIFFERENCE = 4e-3  # of a range
_FAILED = 30.0  # residual of a simulation that became unstable, in noise
_MARGIN = 1e-3  # of a range, that a start keeps from its ends


@dataclass(frozen=True)
class DirectFit:
    """A fitted model; called with a recording it simulates it.

    Attributes:
        numbers: that were fitted.
        shares: (p,) of their ranges.
        chi2: mean square of the training residuals, in units of noise [-].
    """

    numbers: tuple[Number, ...]
    shares: FloatArray
    chi2: float

    @property
    def values(self) -> Mapping[str, float]:
        """Name of each number → its value."""
        return named(self.numbers, self.shares.tolist())

    def __call__(self, recording: Recording) -> Series:
        """Simulate a recording with the model's own step."""
        values = values_in(self.numbers, self.shares.tolist(), [recording])
        return WoundIn([recording])([values])[0][0]


def fit_directly(
    numbers: tuple[Number, ...],
    train: Sequence[Recording],
    seed: int,
    *,
    starts: int = _STARTS,
    refined: int = _REFINED,
) -> DirectFit:
    """Fit numbers of the model to recordings; angle and tensions count by their noise.

    Args:
        numbers: to fit, within the ranges that the recordings state.
        train: recordings.
        seed: of the starts.
        starts: how many, a power of 2.
        refined: how many of them, the best, least squares begins from.
    """
    numbers = narrowed(numbers, train[0])
    simulator = WoundIn(train).in_steps(_LONGER)

    def residuals(points: FloatArray) -> FloatArray:
        """(k, m) of (k, p) shares."""
        sets = [values_in(numbers, point.tolist(), train) for point in points]
        with warnings.catch_warnings():  # of numbers with which a sheath finds no equilibrium
            warnings.simplefilter("ignore", RuntimeWarning)
            answered = simulator(sets)
        rows = [
            np.concatenate(
                [
                    (series[c] - recording.columns[c]) / noise(recording, c)
                    for recording, series in zip(train, answers, strict=True)
                    for c in COLUMNS
                ]
            )
            for answers in answered
        ]
        stacked: FloatArray = np.nan_to_num(np.array(rows), nan=_FAILED)
        return stacked

    def slopes(point: FloatArray) -> FloatArray:
        step = np.where(point > 0.5, -_DIFFERENCE, _DIFFERENCE)
        moved = residuals(np.vstack([point, point + np.diag(step)]))
        return np.asarray((moved[1:] - moved[0]).T / step)

    sobol = qmc.Sobol(len(numbers), rng=np.random.default_rng(seed))
    points = _MARGIN + (1.0 - 2.0 * _MARGIN) * sobol.random(starts)
    best = points[np.argsort(np.mean(residuals(points) ** 2, axis=1))[:refined]]
    fits = [
        least_squares(
            lambda point: residuals(point[None])[0],
            start,
            jac=slopes,
            bounds=(0.0, 1.0),
            max_nfev=_STEPS,
            xtol=1e-4,
            ftol=1e-4,
        )
        for start in best
    ]
    chosen = min(fits, key=lambda fit: float(fit.cost))
    return DirectFit(numbers, chosen.x, float(np.mean(chosen.fun**2)))
