"""The values of a sweep's parameters in each of its rollouts."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.sweep.axes import MOST_ROLLOUTS, Axis
from tendon_mj.typing import FloatArray


class Design:
    """Every combination of the grids' values, each with the same random draws of the ranges.

    The last axis changes fastest, and draws faster than grids. That all combinations have the same
    draws keeps their scatter out of the differences between them. The first draws are the same
    whatever their number.

    Args:
        axes: of the sweep.
        draws: of the axes without a grid.
        seed: of the draws.

    Attributes:
        rollouts: number of combinations.

    Raises:
        InvalidValueError: more than 10 million combinations.
    """

    def __init__(self, axes: Sequence[Axis], draws: int, seed: int) -> None:
        self._grids = {k: axis.grid for k, axis in enumerate(axes) if axis.grid is not None}
        drawn = [axis for axis in axes if axis.grid is None]
        self._drawn = [k for k, axis in enumerate(axes) if axis.grid is None]
        low, high = np.array([[axis.low, axis.high] for axis in drawn]).reshape(-1, 2).T
        size = (draws if drawn else 1, len(drawn))
        self._shape = (*(len(grid) for grid in self._grids.values()), size[0])
        self._axes = len(axes)
        self.rollouts = math.prod(self._shape)
        if self.rollouts > MOST_ROLLOUTS:
            counts = [f"{len(grid)} values" for grid in self._grids.values()]
            counts += [f"{draws} draws"] if drawn else []
            raise InvalidValueError(
                f"{' × '.join(counts)} make {self.rollouts} rollouts; a sweep has at most"
                f" {MOST_ROLLOUTS}, so give fewer --draws, or fewer values of a --parameter"
            )
        self._draws = np.random.default_rng(seed).uniform(low, high, size)

    def values(self, start: int, stop: int) -> FloatArray:
        """(stop − start, axes) of the rollouts from ``start`` on."""
        *places, draw = np.unravel_index(np.arange(start, stop), self._shape)
        found = np.empty((stop - start, self._axes))
        for (axis, grid), place in zip(self._grids.items(), places, strict=True):
            found[:, axis] = grid[place]
        found[:, self._drawn] = self._draws[draw]
        return found
