"""Faults of loggers, each put into one column of a recording, and their expected warnings."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tendon_mj import Measured, Recording
from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.noise import noise_levels
from tendon_mj.typing import FloatArray

_ROWS = 2  # by which the row of a warning may differ
_HEADER = 2  # row of the first sample


@dataclass(frozen=True)
class Fault:
    """A recording with a fault, and the expected warning.

    Attributes:
        recording: with the fault.
        identifiers: of warnings that name it.
        column: in which it is; "time" for the stamps.
        row: of the file, at which it begins; None where it is everywhere.
    """

    recording: Recording
    identifiers: frozenset[str]
    column: str
    row: int | None

    def named_by(self, warning: DataWarning) -> bool:
        """Return whether a warning names the fault, its column and its row."""
        column = "time_s" if self.column == "time" else self.column
        rows = [int(row) for row in re.findall(r"row (\d+)", warning.value)]
        near = self.row is None or any(abs(row - self.row) <= _ROWS for row in rows)
        right = warning.identifier in self.identifiers and f"'{column}'" in warning.place
        return right and bool(rows) and near


def _changed(recording: Recording, column: str, series: FloatArray) -> Recording:
    return replace(recording, columns={**recording.columns, column: series})


def _unit(recording: Recording, ending: str) -> list[str]:
    return [c for c in recording.measured if c.endswith(ending)]


def _some_row(recording: Recording, random: np.random.Generator) -> int:
    return int(random.uniform(0.3, 0.7) * recording.time.size)


def _step(recording: Recording, column: str, row: int, size: float) -> Fault:
    series = recording.columns[column].copy()
    series[row:] += size
    made = _changed(recording, column, series)
    return Fault(made, frozenset({"zero_step"}), column, row + _HEADER)


def tare(recording: Recording, random: np.random.Generator) -> Fault:
    """A load cell is set to zero under load."""
    column, row = random.choice(_unit(recording, "_N")), _some_row(recording, random)
    return _step(recording, column, row, -recording.columns[column][row])


def small_step(recording: Recording, random: np.random.Generator) -> Fault:
    """A zero steps by 10 to 40 noises."""
    column, row = random.choice([*recording.measured]), _some_row(recording, random)
    size = noise_levels(recording)[column] * random.uniform(10.0, 40.0) * random.choice([-1, 1])
    return _step(recording, column, row, size)


def encoder_reset(recording: Recording, random: np.random.Generator) -> Fault:
    """A measured position starts again at 0."""
    column = random.choice(_unit(recording, "_rad") or _unit(recording, "_m"))
    series = recording.columns[column]
    away = np.abs(series) > 0.25 * np.ptp(series)
    rows = np.flatnonzero(away & (np.arange(series.size) > 0.3 * series.size))
    row = int(rows[int(0.5 * rows.size)])
    return _step(recording, column, row, -series[row])


def drive_reset(recording: Recording, random: np.random.Generator) -> Fault:
    """The encoder of the drive loses its zero."""
    column, row = next(iter(recording.drive)), _some_row(recording, random)
    size = random.uniform(0.2, 0.6) * random.choice([-1, 1]) * np.ptp(recording.columns[column])
    return _step(recording, column, row, size)


def below_zero(recording: Recording, random: np.random.Generator) -> Fault:
    """A load cell whose zero was set under load reads less than 0 if the cable is let off."""
    column = random.choice(_unit(recording, "_N"))
    series = recording.columns[column]
    low = 20.0 * noise_levels(recording)[column]
    made = series - np.percentile(series, random.uniform(10.0, 40.0)) - low
    fault = _changed(recording, column, made)
    return Fault(fault, frozenset({"below_zero"}), column, int(np.argmin(made)) + _HEADER)


def end_reached(recording: Recording, random: np.random.Generator) -> Fault:
    """An amplifier ends below the largest readings."""
    return _cut(recording, random, -np.inf, random.uniform(75.0, 96.0))


def both_ends_reached(recording: Recording, random: np.random.Generator) -> Fault:
    """A converter ends at both ends."""
    return _cut(recording, random, random.uniform(5.0, 20.0), random.uniform(80.0, 95.0))


def _cut(recording: Recording, random: np.random.Generator, low: float, high: float) -> Fault:
    column = random.choice([*recording.measured])
    series = recording.columns[column]
    ends = [np.percentile(series, q) if np.isfinite(q) else q for q in (low, high)]
    made = np.clip(series, ends[0], ends[1])
    row = int(np.argmax(np.isin(made, ends))) + _HEADER
    return Fault(_changed(recording, column, made), frozenset({"range_end"}), column, row)


def repeated(recording: Recording, random: np.random.Generator) -> Fault:
    """A sensor is read 1.5 to 6 times as often as it converts."""
    column = random.choice([*recording.measured])
    rows = np.arange(recording.time.size)
    times = random.uniform(1.5, 6.0)
    taken = np.floor(np.ceil(rows / times - 1e-9) * times).astype(int)
    taken = np.where(taken > rows, np.floor(np.floor(rows / times) * times).astype(int), taken)
    made = _changed(recording, column, recording.columns[column][taken])
    return Fault(made, frozenset({"repeated"}), column, None)


def coarse(recording: Recording, random: np.random.Generator) -> Fault:
    """A converter's steps are coarser than the noise that is stated."""
    column = random.choice([*recording.measured])
    noise = noise_levels(recording)[column]
    step = noise * random.uniform(5.0, 20.0)
    series = np.round(recording.columns[column] / step) * step
    measured = {**recording.measured, column: Measured(recording.measured[column].sensor, noise)}
    made = replace(_changed(recording, column, series), measured=measured)
    return Fault(made, frozenset({"coarse"}), column, None)


def coarse_unstated(recording: Recording, random: np.random.Generator) -> Fault:
    """The same, and no noise is stated."""
    made = coarse(recording, random)
    measured = {c: Measured(m.sensor) for c, m in recording.measured.items()}
    return replace(made, recording=replace(made.recording, measured=measured))


def arrival_times(recording: Recording, random: np.random.Generator) -> Fault:
    """Times at which samples arrived: late by up to 0.3 to 0.9 intervals."""
    step = recording.time[1] - recording.time[0]
    late = random.uniform(0.0, random.uniform(0.3, 0.9), recording.time.size) * step
    made = replace(recording, time=np.round(recording.time + late, 5))
    return Fault(made, frozenset({"uneven_times"}), "time", None)


def lost_rows(recording: Recording, random: np.random.Generator) -> Fault:
    """Rows are lost one by one, and 15 to 40 in a row."""
    keep = random.uniform(size=recording.time.size) > 0.05
    row, burst = _some_row(recording, random), int(random.integers(15, 40))
    keep[row : row + burst] = False
    keep[[0, row - 1, row + burst]] = True
    columns = {c: series[keep] for c, series in recording.columns.items()}
    made = replace(recording, time=recording.time[keep], columns=columns)
    return Fault(made, frozenset({"gap"}), "time", int(keep[:row].sum()) - 1 + _HEADER)


def turn(recording: Recording, random: np.random.Generator) -> Fault:
    """A position of one turn begins again; the zero after homing is known."""
    angles = [c for c in (*recording.drive, *recording.measured) if c.endswith("_rad")]
    if not angles:
        return counter(recording, random)
    column = random.choice(angles)
    series, full = recording.columns[column], 2.0 * np.pi
    offset = np.percentile(series, random.uniform(20.0, 80.0))
    made = np.mod(series - offset, full)
    if column in recording.drive:
        actuator = recording.drive[column]
        scale = recording.known.get(f"{actuator}.command_scale", 1.0)
        known = {f"{actuator}.command_offset": scale * offset}
    else:
        known = {f"{recording.measured[column].sensor}.offset": -offset}
    row = int(np.argmax(np.abs(np.diff(made)) > 0.5 * full)) + 1 + _HEADER
    fault = replace(_changed(recording, column, made), known={**recording.known, **known})
    return Fault(fault, frozenset({"turn", "wraps"}), column, row)


def counter(recording: Recording, random: np.random.Generator) -> Fault:
    """A column of counts, times a constant, begins again after 2^n of them."""
    column = random.choice([*recording.measured])
    series, bits = recording.columns[column], int(random.integers(10, 17))
    period = random.uniform(1.1, 3.0) * np.ptp(series)
    count = period / 2**bits
    offset = np.percentile(series, random.uniform(20.0, 80.0))
    made = np.mod(np.round((series - offset) / count), 2**bits) * count
    known = {f"{recording.measured[column].sensor}.offset": -offset}
    row = int(np.argmax(np.abs(np.diff(made)) > 0.5 * period)) + 1 + _HEADER
    fault = replace(_changed(recording, column, made), known={**recording.known, **known})
    return Fault(fault, frozenset({"turn", "wraps"}), column, row)


def other_scale(recording: Recording, random: np.random.Generator) -> Fault:
    """An amplifier is switched midway."""
    column, row = random.choice([*recording.measured]), _some_row(recording, random)
    series = recording.columns[column].copy()
    series[row:] *= random.choice([random.uniform(0.5, 0.85), random.uniform(1.2, 2.0)])
    made = _changed(recording, column, series)
    return Fault(made, frozenset({"scale_change"}), column, row + _HEADER)


def held_drive(recording: Recording, random: np.random.Generator) -> Fault:
    """The drive is read two to five times as often as it is updated; stairs do not show it."""
    column = next(iter(recording.drive))
    times = int(random.integers(2, 6))
    rows = np.arange(recording.time.size) // times * times
    made = _changed(recording, column, recording.columns[column][rows])
    return Fault(made, frozenset({"repeated"}), column, None)


def dropouts(recording: Recording, random: np.random.Generator) -> Fault:
    """A reading is 0, or another fixed value, for one to four samples, three to eight times."""
    column = random.choice([*recording.measured])
    series = recording.columns[column].copy()
    value = random.choice([0.0, series.min() - 0.1 * np.ptp(series)])
    away = np.abs(series - value) > 0.3 * np.ptp(series)
    places = 20 * random.permutation(np.arange(1, series.size // 20 - 1))
    starts = [k for k in places.tolist() if away[k - 4 : k + 8].all()][: random.integers(3, 9)]
    for start in starts:
        series[start : start + random.integers(1, 5)] = value
    return Fault(
        _changed(recording, column, series), frozenset({"spike"}), column, min(starts) + _HEADER
    )


def edge_glitch(recording: Recording, random: np.random.Generator) -> Fault:
    """The first or the last reading is none of the rig's."""
    column, row = random.choice([*recording.measured]), int(random.choice([0, -1]))
    series = recording.columns[column].copy()
    series[row] += random.uniform(1.0, 20.0) * np.ptp(series) * random.choice([-1, 1])
    row = row % series.size + _HEADER
    return Fault(_changed(recording, column, series), frozenset({"spike"}), column, row)


def hang(recording: Recording, random: np.random.Generator) -> Fault:
    """A reading repeats exactly for 15 to 40 samples while the rig moves."""
    column, rows = random.choice([*recording.measured]), int(random.integers(15, 41))
    series = recording.columns[column].copy()
    moved = np.ptp(np.lib.stride_tricks.sliding_window_view(series[20:-20], rows), axis=1)
    far = np.flatnonzero(moved > 15.0 * noise_levels(recording)[column])
    row = 20 + int(random.choice(far))
    series[row : row + rows] = series[row]
    made = _changed(recording, column, series)
    return Fault(made, frozenset({"frozen", "repeated"}), column, row + _HEADER)


def other_drive_scale(recording: Recording, random: np.random.Generator) -> Fault:
    """The drive is logged in another scale midway, while it is away from 0."""
    column = next(iter(recording.drive))
    series = recording.columns[column].copy()
    away = np.abs(series) > 0.5 * np.abs(series).max()
    middle = np.abs(np.arange(series.size) / series.size - 0.5) < 0.25
    row = int(random.choice(np.flatnonzero(away & middle)))
    series[row:] *= random.choice([random.uniform(0.4, 0.75), random.uniform(1.4, 2.5)])
    made = _changed(recording, column, series)
    return Fault(made, frozenset({"scale_change"}), column, row + _HEADER)


FAULTS: Mapping[str, Callable[[Recording, np.random.Generator], Fault]] = {
    made.__name__.replace("_", " "): made
    for made in (
        tare,
        small_step,
        encoder_reset,
        drive_reset,
        below_zero,
        end_reached,
        both_ends_reached,
        repeated,
        held_drive,
        coarse,
        coarse_unstated,
        arrival_times,
        lost_rows,
        turn,
        counter,
        other_scale,
        dropouts,
        edge_glitch,
        hang,
        other_drive_scale,
    )
}
