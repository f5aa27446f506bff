"""Ranges of the parameters that are drawn anew for every episode."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from tendon_mj.errors import InvalidValueError

Random = np.random.RandomState | np.random.Generator  # dm_control's, gymnasium's
_UNITS = {"friction": "-", "pretension": "N", "bend": "rad", "axial_stiffness": "N"}
_POSITIVE = ("axial_stiffness",)  # the others may be 0


@dataclass(frozen=True, kw_only=True)
class Ranges:
    """(low, high) of every number that an episode draws uniformly; low = high keeps it.

    Friction, pretension and axial stiffness are live parameters of the simulation's data: setting
    them costs nothing. Bend is geometry, so unless it is kept the model is built anew for every
    episode (about 5 ms).

    Attributes:
        friction: μ, the same for both tendons [-].
        pretension: T_0 of both tendons [N].
        axial_stiffness: EA of both tendons [N].
        bend: of both sheaths [rad].

    Raises:
        InvalidValueError: not two finite numbers in order, below 0, or 0 where it must not be.
    """

    friction: tuple[float, float] = (0.05, 0.25)
    pretension: tuple[float, float] = (3.0, 6.0)
    axial_stiffness: tuple[float, float] = (2000.0, 2000.0)
    bend: tuple[float, float] = (math.pi / 3.0, math.pi)

    def __post_init__(self) -> None:
        for field in fields(self):
            limits = _pair(field.name, getattr(self, field.name))
            object.__setattr__(self, field.name, limits)

    def draw(self, random: Random) -> dict[str, float]:
        """One number from each range, by name."""
        return {f.name: float(random.uniform(*getattr(self, f.name))) for f in fields(self)}


def _pair(name: str, given: object) -> tuple[float, float]:
    """Return (low, high) as two numbers in order; raise `InvalidValueError` for anything else."""
    where = f"{name} = {given!r} [{_UNITS[name]}]"
    bound = "> 0" if name in _POSITIVE else "≥ 0"
    try:
        low, high = (float(number) for number in given)  # type: ignore[attr-defined]
    except (TypeError, ValueError, OverflowError):
        hint = f"; to keep it at {given}, ({given}, {given})" if _is_number(given) else ""
        raise InvalidValueError(f"{where} must be a pair of numbers (low, high){hint}") from None
    if not (math.isfinite(high) and 0.0 <= low <= high) or (low == 0.0 and name in _POSITIVE):
        raise InvalidValueError(f"{where} must be a pair (low, high), finite, in order and {bound}")
    return low, high


def _is_number(given: object) -> bool:
    return isinstance(given, int | float) and not isinstance(given, bool)
