"""Check of a recording against its model: simulated at the stated numbers, nothing fitted."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from warnings import catch_warnings

import mujoco

from tendon_mj.errors import TendonError
from tendon_mj.lab.data_check.actuators import (
    actuation_warnings,
    play_warnings,
    prescribed_warnings,
    stated_play,
)
from tendon_mj.lab.data_check.jumps import jump_warnings
from tendon_mj.lab.data_check.readings import degree_warnings, drive_warnings, reading_warnings
from tendon_mj.lab.data_check.samples import (
    converter_warnings,
    slack_warnings,
    spike_warnings,
    turn_warnings,
)
from tendon_mj.lab.data_check.timing import timing_warnings
from tendon_mj.lab.data_check.warning import DataWarning
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Adjustable, Schedule, replay_recording, stated_values
from tendon_mj.models import load_model

_WRONG_TIMES = ("times_in_ms", "times_too_short")  # with which no simulation is of use
_DRIVE_LOST = ("turn", "wraps", "zero_step")
_JUMPED = {
    "spike",
    "frozen",
    "start",
    "below_zero",
    "unit",
    "sign",
    "slack",
    "saturated",
    "weak_motor",
}
# warning → others of the same column that follow from it
_FOLLOWS = {
    "range_end": {"frozen", "coarse"},
    "repeated": {"frozen"},
    "coarse": {"frozen"},
    "below_zero": {"start"},
    "spike": {"below_zero", "range_end", "repeated"},
    "sign": {"below_zero"},
    "nothing_moves": {"below_zero"},
    "unit": {"below_zero", "coarse"},
    "turn": _JUMPED,
    "wraps": _JUMPED,
    "zero_step": _JUMPED,
    "scale_change": _JUMPED,
}


@dataclass(frozen=True)
class Checked:
    """A recording, its simulation, and warnings.

    Attributes:
        recording: as given.
        simulated: at the numbers that the description states; None if the times are wrong, or the
            simulation failed.
        warnings: in the order in which to look at them.
    """

    recording: Recording
    simulated: Recording | None
    warnings: tuple[DataWarning, ...]


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
    if model is None:
        model = load_model(recording.model, beside=recording.beside)
    adjustable = Adjustable(copy.copy(model))
    timing, still = timing_warnings(recording), drive_warnings(recording)
    if any(warning.identifier in _WRONG_TIMES for warning in timing):
        return Checked(recording, None, (*timing, *still))
    schedule = Schedule(recording, adjustable.model, settle)  # refuses a recording of another model
    adjustable.set(stated_values(recording, model, adjustable.names(), described))

    def replay(other: Recording) -> Recording | None:
        return _simulate(other, model, described, settle)[0]

    simulated, failed = _simulate(recording, model, described, settle)
    degrees = degree_warnings(recording, simulated, replay)
    jumps = list[DataWarning]()
    if not recording.quasi_static:  # few rows, which all jump
        jumps = jump_warnings(recording, None if still or degrees else simulated, replay)
    warnings = [
        *timing,
        *turn_warnings(recording),
        *jumps,
        *filter(None, converter_warnings(recording, simulated)),
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
        warnings += reading_warnings(recording, simulated)
        warnings += slack_warnings(recording, simulated, adjustable)
        warnings += prescribed_warnings(schedule, simulated, adjustable.model)
    return Checked(recording, simulated, _without_consequences(warnings))


def _without_consequences(warnings: Sequence[DataWarning]) -> tuple[DataWarning, ...]:
    """Warnings without those that follow from another of the same column."""
    follow = {(w.place, other) for w in warnings for other in _FOLLOWS.get(w.identifier, ())}
    return tuple(w for w in warnings if (w.place, w.identifier) not in follow)


def _simulate(
    recording: Recording, model: mujoco.MjModel, described: bool | None, settle: float | None
) -> tuple[Recording | None, list[DataWarning]]:
    try:
        with catch_warnings(record=True):
            return replay_recording(recording, model, described=described, settle=settle), []
    except TendonError as error:
        failed = DataWarning(
            "unstable",
            recording.name,
            str(error),
            "check the unit of the column in [drive], and the model's timestep",
        )
        return None, [failed]
