"""Models that are compared, each with the effects that it leaves out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from experiments.cable_tool.fit import PER_RECORDING, PLAY_ALONE, fit_tool
from experiments.cable_tool.recording import ToolRecording
from experiments.cable_tool.rivals import fit_regression, fit_steady_load
from tendon_mj.typing import FloatArray

CHOSEN = "sheath and constant friction"


class Predicts(Protocol):
    """Prediction of the load from a recording's input side."""

    def load(self, recording: ToolRecording) -> FloatArray:
        """Load at the output [N m]."""


@dataclass(frozen=True)
class Candidate:
    """A model to compare.

    Attributes:
        name: in tables.
        numbers: how many it fits, for the load alone.
        fit: makes a predictor from recordings.
    """

    name: str
    numbers: int
    fit: Callable[[Sequence[ToolRecording]], Predicts]


CANDIDATES = (
    Candidate(CHOSEN, 6, fit_tool),
    Candidate(
        "… without a number for the wrist",
        5,
        lambda recordings: fit_tool(recordings, {**PER_RECORDING, "wrist_friction": 0.0}),
    ),
    Candidate(
        "… play alone, without sliding",
        5,
        lambda recordings: fit_tool(recordings, {**PER_RECORDING, "take_up": PLAY_ALONE}),
    ),
    Candidate(
        "… with one opening offset for all recordings",
        6,
        lambda recordings: fit_tool(recordings, {"load_difference": None}),
    ),
    Candidate(
        "… with one opening offset, play alone",
        5,
        lambda recordings: fit_tool(recordings, {"load_difference": None, "take_up": PLAY_ALONE}),
    ),
    Candidate(
        "constant friction alone (λ = 0), play alone",
        3,
        lambda recordings: fit_tool(
            recordings,
            {
                "load_difference": None,
                "friction_exponent": 0.0,
                "wrist_friction": 0.0,
                "take_up": PLAY_ALONE,
            },
        ),
    ),
    Candidate("regression by direction", 4, fit_regression),
    Candidate("steady load", 4, fit_steady_load),
)
