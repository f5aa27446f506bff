"""The finger along trajectories, named or from a CSV, by ordinary servos; motions of any model."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.errors import (
    InvalidValueError,
    RecordingError,
    TendonError,
    UnknownNameError,
    unknown,
)
from tendon_mj.lab import replay
from tendon_mj.lab.frames import FrameRecorder
from tendon_mj.lab.motion import Drive, default_motion, read_motion
from tendon_mj.lab.recordings import Measured, Recording, read_table
from tendon_mj.lab.units import TIME
from tendon_mj.models import JOINTS, TENDONS, Finger, spool_angles
from tendon_mj.typing import FloatArray

ANGLES = tuple(f"{joint}_rad" for joint in JOINTS)
TENSIONS = tuple(f"{tendon}_N" for tendon in TENDONS)
_TICK = 0.01  # between samples of the named ones [s]
_CURLED = np.radians([75.0, 80.0, 60.0])  # joint angles at the height of a curl
_PRESSED = np.radians([45.0, 34.0, 45.0])  # beyond the pose in which the tip touches the object
_RESTING = 4.0  # tension that both tendons are kept at [N], the default pretension
_TABLE_ERROR = 1e-3  # by which a trajectory may exceed a range, as rounded tables do [rad or N]
_FINGERS = ("finger", "finger_spring")  # models that follow trajectories
OUT_OF_REACH = 0.5  # where the object rests on its slide for the finger to miss it [m]
_UNIT_OF = {"angle": "rad", "force": "N", "tension": "N", "displacement": "m"}
_LEAST_N = 1e-3  # output tension that a ratio divides by at least [N]


@dataclass(frozen=True)
class Trajectory:
    """Joint angles or tensions over time."""

    name: str  # of it
    time: FloatArray  # (n,) [s]
    columns: dict[str, FloatArray]  # either `ANGLES` [rad] or some of `TENSIONS` [N] → (n,)
    aside: bool = False  # whether the object is out of the way

    @property
    def by_tension(self) -> bool:
        """Whether its columns are tensions rather than angles."""
        return not set(ANGLES) <= self.columns.keys()


def _time(duration: float) -> FloatArray:
    return np.linspace(0.0, duration, round(duration / _TICK) + 1)


def _by_angles(name: str, duration: float, period: float, pose: FloatArray) -> Trajectory:
    """Straight → pose → straight without a jump in speed, once in a period [s]."""
    time = _time(duration)
    angles = np.outer(0.5 - 0.5 * np.cos(2.0 * np.pi * (time / period)), pose)
    return Trajectory(name, time, dict(zip(ANGLES, angles.T, strict=True)), aside=name == "curl")


def _by_tensions(name: str, knots: list[tuple[float, float]]) -> Trajectory:
    """Flexor through (time, tension) knots, linear between; extensor kept at rest."""
    at, tension = np.array(knots).T
    time = _time(at[-1])
    flexor, extensor = np.interp(time, at, tension), np.full(len(time), _RESTING)
    return Trajectory(name, time, dict(zip(TENSIONS, (flexor, extensor), strict=True)))


def curl() -> Trajectory:
    """All joints to a fist and back, twice in 8 s; the object is out of the way."""
    return _by_angles("curl", 8.0, 4.0, _CURLED)


def tap() -> Trajectory:
    """Three taps on the object, one a second."""
    return _by_angles("tap", 3.0, 1.0, _PRESSED)


def press() -> Trajectory:
    """Flexor tension up to 24 N and down again, twice: onto the object and off it."""
    knots = [(0.0, _RESTING), (2.0, 24.0), (4.0, _RESTING), (6.0, 24.0), (8.0, _RESTING)]
    return _by_tensions("press", knots)


def hold() -> Trajectory:
    """Flexor tension held at 14 N, once come from below and once from above."""
    knots = [(0.0, _RESTING), (1.0, 14.0), (3.0, 14.0), (4.0, 24.0), (5.0, 24.0), (6.0, 14.0)]
    return _by_tensions("hold", [*knots, (8.0, 14.0)])


NAMED: dict[str, Callable[[], Trajectory]] = {f.__name__: f for f in (curl, tap, press, hold)}


def find_trajectory(name: str) -> Trajectory:
    """A named trajectory, or one from a CSV with `time_s` and either `ANGLES` or `TENSIONS`."""
    path = Path(name)
    if name in NAMED:
        return NAMED[name]()
    if not path.is_file():
        known = [*NAMED, *map(str, path.parent.glob("*.csv"))]
        raise UnknownNameError("trajectory or CSV file", name, known)
    table = read_table(path)
    time = table.pop(TIME)
    if set(table) not in (set(ANGLES), set(TENSIONS), {TENSIONS[0]}):
        raise RecordingError(
            f"{path}: a trajectory has, beside {TIME}, either {', '.join(ANGLES)} or "
            f"{', '.join(TENSIONS)} (the spring variant: {TENSIONS[0]}), not "
            f"{', '.join(sorted(table)) or 'nothing'}"
        )
    return Trajectory(path.stem, time - time[0], table)


def check_reach(trajectory: Trajectory, finger: Finger) -> None:
    """Refuse joint angles beyond the joints' ranges, and tensions that no motor brings up."""
    kind = "tendon" if trajectory.by_tension else "joint"
    for column, (low, high) in _reachable(trajectory, finger).items():
        values, (name, _, unit) = trajectory.columns[column], column.rpartition("_")
        beyond = np.flatnonzero((values < low - _TABLE_ERROR) | (values > high + _TABLE_ERROR))
        if beyond.size:
            k = beyond[0]
            degrees = f" ({np.degrees(values[k]):.4g} deg)" if unit == "rad" else ""
            raise InvalidValueError(
                f"trajectory {trajectory.name!r}: {kind} {name!r} is commanded to {values[k]:.4g} "
                f"{unit}{degrees} at {trajectory.time[k]:g} s, beyond its range of {low:.4g} to "
                f"{high:.4g} {unit}"
            )


def clamped(trajectory: Trajectory, finger: Finger) -> Trajectory:
    """A trajectory with every value clipped to the range that `check_reach` accepts."""
    columns = {
        column: np.clip(trajectory.columns[column], *limits)
        for column, limits in _reachable(trajectory, finger).items()
    }
    return dataclasses.replace(trajectory, columns=columns)


def lasting(trajectory: Trajectory, duration: float) -> Trajectory:
    """A trajectory cut after a duration [s], or held at its last values until then."""
    if not np.isfinite(duration) or duration < 2.0 * _TICK:
        raise InvalidValueError(f"duration = {duration} [s] must be finite and ≥ {2 * _TICK}")
    time = np.append(trajectory.time[trajectory.time < duration], duration)
    columns = {c: np.interp(time, trajectory.time, v) for c, v in trajectory.columns.items()}
    return dataclasses.replace(trajectory, time=time, columns=columns)


def _reachable(trajectory: Trajectory, finger: Finger) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of every column."""
    if not trajectory.by_tension:
        ranges = [(joint.low, joint.high) for joint in finger.joints.values()]
        return dict(zip(ANGLES, ranges, strict=True))
    most = finger.pretension + finger.motor_torque * finger.gear / finger.spool_radius
    return dict.fromkeys(trajectory.columns, (0.0, most))


class Motion(NamedTuple):
    """A motion of a model."""

    name: str  # of the motion
    drive: Drive  # time [s] → (nu,) controls
    duration: float  # of it [s]; infinite for a default motion, which has no end
    parameters: Mapping[str, float] = {}  # of the model that it needs, by name
    hidden: tuple[str, ...] = ()  # bodies that are out of the way, so far that they are not shown

    def prepared(self, model: mujoco.MjModel) -> mujoco.MjModel:
        """A copy of a model with these parameters, in which the hidden bodies are invisible."""
        adjustable = replay.Adjustable(copy.copy(model))
        adjustable.set(self.parameters)
        for body in self.hidden:
            adjustable.model.geom_rgba[model.geom_bodyid == model.body(body).id, 3] = 0.0
        return adjustable.model


def motion_names(name: str) -> list[str]:
    """Motions with a name that a model has."""
    return list(NAMED) if name in _FINGERS else []


def check_finger(name: str) -> None:
    """Refuse a model that does not follow trajectories, by its name.

    Raises:
        TendonError: any but `finger` and `finger_spring`.
    """
    if name not in _FINGERS:
        raise TendonError(
            f"{unknown('model', name, _FINGERS)}; `tendon-mj view` and `tendon-mj render` show any"
            " model in motion"
        )


def find_motion(
    name: str,
    model: mujoco.MjModel,
    motion: str | None = None,
    duration: float | None = None,
    tendons: Collection[str] | None = None,
) -> Motion:
    """The motion of a compiled model that a command names, or the default one.

    Of a finger: curl (the default), tap, press, hold or a CSV of joint angles or tensions, cut or
    held after ``duration`` [s]. Of any other model: a CSV with ``time_s`` and a column for every
    actuator that moves (see `read_motion`), or `default_motion`, of some ``tendons`` alone if any
    are given.
    """
    if name not in _FINGERS:
        if motion is None:
            return Motion("default motion", default_motion(name, model, tendons), math.inf)
        return Motion(Path(motion).stem, *read_motion(Path(motion), model))
    trajectory = find_trajectory(motion or "curl")
    if duration is not None:
        trajectory = lasting(trajectory, duration)
    return _to_motion(trajectory, model, _drive_recording(trajectory, model, Finger(), name=name))


def _to_motion(trajectory: Trajectory, model: mujoco.MjModel, commands: Recording) -> Motion:
    rows = [(model.actuator(a).id, commands.columns[c]) for c, a in commands.driven]

    def drive(now: float) -> FloatArray:
        control = np.zeros(model.nu)
        for actuator, values in rows:
            control[actuator] = np.interp(now, commands.time, values)
        return control

    hidden = ("object",) if trajectory.aside else ()
    return Motion(trajectory.name, drive, float(trajectory.time[-1]), commands.known, hidden)


def _drive_recording(
    trajectory: Trajectory,
    model: mujoco.MjModel,
    finger: Finger,
    *,
    name: str = "finger",
    friction: float | None = None,
) -> Recording:
    """Commands of the motors for a trajectory, as a recording still without readings.

    Joint angles become spool angles by geometry alone, as for an ideal tendon; tensions become
    torques, T r, with the position servos off. Friction is not compensated.
    """
    check_reach(trajectory, finger)
    tendons = [t for t in TENDONS if t in {model.tendon(k).name for k in range(model.ntendon)}]
    columns, actuators, values = zip(*_commands(trajectory, finger, tendons), strict=True)
    known = {"object.springref": OUT_OF_REACH} if trajectory.aside else {}
    if trajectory.by_tension:
        servos = (actuator.replace("_torque", "_angle") for actuator in actuators)
        known |= {f"{servo}.{gain}": 0.0 for servo in servos for gain in ("kp", "kv")}
    if friction is not None:
        known |= {f"{tendon}_sheath.friction": friction for tendon in tendons}
    # a column is one number
    names = [model.sensor(int(k)).name for k in np.flatnonzero(model.sensor_dim == 1)]
    measured = {f"{name}_{_UNIT_OF[name.rpartition('_')[2]]}": Measured(name) for name in names}
    asked = {f"asked_{column}": values for column, values in trajectory.columns.items()}
    return Recording(
        name=trajectory.name,
        model=name,
        source="simulated by tendon-mj simulate",
        time=trajectory.time,
        columns={
            **dict(zip(columns, values, strict=True)),
            **dict.fromkeys(measured, np.zeros_like(trajectory.time)),
            **asked,
        },
        drive=dict(zip(columns, actuators, strict=True)),
        measured=measured,
        known=known,
    )


def _commands(
    trajectory: Trajectory, finger: Finger, tendons: list[str]
) -> Iterator[tuple[str, str, FloatArray]]:
    """Columns, the actuators that they drive, and their values."""
    if not trajectory.by_tension:
        angles = np.stack([trajectory.columns[column] for column in ANGLES], axis=-1)
        for tendon, turned in spool_angles(finger, angles).items():
            if tendon in tendons:
                yield f"{tendon}_command_rad", f"{tendon}_angle", turned
        return
    for column, tension in trajectory.columns.items():
        tendon = column.removesuffix("_N")
        if tendon not in tendons:
            raise UnknownNameError("tendon", tendon, tendons, f"trajectory {trajectory.name!r}")
        torque = (tension - finger.pretension) * finger.spool_radius / finger.gear
        yield f"{tendon}_command_Nm", f"{tendon}_torque", torque


def prepare_finger(
    trajectory: Trajectory, model: mujoco.MjModel, finger: Finger
) -> tuple[replay.Adjustable, FloatArray]:
    """A copy of a model set for a trajectory, with its data, and its (steps, nu) controls.

    For callers that step the model themselves; `simulate_finger` steps it too.
    """
    commands = _drive_recording(trajectory, model, finger)
    motion = _to_motion(trajectory, model, commands)
    adjustable = replay.Adjustable(copy.copy(model))
    adjustable.set(motion.parameters)
    time = np.arange(0.0, motion.duration, model.opt.timestep)
    return adjustable, np.array([motion.drive(now) for now in time])


def simulate_finger(
    trajectory: Trajectory,
    model: mujoco.MjModel,
    finger: Finger | None = None,
    *,
    name: str = "finger",
    friction: float | None = None,
    recorder: FrameRecorder | None = None,
) -> Recording:
    """Follow a trajectory, and return every sensor in a recording that `replay` can run again.

    ``model`` is `finger` or `finger_spring`, not changed; ``friction`` is μ of every sheath in
    place of the model's; ``recorder`` keeps frames for a clip. Columns are `asked_…` of the
    trajectory, `…_command_…` driven, and one for every sensor.
    """
    drive = _drive_recording(trajectory, model, finger or Finger(), name=name, friction=friction)
    answer = replay.replay_recording(drive, model, recorder=recorder)
    asked = {c: v for c, v in drive.columns.items() if c.startswith("asked_")}
    return dataclasses.replace(
        answer, name=drive.name, source=drive.source, columns={**answer.columns, **asked}
    )


def summarise(answer: Recording) -> dict[str, float]:
    """Largest tip force, and extremes of the flexor's T_in/T_out, of a simulated motion."""
    columns = answer.columns
    output = np.maximum(columns["flexor_output_tension_N"], _LEAST_N)
    ratio = columns["flexor_input_tension_N"] / output
    return {
        "tip_force_max_N": float(columns["tip_force_N"].max()),
        "flexor_input_over_output_max": float(ratio.max()),
        "flexor_input_over_output_min": float(ratio.min()),
    }


def tracking_error(answer: Recording) -> dict[str, replay.Misfit]:
    """Misfit achieved − commanded of every joint angle or tension of a trajectory.

    A tension is commanded at the motor, so it is compared at the tendon's input, and at its output
    as well.
    """
    goals = {f"{joint}_angle_rad": f"asked_{joint}_rad" for joint in JOINTS}
    goals |= {
        f"{tendon}_{end}_tension_N": f"asked_{tendon}_N"
        for tendon in TENDONS
        for end in ("input", "output")
    }
    goals = {column: goal for column, goal in goals.items() if goal in answer.columns}
    wanted = dataclasses.replace(
        answer,
        columns={**answer.columns, **{c: answer.columns[goal] for c, goal in goals.items()}},
        measured={column: answer.measured[column] for column in goals},
    )
    return replay.replay_error(wanted, answer)
