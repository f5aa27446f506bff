"""What to record next, and what it would decide."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tendon_mj.lab.diagnosis import SMALLEST_EXCESS
from tendon_mj.lab.experiment_design.experiment import Experiment
from tendon_mj.lab.recordings import Recording, write_recording

_APART = float(np.sqrt(SMALLEST_EXCESS))  # noise, rms: less is not worth a name


@dataclass(frozen=True)
class Difference:
    """How far two explanations differ.

    Attributes:
        one, other: labels of the two.
        recorded: rms in what was recorded [noise].
        expected: rms in the experiment that is suggested, after a fit of one to the other; without
            one, the most that an experiment within the bounds reached [noise].
    """

    one: str
    other: str
    recorded: float
    expected: float

    @property
    def decided(self) -> bool:
        """Whether the experiment tells them apart."""
        return self.expected >= _APART


@dataclass(frozen=True, eq=False)
class Suggestion:
    """An experiment that decides between explanations.

    Attributes:
        experiment: to be run; None where nothing ties, or nothing within the bounds decides.
        differences: of every two explanations that tie.
    """

    experiment: Experiment | None
    differences: tuple[Difference, ...]

    @property
    def decided(self) -> int:
        """How many of the differences the experiment tells apart."""
        return sum(d.decided for d in self.differences) if self.experiment else 0

    @property
    def recording(self) -> Recording | None:
        """Template of the recording: driven columns and states are given, measured ones are 0."""
        return None if self.experiment is None else self.experiment.recording

    @property
    def sentence(self) -> str:
        """What to record, and why."""
        if not self.differences:
            return (
                "Nothing ties: the recordings decide between all explanations that were compared."
            )
        open_ones = [d for d in self.differences if not d.decided]
        text = ""
        if self.experiment is not None:
            decided = [d for d in self.differences if d.decided]
            text = f"Record {self.experiment.words}: there {'; '.join(map(_differ, decided))}."
        if open_ones:
            pairs = "; ".join(
                f"{d.one} and {d.other}, which differ by {d.expected:.2g} times the noise at most"
                for d in open_ones
            )
            text += f"{' ' if text else ''}No experiment within the bounds tells apart {pairs}."
        return text

    def write(self, path: str | Path) -> Path | None:
        """Write the template as ``<stem>.csv`` and ``<stem>.toml``; None where there is none."""
        return None if self.recording is None else write_recording(self.recording, path)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        experiment = self.experiment
        return {
            "sentence": self.sentence,
            "motions": {
                column: vars(motion)
                for column, motion in (experiment.motions if experiment else {}).items()
            },
            "states": dict(experiment.states) if experiment else {},
            "differences": [vars(difference) for difference in self.differences],
        }


def _differ(difference: Difference) -> str:
    return (
        f"{difference.one} and {difference.other} differ by {difference.expected:.2g} times the"
        f" noise; in what was recorded, by {difference.recorded:.2g}"
    )
