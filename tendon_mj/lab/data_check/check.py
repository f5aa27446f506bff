"""Check of a recording: its times, and its columns against the model at the stated numbers."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from warnings import catch_warnings

import mujoco

from tendon_mj.errors import TendonError
from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.actuators import (
    actuation_warnings,
    play_warnings,
    prescribed_warnings,
    stated_play,
)
from tendon_mj.lab.data_check.column import columns_of
from tendon_mj.lab.data_check.columns import (
    below_zero_warnings,
    coarse,
    drive_warnings,
    held,
    overstated_noise,
    range_end,
    reading_warnings,
    scatter_at_rest,
    spike_warnings,
    turn,
)
from tendon_mj.lab.data_check.faults import DRIVE_LOST, FOLLOW, WRONG_TIMES, DataWarning
from tendon_mj.lab.data_check.jumps import jump_warnings
from tendon_mj.lab.data_check.mistaken_columns import degree_warnings, exchange_warnings
from tendon_mj.lab.data_check.times import timing_warnings
from tendon_mj.lab.parameter_names import expand
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import (
    GEARED,
    Adjustable,
    Schedule,
    load_recorded,
    replay_recording,
    stated_values,
)
from tendon_mj.sheath import doubt_of_unit


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
    if any(warning.identifier in WRONG_TIMES for warning in timing):
        return Checked(recording, None, (*timing, *still))
    schedule = Schedule(recording, adjustable.model, settle)  # refuses a recording of another model
    stated = stated_values(recording, model, adjustable.parameters(), described, given=given)
    adjustable.set(stated)

    def replay(other: Recording) -> Recording | None:
        return _simulate(other, model, stated, settle)[0]

    simulated, failed = _simulate(recording, model, stated, settle)
    degrees = degree_warnings(recording, simulated, replay)
    columns = columns_of(recording, simulated)
    measured = [c for c in columns if not c.driven]
    warnings = [*timing, *filter(None, map(turn, columns))]
    if not recording.quasi_static and simulated and not still and not degrees:
        warnings += jump_warnings(columns, replay)
    warnings += filter(None, map(range_end, measured))
    if not recording.quasi_static:  # of few rows, which all jump, and whose values repeat
        noises = coarse, overstated_noise, scatter_at_rest
        warnings += filter(None, [of(column) for column in measured for of in noises])
        warnings += [*filter(None, map(held, columns)), *spike_warnings(columns)]
    warnings += _friction_warnings(recording, adjustable)
    warnings += _gear_warnings(recording, adjustable)
    warnings += still
    warnings += actuation_warnings(schedule, adjustable)
    warnings += play_warnings(schedule, adjustable, stated_play(schedule, adjustable))
    warnings += [*degrees, *failed]
    lost = any(w.identifier in DRIVE_LOST and "[drive]" in w.place for w in warnings)
    # else no reading is as the model's
    if simulated is not None and not still and not lost and not degrees:
        exchanged = list(exchange_warnings(recording, simulated, replay))
        warnings += exchanged
        readings = [] if exchanged else reading_warnings(recording, simulated)
        started = all(w.identifier != "start" for w in readings)
        if not started and settle is None and recording.settle > 0.0:
            readings = _short_settle(recording, model, stated) or readings
        warnings += readings
        warnings += below_zero_warnings(recording, simulated, adjustable)
        warnings += prescribed_warnings(schedule, simulated, adjustable.model)
    return Checked(recording, simulated, _without_consequences(warnings))


def _friction_warnings(recording: Recording, adjustable: Adjustable) -> Iterator[DataWarning]:
    """Warn of a friction or a bend that no sheath has, of the description or of the model."""
    for name, value in adjustable.live.items():
        if said := doubt_of_unit(name.rpartition(".")[2], value):
            value_said, _, way_out = said.partition(": ")
            place = f"{recording.name}, {name}"
            yield DataWarning("friction", place, value_said, way_out)


def _gear_warnings(recording: Recording, adjustable: Adjustable) -> Iterator[DataWarning]:
    """Warn of a gear whose efficiency is stated, and not what it shows at rest."""
    stated = {**recording.known, **recording.uncertain, **recording.session}
    names = expand(stated, adjustable.names())
    for sensor in dict.fromkeys(name.rpartition(".")[0] for name in names):
        rests = [f"{sensor}.{rest}" for rest in GEARED[1:]]
        if f"{sensor}.{GEARED[0]}" in names and not names.keys() & set(rests):
            yield DataWarning(
                "gear",
                f"{recording.name}, {sensor}.{GEARED[0]}",
                "is stated, and not how far the gear's friction bears the load at rest, which is"
                " taken to be as in paying out",
                "let both be fitted, in [uncertain]: "
                + ", ".join(f'"{rest}" = {{ value = 0, low = -1, high = 1 }}' for rest in rests),
            )


def _short_settle(
    recording: Recording, model: mujoco.MjModel, stated: Mapping[str, float]
) -> list[DataWarning]:
    """Warnings where the model starts as the rig does once it has had more time to settle."""
    longer = 2.0 * recording.settle
    while longer <= limits.LONG_SETTLE:
        simulated, _ = _simulate(recording, model, stated, longer)
        readings = [] if simulated is None else reading_warnings(recording, simulated)
        if simulated is not None and all(w.identifier != "start" for w in readings):
            settle = recording.settle
            short = DataWarning(
                "short_settle",
                recording.name,
                f"the model still moves when the settle of {settle:g} s before the first sample"
                " ends, and starts elsewhere than the rig",
                f"write settle = {longer:g}, with which it starts as the rig does",
            )
            return [short, *readings]
        longer *= 2.0
    return []


def _without_consequences(warnings: Sequence[DataWarning]) -> tuple[DataWarning, ...]:
    """Warnings without those that follow from another of the same column."""
    follow = {(w.place, other) for w in warnings for other in FOLLOW.get(w.identifier, ())}
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
        way_out = "check the unit of the column in [drive], and the model's timestep"
        return None, [DataWarning("unstable", recording.name, str(error), way_out)]
