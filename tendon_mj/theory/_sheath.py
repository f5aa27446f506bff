"""One sheath of uniform curvature with a spring at its output end, in scalars.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.theory import _check
from tendon_mj.theory._exponential import relative
from tendon_mj.theory.tension_memory import TensionMemory
from tendon_mj.typing import FloatArray


class Sheath:
    """Displacement of the input end, ξ_in = (T_out − T_0)/k_se + (L/EA) mean(T − T_0)."""

    def __init__(
        self, lam: float, pretension: float, axial: float, length: float, spring: float
    ) -> None:
        self.size = abs(lam)
        self.pretension = pretension
        self.tendon = length / axial  # compliance, m/N
        self.spring = 1.0 / spring  # compliance, m/N
        # where the last tension is gone; also the zero of both lines of full sliding
        self.slack = -pretension * (self.tendon + self.spring)

    def displacement(self, memory: TensionMemory) -> float:
        """ξ_in [m] with the tension profile of ``memory``."""
        out = self.spring * (memory.tension(self.size) - self.pretension)
        return float(out + self.tendon * memory.mean_excess(self.size))

    def slope(self, depth: float, way: float) -> float:
        """dξ_in/dT_in [m/N] while the tendon slides down to ``depth``, pulling for way = 1."""
        depth = min(depth, self.size)
        share = depth / self.size if self.size else 1.0
        slope = self.tendon * share * float(relative(np.asarray(-way * depth)))
        if depth == self.size:
            slope += self.spring * float(np.exp(-way * depth))
        return slope


def each_sheath(
    series: FloatArray,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike,
) -> tuple[FloatArray, Iterator[tuple[tuple[int, ...], Sheath]]]:
    """Broadcast a history (time on axis 0) with sheaths: the history, and index with sheath."""
    values = [
        _check.finite("lam", lam),
        _check.positive("pretension", pretension),
        _check.positive("axial_stiffness", axial_stiffness),
        _check.positive("length", length),
        _check.stiffness("output_stiffness", output_stiffness),
    ]
    shape = np.broadcast_shapes(series.shape[1:], *(value.shape for value in values))
    padded = series.reshape(len(series), *(1,) * (len(shape) - series.ndim + 1), *series.shape[1:])
    values = [np.broadcast_to(value, shape) for value in values]
    sheaths = (
        (index, Sheath(*(float(value[index]) for value in values))) for index in np.ndindex(shape)
    )
    return np.broadcast_to(padded, (len(series), *shape)), sheaths
