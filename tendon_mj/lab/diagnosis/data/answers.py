"""Check of what a simulator answers, which may be a user's own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Series, Simulates


def check_answers(
    answers: Sequence[Sequence[Series]],
    sets: int,
    recordings: Sequence[Recording],
    simulator: Simulates,
) -> None:
    """Refuse answers that are not (n,) series of every measured column, for every set.

    Args:
        answers: of ``simulator`` to ``sets`` sets of parameters, see `Simulates.__call__`.
        sets: how many were asked for.
        recordings: that it simulates.
        simulator: whose class the message names.

    Raises:
        InvalidValueError: names the recording and column, and what was answered.
    """
    who = f"simulator {type(simulator).__name__!r}"
    if len(answers) != sets:
        raise InvalidValueError(
            f"{who} answered {len(answers)} sets of parameters, not the {sets} it was asked for"
        )
    for answer in answers:
        if len(answer) != len(recordings):
            raise InvalidValueError(
                f"{who} answered for {len(answer)} recordings, not for {len(recordings)}"
            )
        for recording, series in zip(recordings, answer, strict=True):
            for column in recording.measured:
                _check_series(f"{who}, recording {recording.name!r}", column, series, recording)


def _check_series(where: str, column: str, series: Series, recording: Recording) -> None:
    if column not in series:
        raise InvalidValueError(
            f"{where}: answered {', '.join(map(repr, series)) or 'nothing'}, but {column!r} is in"
            " [measured]"
        )
    shape = np.shape(series[column])
    if shape != recording.time.shape:
        raise InvalidValueError(
            f"{where}, column {column!r}: answered shape {shape}, but the recording has"
            f" {recording.time.shape}"
        )
