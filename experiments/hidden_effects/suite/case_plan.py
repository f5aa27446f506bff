"""Plan of one hidden case."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class CasePlan:
    """Content of a case, before anything is drawn.

    Attributes:
        kind: "effect", "pair", "parameter", "nothing", "outside" or "joint".
        names: of the hidden effects, parameters or disturbances.
        target: wanted ratio of residual to noise, for each of them [-].
        noise: standard deviation over the range of each measured column [-].
        exclude: effects to take out of the catalogue when diagnosing.
        seed: of every random draw.
    """

    kind: str
    names: tuple[str, ...]
    target: float
    noise: float
    exclude: tuple[str, ...]
    seed: tuple[int, ...]
