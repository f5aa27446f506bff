"""Which recordings a diagnosis can come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from tendon_mj.diagnosis.problem import Problem
from tendon_mj.diagnosis.regimes import motion
from tendon_mj.errors import RecordingError
from tendon_mj.simulate.recording import Recording

_FEWEST = 50  # samples


def admit(train: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse recordings from which no diagnosis can come.

    Raises:
        RecordingError: says which recording, and why.
    """
    if not train:
        raise RecordingError("a diagnosis needs at least one recording")
    first = train[0]
    for recording in (*train, *held_out):
        where = f"recording {recording.name!r}"
        if not recording.measured:
            raise RecordingError(f"{where}: no column is in [measured]: nothing to compare with")
        for name in ("model", "known", "uncertain"):
            mine, theirs = getattr(recording, name), getattr(first, name)
            if mine != theirs:
                raise RecordingError(
                    f"{where}: its {name} {_plain(mine)!r} differs from {_plain(theirs)!r} of"
                    f" {first.name!r}; recordings that are diagnosed together are of one rig"
                )
        motion(recording)
        if recording.time.size < _FEWEST:
            raise RecordingError(
                f"{where}: {recording.time.size} samples; a diagnosis needs {_FEWEST} or more"
            )
        for column in recording.measured:
            if np.ptp(recording.columns[column]) == 0.0:
                raise RecordingError(
                    f"{where}, column {column!r}: never moves, so it tells nothing"
                )
    for recordings in (train, held_out):
        for one, other in combinations(recordings, 2):
            if _same_data(one, other):
                raise RecordingError(
                    f"recording {other.name!r}: holds the same data as {one.name!r}; given twice"
                    " they would count double"
                )
    for recording in held_out:
        if any(_same_data(recording, other) for other in train):
            raise RecordingError(
                f"recording {recording.name!r}: held out, and among those that choose; proof needs"
                " data that no choice has seen"
            )


def _same_data(one: Recording, other: Recording) -> bool:
    return np.array_equal(one.time, other.time) and all(
        column in other.columns and np.array_equal(one.columns[column], other.columns[column])
        for column in one.measured
    )


def admit_simulation(problem: Problem) -> None:
    """Refuse recordings under which the model, as described, blows up.

    Raises:
        RecordingError: says which recording, and how far its drive goes.
    """
    answers = problem.simulate([{}])[0]
    for recording, series in zip(problem.recordings, answers, strict=True):
        if not all(np.isfinite(series[column]).all() for column in recording.measured):
            ranges = ", ".join(
                f"{column!r} from {recording.columns[column].min():.4g} to"
                f" {recording.columns[column].max():.4g}"
                for column in recording.drive
            )
            raise RecordingError(
                f"recording {recording.name!r}: model {recording.model!r} as described becomes"
                f" unstable under what drives it ({ranges}); are the units right?"
            )


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else value
