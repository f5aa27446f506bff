"""Bounds of the experiments that a rig can run."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Final

from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError, unknown
from tendon_mj.lab.recordings import Measured, Recording, read_text, read_toml
from tendon_mj.lab.replay import expand

Range = tuple[float, float]

_LARGEST: Final = 1e100  # number in bounds


@dataclass(frozen=True)
class DriveBounds:
    """What one driven column can do.

    Attributes:
        low, high: ends of its range [the column's unit].
        rate: highest speed [unit/s].
        dwell: longest rest at a turn [s].

    Raises:
        InvalidValueError: an empty range, a rate that is not positive, or a negative rest.
    """

    low: float
    high: float
    rate: float
    dwell: float = 0.0

    def __post_init__(self) -> None:
        _check_range("range of a drive", (self.low, self.high))
        if not 0.0 < self.rate < math.inf:
            raise InvalidValueError(f"rate = {self.rate!r} must be > 0 and finite")
        if not 0.0 <= self.dwell < math.inf:
            raise InvalidValueError(f"dwell = {self.dwell!r} [s] must be ≥ 0 and finite")


@dataclass(frozen=True, kw_only=True)
class ExperimentBounds:
    """What a rig can do in its next recording.

    Attributes:
        drive: driven column → bounds; one that is not named rests where the recordings begin.
        states: parameter → (low, high) between which the user can set it, such as the pretension
            or a bend [SI].
        limits: measured column → (low, high) that no reading may leave [its unit].
        measure: column → sensor that the rig could read besides, with its noise. It is asked for
            where nothing that was measured before decides.
        duration: of the recording [s]; 0: as long as the longest there is.

    Raises:
        InvalidValueError: nothing is driven, an empty range, a sensor without noise, or a
            negative duration.
    """

    drive: Mapping[str, DriveBounds]
    states: Mapping[str, Range] = field(default_factory=dict)
    limits: Mapping[str, Range] = field(default_factory=dict)
    measure: Mapping[str, Measured] = field(default_factory=dict)
    duration: float = 0.0

    def __post_init__(self) -> None:
        if not self.drive:
            raise InvalidValueError("bounds: no column in [drive], so nothing would move")
        for name, span in {**self.states, **self.limits}.items():
            _check_range(repr(name), span)
        for column, measured in self.measure.items():
            if measured.noise is None:
                raise InvalidValueError(
                    f"bounds, [measure] {column!r}: its noise must be stated, as it cannot be"
                    " estimated before there are readings"
                )
        if not 0.0 <= self.duration < math.inf:
            raise InvalidValueError(f"duration = {self.duration!r} [s] must be ≥ 0 and finite")

    def check(self, recording: Recording, parameters: Mapping[str, object]) -> None:
        """Refuse bounds of columns and parameters that a rig does not have, or is fitted on.

        Raises:
            UnknownNameError: no such driven or measured column, or no such parameter.
            InvalidValueError: the user sets what the recordings call uncertain, or would measure
                what they have already.
        """
        for kind, asked, there in (
            ("driven column", self.drive, recording.drive),
            ("measured column", self.limits, {*recording.measured, *self.measure}),
        ):
            for column in asked:
                if column not in there:
                    raise UnknownNameError(kind, column, there, "bounds")
        for column in self.measure:
            if column in recording.columns:
                raise InvalidValueError(
                    f"bounds, [measure] {column!r}: the recordings have this column already"
                )
        fitted = expand(recording.uncertain, parameters)
        for name in expand(self.states, parameters):
            if name not in parameters:
                raise UnknownNameError("parameter", name, parameters, "bounds, [states]")
            if name in fitted:
                raise InvalidValueError(
                    f"bounds, [states] {name!r}: the recordings call it uncertain, one value for"
                    " all; what is set for each recording is in its [known] or [session]"
                )


def read_bounds(path: str | os.PathLike[str]) -> ExperimentBounds:
    """Read bounds from TOML.

    Raises:
        RecordingError: the file cannot be read, or is not TOML.
        InvalidValueError: unknown keys, what is no number, or see `ExperimentBounds`.
    """
    where = str(path)
    toml = read_toml(read_text(Path(path)), where)
    _check_keys(toml, {f.name for f in fields(ExperimentBounds)}, set(), where)
    tables = {key: _table(toml, key, where) for key in ("drive", "states", "limits")}
    measure = {
        column: _sensor(entry, here) for column, entry, here in _table(toml, "measure", where)
    }
    ends = {"low", "high"}
    drives = {
        column: DriveBounds(**_numbers(entry, ends | {"dwell", "rate"}, ends | {"rate"}, here))
        for column, entry, here in tables["drive"]
    }
    ranges: dict[str, dict[str, Range]] = {
        key: {
            name: (found["low"], found["high"])
            for name, entry, here in tables[key]
            for found in [_numbers(entry, ends, ends, here)]
        }
        for key in ("states", "limits")
    }
    duration = _numbers({"duration": toml.get("duration", 0.0)}, {"duration"}, set(), where)
    return ExperimentBounds(
        drive=drives,
        states=ranges["states"],
        limits=ranges["limits"],
        measure=measure,
        duration=duration["duration"],
    )


def _table(toml: Mapping[str, Any], key: str, where: str) -> list[tuple[str, Any, str]]:
    """(name, entry, where) of one table."""
    table = toml.get(key, {})
    if not isinstance(table, dict):
        raise InvalidValueError(f"{where}, {key}: must be a table [{key}], got {table!r}")
    return [(name, entry, f"{where}, [{key}] {name!r}") for name, entry in table.items()]


def _sensor(entry: Any, here: str) -> Measured:
    if not isinstance(entry, dict) or not isinstance(entry.get("sensor"), str):
        raise InvalidValueError(f'{here}: write {{ sensor = "…", noise = … }}; got {entry!r}')
    numbers = {key: value for key, value in entry.items() if key != "sensor"}
    noise = _numbers(numbers, {"noise"}, {"noise"}, here)["noise"]
    try:
        return Measured(entry["sensor"], noise)
    except TendonError as error:
        raise InvalidValueError(f"{here}: {error}") from None


def _numbers(entry: Any, valid: set[str], needed: set[str], here: str) -> dict[str, float]:
    if not isinstance(entry, dict) or any(isinstance(value, dict) for value in entry.values()):
        raise InvalidValueError(
            f"{here}: write {{ low = …, high = … }}, and a name that has a dot in quotes; got"
            f" {entry!r}"
        )
    _check_keys(entry, valid, needed, here)
    for key, value in entry.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidValueError(f"{here}, {key}: must be a number, got {value!r}")
        if isinstance(value, int) and abs(value) > _LARGEST:
            raise InvalidValueError(f"{here}, {key}: must be less than {_LARGEST:g}")
    return {key: float(value) for key, value in entry.items()}


def _check_keys(entry: Mapping[str, Any], valid: set[str], needed: set[str], here: str) -> None:
    for key in entry:
        if key not in valid:
            raise InvalidValueError(f"{here}: {unknown('key', key, valid)}")
    for key in sorted(needed - entry.keys()):
        raise InvalidValueError(f"{here}: {key!r} is missing")


def _check_range(what: str, span: Range) -> None:
    low, high = span
    if not -_LARGEST <= low < high <= _LARGEST:
        raise InvalidValueError(
            f"{what}: low < high must hold, neither beyond {_LARGEST:g}, got {low!r}, {high!r}"
        )
