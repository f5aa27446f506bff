"""Check of a recording: its times, and its columns against the model at the stated numbers."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from warnings import catch_warnings

import mujoco
import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.data_check.actuators import (
    actuation_warnings,
    play_warnings,
    prescribed_warnings,
    stated_play,
)
from tendon_mj.lab.data_check.columns import (
    DataWarning,
    converter_warnings,
    degree_warnings,
    drive_warnings,
    noise_warnings,
    reading_warnings,
    row_of,
    slack_warnings,
    spike_warnings,
    turn_warnings,
)
from tendon_mj.lab.data_check.jumps import jump_warnings
from tendon_mj.lab.recordings import TIME, TIMES, Recording, noise_levels
from tendon_mj.lab.replay import (
    Adjustable,
    Schedule,
    load_recorded,
    quantity,
    replay_recording,
    stated_values,
)
from tendon_mj.sheath import doubt_of_unit
from tendon_mj.typing import FloatArray

_WRONG_TIMES = ("times_in_ms", "times_too_short")  # with which no simulation is of use
_DRIVE_LOST = ("turn", "wraps", "zero_step")
_JUMPED = {
    *("spike", "frozen", "start", "below_zero", "unit"),
    *("sign", "slack", "saturated", "weak_motor"),
}
# warning → others of the same column that follow from it
_FOLLOWS = {
    "range_end": {"frozen", "coarse"},
    "repeated": {"frozen"},
    "coarse": {"frozen"},
    "below_zero": {"start"},
    "spike": {"below_zero", "range_end", "repeated"},
    "sign": {"below_zero"},
    "nothing_moves": {"below_zero", "noise"},
    "unit": {"below_zero", "coarse", "noise"},
    "turn": _JUMPED,
    "wraps": _JUMPED,
    "zero_step": _JUMPED,
    "scale_change": _JUMPED,
}
_SLOW = 0.5  # median interval [s] above which times may be in ms
_ENOUGH = 100  # samples
_FAST, _SHORT = 5e-5, 0.5  # median interval and span [s] below which times may be in larger units
_GAP = 5.0  # times the median interval
_ENDS = 3  # intervals on either side of a gap that say how the drive moved
_UNSEEN = 0.02  # of a drive's range, by which it may differ from a line in a gap
_WHOLE, _MOST, _FEW = 0.2, 0.9, 3  # intervals that are whole multiples; missing rows at least
_UNEVEN, _OFTEN = 0.1, 0.1  # of the usual interval, beyond the clock's step; share of intervals
_DECIMALS = 9
_VISIBLE = 0.45  # noise rms: an error that a diagnosis does not put down to noise
_SMOOTHER, _MOVES = 0.7, 0.3  # of another roughness; of the largest change, that is motion
_LONG_SETTLE = 60.0  # [s] that no rig needs to come to rest
_LONGER = (2.0, 4.0, 8.0, 16.0)  # times a settle, to see whether it was too short


@dataclass(frozen=True)
class Checked:
    """A recording, its simulation, and warnings."""

    recording: Recording  # as given
    # at the numbers that the description states; None if the times are wrong, or the simulation
    # failed
    simulated: Recording | None
    warnings: tuple[DataWarning, ...]  # in the order in which to look at them

    def __repr__(self) -> str:
        found = [f"warning: {warning.sentence}" for warning in self.warnings]
        return "\n  ".join([f"Checked {self.recording.name!r}:", *(found or ["no faults found"])])


def check_recording(
    recording: Recording,
    model: mujoco.MjModel | None = None,
    *,
    described: bool | None = None,
    settle: float | None = None,
) -> Checked:
    """Simulate a recording at the numbers that its description states, and warn of its oddities.

    Args:
        recording: driven and measured columns.
        model: in place of the one that the recording names; not changed.
        described: whether its description's values are applied, as in `replay_recording`.
        settle: time before the first sample [s]; default: as the recording says.

    Raises:
        RecordingError, UnknownNameError, InvalidValueError: as `replay_recording`, of a
            recording that cannot be simulated, such as of a sensor that the model lacks.
    """
    given = model is not None
    if model is None:
        model = load_recorded(recording)
    adjustable = Adjustable(copy.copy(model))
    timing, still = timing_warnings(recording), drive_warnings(recording)
    if any(warning.identifier in _WRONG_TIMES for warning in timing):
        return Checked(recording, None, (*timing, *still))
    schedule = Schedule(recording, adjustable.model, settle)  # refuses a recording of another model
    stated = stated_values(recording, model, adjustable.parameters(), described, given=given)
    adjustable.set(stated)

    def replay(other: Recording) -> Recording | None:
        return _simulate(other, model, stated, settle)[0]

    simulated, failed = _simulate(recording, model, stated, settle)
    degrees = degree_warnings(recording, simulated, replay)
    jumps = list[DataWarning]()
    if not recording.quasi_static:  # few rows, which all jump
        jumps = jump_warnings(recording, None if still or degrees else simulated, replay)
    warnings = [
        *timing,
        *turn_warnings(recording),
        *jumps,
        *filter(None, converter_warnings(recording, simulated)),
        *noise_warnings(recording),
        *_friction_warnings(recording, adjustable),
        *spike_warnings(recording, simulated),
        *still,
        *actuation_warnings(schedule, adjustable),
        *play_warnings(schedule, adjustable, stated_play(schedule, adjustable)),
        *degrees,
        *failed,
    ]
    lost = any(w.identifier in _DRIVE_LOST and "[drive]" in w.place for w in warnings)
    # else no reading is as the model's
    if simulated is not None and not still and not lost and not degrees:
        readings = reading_warnings(recording, simulated)
        started = all(w.identifier != "start" for w in readings)
        if not started and settle is None and recording.settle > 0.0:
            readings = _short_settle(recording, model, stated) or readings
        warnings += readings
        warnings += slack_warnings(recording, simulated, adjustable)
        warnings += prescribed_warnings(schedule, simulated, adjustable.model)
    return Checked(recording, simulated, _without_consequences(warnings))


def _friction_warnings(recording: Recording, adjustable: Adjustable) -> Iterator[DataWarning]:
    """Warn of a friction or a bend that no sheath has, of the description or of the model."""
    for name, value in adjustable.live.items():
        if said := doubt_of_unit(name.rpartition(".")[2], value):
            value_said, _, way_out = said.partition(": ")
            yield DataWarning("friction", f"{recording.name}, {name}", value_said, way_out)


def _short_settle(
    recording: Recording, model: mujoco.MjModel, stated: Mapping[str, float]
) -> list[DataWarning]:
    """Warnings where the model starts as the rig does once it has had more time to settle."""
    for times in _LONGER:
        longer = times * recording.settle
        simulated, _ = _simulate(recording, model, stated, longer)
        readings = [] if simulated is None else reading_warnings(recording, simulated)
        if simulated is not None and all(w.identifier != "start" for w in readings):
            short = DataWarning(
                "short_settle",
                recording.name,
                f"the model still moves when the settle of {recording.settle:g} s before the first"
                " sample ends, and starts elsewhere than the rig",
                f"write settle = {longer:g}, with which it starts as the rig does",
            )
            return [short, *readings]
    return []


def _without_consequences(warnings: Sequence[DataWarning]) -> tuple[DataWarning, ...]:
    """Warnings without those that follow from another of the same column."""
    follow = {(w.place, other) for w in warnings for other in _FOLLOWS.get(w.identifier, ())}
    return tuple(w for w in warnings if (w.place, w.identifier) not in follow)


def _simulate(
    recording: Recording,
    model: mujoco.MjModel,
    stated: Mapping[str, float],
    settle: float | None,
) -> tuple[Recording | None, list[DataWarning]]:
    """The simulation with the stated parameters, or the warning that it failed."""
    applied = replace(recording, known=stated, uncertain={}, session={})
    try:
        with catch_warnings(record=True):
            return replay_recording(applied, model, described=True, settle=settle), []
    except TendonError as error:
        failed = DataWarning(
            "unstable",
            recording.name,
            str(error),
            "check the unit of the column in [drive], and the model's timestep",
        )
        return None, [failed]


def timing_warnings(recording: Recording) -> list[DataWarning]:
    """Warn of times in a wrong unit, of gaps and missing rows, uneven stamps, and a long settle.

    Times that repeat or decrease are refused when a recording is read.
    """
    return list(filter(None, _timing_warnings(recording)))


def _timing_warnings(recording: Recording) -> Iterator[DataWarning | None]:
    place = f"{recording.name}, column {recording.written(TIME)!r}"
    intervals = np.diff(recording.time)
    usual, span = float(np.median(intervals)), float(np.ptp(recording.time))
    samples = f"{recording.time.size} samples {quantity(usual, 's')} apart, {quantity(span, 's')}"
    if recording.settling_time is not None:
        yield _rest_warning(recording, place, recording.settling_time)
        return
    if usual >= _SLOW and recording.time.size >= _ENOUGH:
        yield DataWarning(
            "times_in_ms",
            place,
            f"{samples} in all",
            "if these are milliseconds, name the column 'time_ms'; if each row was read at rest,"
            " write quasi_static = true under [timing]",
        )
    if usual < _FAST and span < _SHORT:
        way_out = f"if these are in a larger unit, name the column so: {TIMES[0]!r} or {TIMES[1]!r}"
        yield DataWarning("times_too_short", place, f"{samples} in all", way_out)
    yield _gap(recording, place, intervals, usual) or _lost_rows(recording, place, intervals, usual)
    yield _uneven(recording, place, intervals, usual)
    if recording.settle > max(_LONG_SETTLE, span):
        yield DataWarning(
            "long_settle",
            recording.name,
            f"settle = {recording.settle:g} s before the first sample are simulated too, and"
            f" the recording lasts {quantity(span, 's')}",
            "give the time in seconds that the model needs to come to rest",
        )


def _gap(
    recording: Recording, place: str, intervals: FloatArray, usual: float
) -> DataWarning | None:
    gaps = np.flatnonzero(intervals > _GAP * usual)
    if not gaps.size:
        return None
    longest = gaps[np.argmax(intervals[gaps])]
    return DataWarning(
        "gap",
        place,
        f"{gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest"
        f" {intervals[longest]:.3g} s after {recording.time[longest]:.6g} s (row"
        f" {recording.row(longest)}), where samples are {usual:.3g} s apart",
        "split the recording there, unless the drive was straight in between",
        blocks=any(_turns(recording, gap, usual) for gap in gaps.tolist()),
    )


def _turns(recording: Recording, gap: int, usual: float) -> bool:
    """Return whether a drive in a gap leaves the line between its ends."""
    time = recording.time
    before, after = slice(max(0, gap - _ENDS), gap + 1), slice(gap + 1, gap + 2 + _ENDS)
    for column in recording.drive:
        series = recording.columns[column]
        chord = (series[gap + 1] - series[gap]) / (time[gap + 1] - time[gap])
        for end in (before, after):
            if series[end].size > 1:
                slope = np.polyfit(time[end] - time[gap], series[end], 1)[0]
                off = abs(slope - chord) * (time[gap + 1] - time[gap] - usual)
                if off > _UNSEEN * np.ptp(series):
                    return True
    return False


def _lost_rows(
    recording: Recording, place: str, intervals: FloatArray, usual: float
) -> DataWarning | None:
    """Rows that are missing one by one: intervals of two, three … times the usual one."""
    if usual >= _SLOW:  # points that were read one by one
        return None
    times = np.rint(intervals / usual)
    whole = np.abs(intervals / usual - times) < _WHOLE
    lost = np.flatnonzero(whole & (times > 1.0))
    if lost.size < _FEW or not whole.mean() > _MOST or np.mean(times == 1.0) < 0.5:
        return None
    return DataWarning(
        "gap",
        place,
        f"{int((times[lost] - 1.0).sum())} rows are missing in {lost.size} places, the first after"
        f" {recording.time[lost[0]]:.6g} s (row {recording.row(lost[0])}), where samples are"
        f" {usual:.3g} s apart",
        "the logger lost them: the drive is taken to be straight in between",
    )


def _uneven(
    recording: Recording, place: str, intervals: FloatArray, usual: float
) -> DataWarning | None:
    """Stamps that are uneven, unless the columns are smoother over them than over the row."""
    if intervals.size < _ENOUGH or usual >= _SLOW:
        return None
    off = np.abs(intervals / usual - np.maximum(1.0, np.rint(intervals / usual)))
    off[intervals < 0.5 * usual] = 1.0
    uneven = off > _UNEVEN + _tick(recording.time) / usual
    if uneven.mean() < _OFTEN:
        return None
    late, right = False, False
    for column in (*recording.drive, *recording.measured):
        by_time, by_row = _roughness(recording.time, recording.columns[column])
        late |= by_row < _SMOOTHER * by_time
        right |= by_time < _SMOOTHER * by_row
    if right and not late:
        return None
    first = int(np.argmax(uneven)) + 1
    return DataWarning(
        "uneven_times",
        place,
        f"intervals from {intervals.min():.3g} to {intervals.max():.3g} s, {uneven.mean():.0%} of"
        f" them uneven, the first before {row_of(recording, first)}"
        + (", while the columns move evenly from row to row" if late else ""),
        "times at which samples arrived, and not those at which they were taken: log the sensor's"
        f" own time, or write even times, {np.mean(intervals[intervals < _GAP * usual]):.6g} s"
        " apart, if no row is missing",
        blocks=late and _matters(recording, intervals, usual),
    )


def _matters(recording: Recording, intervals: FloatArray, usual: float) -> bool:
    """Return whether uneven lateness moves a reading by more than its noise hides."""
    late = float(np.std(intervals[intervals < 2.0 * usual])) / np.sqrt(2.0)
    return any(
        late / usual * float(np.sqrt(np.mean(np.diff(recording.columns[c]) ** 2)))
        > _VISIBLE * level
        for c, level in noise_levels(recording).items()
    )


def _tick(time: FloatArray) -> float:
    """Last decimal of the times [s]."""
    ticks = 10.0 ** -np.arange(_DECIMALS)
    return float(
        next((t for t in ticks if np.all(np.abs(time - np.rint(time / t) * t) < 1e-9)), 0.0)
    )


def _roughness(time: FloatArray, series: FloatArray) -> tuple[float, float]:
    """Mean distance of samples from the line between their neighbours, over time and over rows.

    Of the smoother half of the samples, so that corners do not count.
    """
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    first, middle, last = series[:-2], series[1:-1], series[2:]
    moving = np.abs(last - first) > _MOVES * np.abs(last - first).max()
    if not moving.any():
        return 0.0, 0.0
    off = np.abs([middle - first - s * (last - first) for s in (share, np.full(share.size, 0.5))])[
        :, moving
    ]
    by_time, by_row = np.mean(np.sort(off, axis=1)[:, : 3 * off.shape[1] // 4], axis=1)
    return float(by_time), float(by_row)


def _rest_warning(recording: Recording, place: str, settling: float) -> DataWarning | None:
    steps = np.diff(recording.time)
    shortest = int(np.argmin(steps))
    between = float(steps[shortest])
    if between >= settling or (np.ptp(steps) == 0.0 and between == 1.0):  # numbers of rows
        return None
    return DataWarning(
        "rests_too_close",
        place,
        f"rows {recording.row(shortest)} and {recording.row(shortest + 1)} are {between:.3g} s"
        f" apart, and each was read {settling:g} s after its move",
        "check the unit of the times, and settling_time under [timing], which is in seconds;"
        " that decides how long a rest is simulated",
    )
