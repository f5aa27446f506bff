"""Which bends are given and which are predicted."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from experiments.measured_joint.recording import bound_zeros, degrees
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording

BETWEEN, BEYOND, LEFT_OUT = "between", "beyond", "left out"
_GIVEN = {BETWEEN: (0, 120, 240), BEYOND: (0, 120)}  # [deg]


@dataclass(frozen=True)
class Split:
    """Recordings that are given, and those that are predicted from them."""

    train: tuple[Recording, ...]
    held_out: tuple[Recording, ...]


def make_splits(recordings: Sequence[Recording]) -> Mapping[str, list[Split]]:
    """Bends between given ones, bends beyond them, and each bend left out of all.

    Raises:
        RecordingError: a bend that is to be given is not there, or no other.
    """
    splits = {name: [_split(recordings, given)] for name, given in _GIVEN.items()}
    beyond = splits[BEYOND][0]
    larger = tuple(r for r in beyond.held_out if degrees(r) > max(_GIVEN[BEYOND]))
    splits[BEYOND] = [Split(beyond.train, larger)]
    splits[LEFT_OUT] = [
        _split(recordings, [degrees(r) for r in recordings if r is not left]) for left in recordings
    ]
    return splits


def _split(recordings: Sequence[Recording], given: Collection[int]) -> Split:
    there = {degrees(r) for r in recordings}
    missing = sorted(set(given) - there)
    if missing or there <= set(given):
        raise RecordingError(
            f"recordings of {sorted(given)} deg and of other bends are needed; there are"
            f" {sorted(there)} deg"
        )
    train = [r for r in recordings if degrees(r) in given]
    held_out = [r for r in recordings if degrees(r) not in given]
    return Split(tuple(bound_zeros(train, train)), tuple(bound_zeros(held_out, train)))
