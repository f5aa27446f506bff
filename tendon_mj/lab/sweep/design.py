"""Axes of a sweep, and the values of its parameters in each of its rollouts."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.typing import FloatArray

MOST_ROLLOUTS = 10_000_000  # of a sweep; their columns are read into memory
_GRID = 5  # values of a range without a number, where nothing is drawn
_FORMS = "name=low:high, name=low:high:values or name=value,value,…"


class Axis(NamedTuple):
    """Parameters that vary together, and their values.

    Attributes:
        name: as given.
        targets: parameters that have its value.
        low, high: ends of its values [the parameter's unit].
        grid: its values, in order; None where they are drawn from low to high.
    """

    name: str
    targets: tuple[str, ...]
    low: float
    high: float
    grid: NDArray[np.float64] | None

    @property
    def drawn(self) -> bool:
        """Whether its values are random."""
        return self.grid is None


def parse_axes(
    texts: Sequence[str], draws: int, parameters: Collection[str], sheaths: Mapping[str, str]
) -> list[Axis]:
    """Axes of ``name=low:high``, ``name=low:high:values`` and ``name=value,value,…``.

    ``*`` in a name stands for any text, the name of a tendon for its sheath; ``sheaths`` maps a
    sheath to its tendon. Without ``draws`` a range without a number of values is a grid of 5.
    """
    axes = [_parse(text, draws, parameters, sheaths) for text in texts]
    seen: dict[str, str] = {}
    for axis in axes:
        for target in axis.targets:
            if target in seen:
                both = f"--parameter {seen[target]} and --parameter {axis.name}"
                raise InvalidValueError(f"{both} both set {target}; give it one range")
            seen[target] = axis.name
    if not axes:
        raise InvalidValueError(f"nothing is varied; give --parameter {_FORMS}")
    if draws and all(axis.grid is not None for axis in axes):
        raise InvalidValueError(
            f"--draws {draws}: no --parameter is a range to draw from, low:high"
        )
    return axes


def _parse(text: str, draws: int, parameters: Collection[str], sheaths: Mapping[str, str]) -> Axis:
    name, equals, values = (part.strip() for part in text.rpartition("="))
    form = f"--parameter {text}: it is not like {_FORMS}"
    if not equals:
        raise InvalidValueError(form)
    targets = _targets(name, f"--parameter {text}", parameters, sheaths)
    try:
        numbers = [float(part) for part in values.split(":" if ":" in values else ",")]
    except ValueError:
        raise InvalidValueError(form) from None
    if not all(map(math.isfinite, numbers)):
        raise InvalidValueError(f"--parameter {text}: values must be finite")
    if ":" not in values:
        return Axis(name, targets, min(numbers), max(numbers), np.array(numbers))
    if len(numbers) not in (2, 3) or not numbers[0] < numbers[1]:
        raise InvalidValueError(f"--parameter {text}: a range is low:high, or low:high:values")
    low, high, *given = numbers
    if not given and draws:
        return Axis(name, targets, low, high, None)
    count = given[0] if given else _GRID
    if count != int(count) or not 2 <= count <= MOST_ROLLOUTS:
        raise InvalidValueError(
            f"--parameter {text}: {count:g} values; a range has 2 to {MOST_ROLLOUTS}"
        )
    return Axis(name, targets, low, high, np.linspace(low, high, int(count)))


def _targets(
    name: str, where: str, parameters: Collection[str], sheaths: Mapping[str, str]
) -> tuple[str, ...]:
    if name in parameters:
        return (name,)
    if "*" in name:
        targets = tuple(fnmatch.filter(sorted(parameters), name))
    else:
        tendon, _, parameter = name.rpartition(".")
        of_tendon = (f"{s}.{parameter}" for s, t in sheaths.items() if t == tendon)
        targets = tuple(n for n in of_tendon if n in parameters)
    if not targets:
        raise UnknownNameError("parameter", name, parameters, where)
    return targets


class Design:
    """Every combination of the grids' values, each with the same random draws of the ranges.

    The last axis changes fastest, and draws faster than grids. That all combinations have the same
    draws keeps their scatter out of the differences between them. The first draws are the same
    whatever their number.
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
        values = np.empty((stop - start, self._axes))
        for (axis, grid), place in zip(self._grids.items(), places, strict=True):
            values[:, axis] = grid[place]
        values[:, self._drawn] = self._draws[draw]
        return values
