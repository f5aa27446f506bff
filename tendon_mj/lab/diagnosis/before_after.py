"""Recordings beside their simulations by the model before and after a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.replay import Simulates, as_recording, described_values, values_for

_LONGEST_NAME = 200  # bytes


class BeforeAfter(NamedTuple):
    """A recording and two simulations of it.

    Attributes:
        measured: the recording.
        before: by the model with only what was uncertain fitted.
        after: by the final model.
    """

    measured: Recording
    before: Recording
    after: Recording


def simulate_before_after(
    recordings: Sequence[Recording],
    simulator: Simulates,
    before: Mapping[str, float],
    after: Mapping[str, float],
    progress: Progress = silent,
) -> list[BeforeAfter]:
    """Simulate recordings with two sets of parameters.

    Args:
        recordings: those that ``simulator`` simulates.
        simulator: of the model.
        before, after: the parameters that are set.
        progress: called with a label, how much is done, and of how much.
    """
    label = "simulate before and after"
    progress(label, 0, 1)
    answers = simulator([before, after])
    progress(label, 1, 1)
    return [
        BeforeAfter(
            recording,
            as_recording(recording, first, _applied(recording, simulator, before)),
            as_recording(recording, second, _applied(recording, simulator, after)),
        )
        for recording, first, second in zip(recordings, *answers, strict=True)
    ]


def _applied(
    recording: Recording, simulator: Simulates, values: Mapping[str, float]
) -> dict[str, float]:
    """Every parameter that a simulation of the recording was given."""
    return {
        **described_values(recording, simulator.parameters),
        **values_for(recording.name, values),
    }


def write_before_after(simulated: Sequence[BeforeAfter], folder: Path) -> list[Path]:
    """Write simulations as recordings, ``<k>_<name>_before.csv`` and ``<k>_<name>_after.csv``.

    Args:
        simulated: of one diagnosis.
        folder: that exists.

    Returns:
        Paths of the CSVs, whose names are cut where a file's name cannot be so long; the
        description of each lies beside it.
    """
    return [
        write_recording(recording, folder / f"{k}_{_short(row.measured.name)}_{when}.csv")
        for k, row in enumerate(simulated)
        for when, recording in (("before", row.before), ("after", row.after))
    ]


def _short(name: str) -> str:
    """The beginning of a name, as much as leaves room for more in the 255 bytes of a file's."""
    return name.encode()[:_LONGEST_NAME].decode(errors="ignore")
