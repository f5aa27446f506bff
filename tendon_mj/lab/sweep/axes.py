"""Axes of a sweep: a parameter, or several that have the same value, and the values it takes."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, UnknownNameError

MOST_ROLLOUTS = 10_000_000  # of a sweep, whose columns are read into memory
_GRID = 5  # values of a range that says no number, where nothing is drawn
_FORMS = "name=low:high, name=low:high:values or name=value,value,…"


class Axis(NamedTuple):
    """What is varied.

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

    Args:
        texts: one an axis; a name may have ``*``, and then stands for all that fit; the name of a
            tendon stands for its sheath's.
        draws: from the ranges without a number of values; 0: they are a grid of 5.
        parameters: all that there are.
        sheaths: sheath → its tendon.

    Raises:
        UnknownNameError: no such parameter, with the nearest.
        InvalidValueError: a text of another form, a range that is none, a parameter in two axes, or
            draws without a range.
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
    if not equals:
        raise InvalidValueError(f"--parameter {text}: it is not like {_FORMS}")
    targets = _targets(name, f"--parameter {text}", parameters, sheaths)
    try:
        numbers = [float(part) for part in values.split("," if ":" not in values else ":")]
    except ValueError:
        raise InvalidValueError(f"--parameter {text}: it is not like {_FORMS}") from None
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
    if count != int(count) or count < 2:
        raise InvalidValueError(f"--parameter {text}: {count:g} values; a range has at least 2")
    if count > MOST_ROLLOUTS:
        raise InvalidValueError(
            f"--parameter {text}: {count:g} values; a sweep has at most {MOST_ROLLOUTS} rollouts"
        )
    return Axis(name, targets, low, high, np.linspace(low, high, int(count)))


def _targets(
    name: str, typed: str, parameters: Collection[str], sheaths: Mapping[str, str]
) -> tuple[str, ...]:
    if name in parameters:
        found: tuple[str, ...] = (name,)
    elif "*" in name:
        found = tuple(fnmatch.filter(sorted(parameters), name))
    else:
        tendon, _, parameter = name.rpartition(".")
        of_tendon = (f"{s}.{parameter}" for s, t in sheaths.items() if t == tendon)
        found = tuple(n for n in of_tendon if n in parameters)
    if not found:
        raise UnknownNameError("parameter", name, parameters, typed)
    return found
