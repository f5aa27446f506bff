"""Effect, wrong parameter or disturbance to hide in a reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

R = TypeVar("R")


@dataclass(frozen=True, kw_only=True)
class HiddenEffect(Generic[R]):
    """Change of a reference of type ``R``, with every number drawn but its strength.

    Attributes:
        name: identifier of the effect, parameter or disturbance.
        apply: (reference, strength > 0) → reference with the effect.
        parameters: (true reference, strength) → true values of the model's parameters.
        high: largest strength that is physical.
        usual: range of strengths of rigs, from which those of kind "drawn" are drawn.
    """

    name: str
    apply: Callable[[R, float], R]
    parameters: Callable[[R, float], dict[str, float]]
    high: float
    usual: tuple[float, float] = (0.0, 0.0)

    @property
    def low(self) -> float:
        """Smallest strength that the search considers."""
        return 1e-4 * self.high

    @property
    def start(self) -> float:
        """Strength at which the search begins."""
        return 0.1 * self.high
