"""Plan of one hidden case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "effect",
    "pair",
    "parameter",
    "nothing",
    "outside",
    "joint",
    "session",
    "remainder",
    "too_high",
    "drawn",
]
# Those that have what reality has; each of their cases has its own model beside its recordings.
REAL_KINDS = ("session", "remainder", "too_high")


@dataclass(frozen=True, kw_only=True)
class CasePlan:
    """Content of a case, before anything is drawn.

    Attributes:
        kind: of the case.
        names: of the hidden effects, wrong numbers or disturbances.
        target: wanted ratio of residual to noise, for each of them [-]; of kind "session" to the
            reproducibility, of kind "remainder" to what the small effects leave. Of kind "drawn" it
            is that of the second effect, and the strength of the first is drawn.
        noise: standard deviation over the range of each measured column [-].
        exclude: effects to take out of the catalogue when diagnosing.
        seed: of every random draw.
        rig: that the case is of.
        small: names of what leaves the remainder.
        bends: whether the sheath's bend differs between the recordings.
    """

    kind: Kind
    names: tuple[str, ...]
    target: float
    noise: float
    exclude: tuple[str, ...]
    seed: tuple[int, ...]
    rig: Literal["bench", "joint"] = "bench"
    small: tuple[str, ...] = ()
    bends: bool = False
