"""One thing to hide, drawn but for its strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

R = TypeVar("R")


@dataclass(frozen=True, kw_only=True)
class Hidden(Generic[R]):
    """An effect, a wrong number or something strange, on a rig of type ``R``.

    Attributes:
        name: identifier of the effect or parameter.
        apply: a rig and a strength > 0 to the rig with it.
        numbers: the true rig and the strength to the model's parameters that are then true.
        low, high, start: range of the strength that is physical, and where its search begins.
    """

    name: str
    apply: Callable[[R, float], R]
    numbers: Callable[[R, float], dict[str, float]]
    low: float
    high: float
    start: float


def hidden(
    name: str,
    apply: Callable[[R, float], R],
    numbers: Callable[[R, float], dict[str, float]],
    high: float,
) -> Hidden[R]:
    """A thing to hide whose strength goes up to ``high``."""
    return Hidden(
        name=name, apply=apply, numbers=numbers, low=1e-4 * high, high=high, start=0.1 * high
    )
