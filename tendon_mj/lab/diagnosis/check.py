"""Checks that refuse recordings and simulators that are unusable for a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.diagnosis.data import (
    MakeSimulator,
    Problem,
    all_samples,
    check_answers,
    training_samples,
)
from tendon_mj.lab.diagnosis.regimes import motion
from tendon_mj.lab.noise import noise_of_repeats
from tendon_mj.lab.recordings import Recording, is_same_model
from tendon_mj.lab.replay import Parameter, Simulates

_FEWEST = 50  # samples of a motion, where neighbours repeat each other
_FEWEST_RESTS, _FEWEST_PROVE = 20, 10  # rows that are rests, in all to fit and in all held out
_FEWEST_REPEATS = 6  # rests that repeat others, from which noise can be estimated
_SHOWN = 4  # values of a description, in a message
_FINEST, _WIDEST = 1e-12, 1e3  # noise over the range of its column
_MEMBERS = ("parameters", "__call__", "joints", "steps", "in_steps")  # of `Simulates`


def check_recordings(train: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse recordings that are unusable for a diagnosis."""
    if not train:
        raise RecordingError("a diagnosis needs at least one recording")
    masks = (*training_samples(train, held_out), *all_samples(held_out))
    for recording, mask in zip((*train, *held_out), masks, strict=True):
        _check_same_rig(recording, train[0])
        _check_motion(recording, mask)
        for column in recording.measured:
            _check_column(recording, column, mask)
    _check_rests(train, _FEWEST_RESTS, "a diagnosis")
    _check_rests(held_out, _FEWEST_PROVE, "its proof")
    for one, other in (*combinations(train, 2), *combinations(held_out, 2)):
        if _same_data(one, other):
            raise RecordingError(
                f"recording {other.name!r}: holds the same data as {one.name!r}, which would"
                " count double"
            )
    for seen, unseen in product(train, held_out):
        if _same_data(seen, unseen):
            raise RecordingError(
                f"recording {unseen.name!r}: held out, and among the training data; proof needs"
                " data that the selection has not seen"
            )


def _check_same_rig(recording: Recording, first: Recording) -> None:
    """Refuse a recording without measurements, or of another rig than the first."""
    where = f"recording {recording.name!r}"
    if not recording.measured:
        raise RecordingError(f"{where}: [measured] lists no column to compare with")
    models = recording.model, first.model
    uncertain = dict(recording.uncertain), dict(first.uncertain)
    for name, (mine, theirs), same in (
        ("model", models, is_same_model(*models)),
        ("uncertain", uncertain, uncertain[0] == uncertain[1]),
    ):
        if not same:
            raise RecordingError(
                f"{where}: its {name} {mine!r} differs from {theirs!r} of"
                f" {first.name!r}; recordings that are diagnosed together are of one rig"
            )


def _check_motion(recording: Recording, mask: NDArray[np.bool_]) -> None:
    """Refuse a recording of too few samples, or that does not move back and forth."""
    motion(recording)
    if not recording.quasi_static and recording.time.size < _FEWEST:
        raise RecordingError(
            f"recording {recording.name!r}: {recording.time.size} samples; a diagnosis needs"
            f" {_FEWEST} or more; if each row was read at rest after a move, write quasi_static ="
            f" true under [timing]: {_FEWEST_RESTS} such rows are enough"
        )
    if not mask.all():
        columns = {name: series[mask] for name, series in recording.columns.items()}
        try:
            motion(replace(recording, time=recording.time[mask], columns=columns))
        except RecordingError as error:
            raise RecordingError(f"{error}{_kept(mask)}") from None


def _check_column(recording: Recording, column: str, mask: NDArray[np.bool_]) -> None:
    """Refuse a column that is constant, or whose noise is out of proportion or unknown."""
    where, series = f"recording {recording.name!r}", recording.columns[column]
    if np.ptp(series[mask]) == 0.0:
        raise RecordingError(f"{where}, column {column!r}: never moves{_kept(mask)}")
    stated, extent = recording.measured[column].noise, float(np.ptp(series))
    if stated is not None and not _FINEST * extent <= stated <= _WIDEST * extent:
        raise RecordingError(
            f"{where}, [measured] {column!r}: noise = {stated:g} is {stated / extent:.2g} times"
            f" the range of the column, {extent:g}; it must be {_FINEST:g} … {_WIDEST:g} times. Is"
            " it in the column's unit? Left out, it is estimated"
        )
    repeats = _FEWEST_REPEATS
    if stated is None and recording.quasi_static:
        repeats = noise_of_repeats(recording, column)[1]
    if repeats < _FEWEST_REPEATS:
        raise RecordingError(
            f"{where}, [measured] {recording.written(column)!r}: its noise is not stated, and"
            f" {repeats} rests repeat another one; state noise = …, or measure {_FEWEST_REPEATS} or"
            " more points again, each after the same point before"
        )


def _check_rests(recordings: Sequence[Recording], fewest: int, needs: str) -> None:
    """Refuse too few rows that are rests, where no motion was recorded."""
    rows = sum(recording.time.size for recording in recordings)
    if recordings and all(r.quasi_static for r in recordings) and rows < fewest:
        names = ", ".join(repr(recording.name) for recording in recordings)
        plural = "s" if len(recordings) > 1 else ""
        raise RecordingError(
            f"recording{plural} {names}: only {rows} settled points; {needs} needs {fewest} or more"
        )


def _kept(mask: NDArray[np.bool_]) -> str:
    return "" if mask.all() else "; its last quarter does not count, it is kept for the proof"


def _same_data(one: Recording, other: Recording) -> bool:
    """Return whether the measured columns of one are a stretch of the other's, at whatever time."""
    if one.time.size > other.time.size:
        one, other = other, one
    if not one.measured.keys() <= other.columns.keys():
        return False
    size, first = one.time.size, next(iter(one.measured))
    begins = other.columns[first][: other.time.size - size + 1] == one.columns[first][0]
    return any(
        all(np.array_equal(other.columns[c][k : k + size], one.columns[c]) for c in one.measured)
        for k in np.flatnonzero(begins)
    )


def make_simulator(make: MakeSimulator, recordings: Sequence[Recording]) -> Simulates:
    """Make a simulator of recordings, and refuse one that lacks a member."""
    if not isinstance(make, type) and hasattr(make, "parameters"):
        raise InvalidValueError(
            f"simulator: {type(make).__name__!r} object is a simulator already; give a function"
            " that makes one of recordings, such as its class"
        )
    made = make(recordings)
    name, missing = type(made).__name__, [m for m in _MEMBERS if not hasattr(made, m)]
    if missing:
        raise InvalidValueError(
            f"simulator {name!r} lacks {', '.join(map(repr, missing))}; derive it from"
            " tendon_mj.Simulates, set 'parameters' and define '__call__': the other members then"
            " have defaults"
        )
    parameters: object = made.parameters  # of any type: the class is a user's
    if not isinstance(parameters, Mapping) or not all(
        isinstance(parameter, Parameter) for parameter in parameters.values()
    ):
        raise InvalidValueError(
            f"simulator {name!r}: parameters = {parameters!r} must be a mapping of names to"
            " tendon_mj.Parameter, which has value, unit and kind"
        )
    return made


def check_simulation(problem: Problem) -> None:
    """Refuse recordings under which the model, as described, becomes unstable."""
    answers = problem.simulate([{}])
    check_answers(answers, 1, problem.recordings, problem.simulate)
    for recording, series in zip(problem.recordings, answers[0], strict=True):
        if not all(np.isfinite(series[column]).all() for column in recording.measured):
            ranges = ", ".join(
                f"{column!r} from {recording.columns[column].min():.4g} to"
                f" {recording.columns[column].max():.4g}"
                for column in recording.drive
            )
            raise RecordingError(
                f"recording {recording.name!r}: model {recording.model!r} as described becomes"
                f" unstable when driven by {ranges}{_described(recording)}; are the units right?"
            )


def _described(recording: Recording) -> str:
    """The values that a description gives its model, such as " with sheath.friction = 0.1"."""
    uncertain = {name: entry.value for name, entry in recording.uncertain.items()}
    session = {name: entry.value for name, entry in recording.session.items()}
    values = [*recording.known.items(), *uncertain.items(), *session.items()]
    shown = [f"{name} = {value:g}" for name, value in values[:_SHOWN]]
    more = f" and {len(values) - _SHOWN} values more" if len(values) > _SHOWN else ""
    return f" with {', '.join(shown)}{more}" if shown else ""
