"""Trajectories of the finger: joint angles or tendon tensions over time, named or from a CSV."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.recordings import TIME, read_table
from tendon_mj.models import JOINTS, TENDONS, Finger
from tendon_mj.typing import FloatArray

ANGLES = tuple(f"{joint}_rad" for joint in JOINTS)
TENSIONS = tuple(f"{tendon}_N" for tendon in TENDONS)
_INTERVAL = 0.01  # between samples of the named ones [s]
_CURLED = np.radians([75.0, 80.0, 60.0])  # joint angles at the height of a curl
_TOUCHING = np.radians([45.0, 34.0, 45.0])  # beyond the pose in which the tip touches the object
_REST = 4.0  # tension that both tendons are kept at [N], the default pretension
_SLACK = 1e-3  # by which a trajectory may exceed a range, as rounded tables do [rad or N]


@dataclass(frozen=True)
class Trajectory:
    """Joint angles or tensions over time.

    Attributes:
        name: of it.
        time: (n,) [s].
        columns: either `ANGLES` [rad] or some of `TENSIONS` [N] → (n,).
        aside: whether the object is out of the way.
    """

    name: str
    time: FloatArray
    columns: dict[str, FloatArray]
    aside: bool = False

    @property
    def by_tension(self) -> bool:
        """Whether its columns are tensions rather than angles."""
        return not set(ANGLES) <= self.columns.keys()


def _pulse(phase: FloatArray) -> FloatArray:
    """0 → 1 → 0 without a jump in speed, once per unit of phase."""
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * phase)


def _time(duration: float) -> FloatArray:
    return np.linspace(0.0, duration, round(duration / _INTERVAL) + 1)


def _by_angles(
    name: str, duration: float, share: Callable[[FloatArray], FloatArray], pose: FloatArray
) -> Trajectory:
    time = _time(duration)
    angles = np.outer(share(time), pose)
    return Trajectory(name, time, dict(zip(ANGLES, angles.T, strict=True)), aside=name == "curl")


def _by_tensions(name: str, knots: list[tuple[float, float]]) -> Trajectory:
    """Flexor through (time, tension) knots, linear between; extensor kept at rest."""
    at, tension = np.array(knots).T
    time = _time(at[-1])
    flexor, extensor = np.interp(time, at, tension), np.full(len(time), _REST)
    return Trajectory(name, time, dict(zip(TENSIONS, (flexor, extensor), strict=True)))


def curl() -> Trajectory:
    """All joints to a fist and back, twice in 8 s; the object is out of the way."""
    return _by_angles("curl", 8.0, lambda t: _pulse(t / 4.0), _CURLED)


def tap() -> Trajectory:
    """Three taps on the object, one a second."""
    return _by_angles("tap", 3.0, _pulse, _TOUCHING)


def press() -> Trajectory:
    """Flexor tension up to 24 N and down again, twice: onto the object and off it."""
    knots = [(0.0, _REST), (2.0, 24.0), (4.0, _REST), (6.0, 24.0), (8.0, _REST)]
    return _by_tensions("press", knots)


def hold() -> Trajectory:
    """Flexor tension held at 14 N, once come from below and once from above."""
    knots = [(0.0, _REST), (1.0, 14.0), (3.0, 14.0), (4.0, 24.0), (5.0, 24.0), (6.0, 14.0)]
    return _by_tensions("hold", [*knots, (8.0, 14.0)])


NAMED: dict[str, Callable[[], Trajectory]] = {f.__name__: f for f in (curl, tap, press, hold)}


def read_trajectory(path: Path) -> Trajectory:
    """A trajectory from a CSV with `time_s` and either `ANGLES` or `TENSIONS` as columns."""
    table = read_table(path)
    time = table.pop(TIME)
    given = set(table)
    if given not in (set(ANGLES), set(TENSIONS), {TENSIONS[0]}):
        raise RecordingError(
            f"{path}: a trajectory has, beside {TIME}, either {', '.join(ANGLES)} or "
            f"{', '.join(TENSIONS)} (the spring variant: {TENSIONS[0]}), not "
            f"{', '.join(sorted(given)) or 'nothing'}"
        )
    return Trajectory(path.stem, time - time[0], table)


def find_trajectory(name: str) -> Trajectory:
    """A named trajectory, or one from a CSV file."""
    if name in NAMED:
        return NAMED[name]()
    if Path(name).is_file():
        return read_trajectory(Path(name))
    raise UnknownNameError("trajectory or CSV file", name, NAMED)


def check_reach(trajectory: Trajectory, finger: Finger) -> None:
    """Refuse joint angles beyond the joints' ranges, and tensions that no motor brings up."""
    kind = "tendon" if trajectory.by_tension else "joint"
    for column, (low, high) in _reach(trajectory, finger).items():
        values, (name, _, unit) = trajectory.columns[column], column.rpartition("_")
        beyond = np.flatnonzero((values < low - _SLACK) | (values > high + _SLACK))
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
        for column, limits in _reach(trajectory, finger).items()
    }
    return dataclasses.replace(trajectory, columns=columns)


def lasting(trajectory: Trajectory, duration: float) -> Trajectory:
    """A trajectory cut after a duration [s], or held at its last values until then."""
    if not np.isfinite(duration) or duration < 2.0 * _INTERVAL:
        raise InvalidValueError(f"duration = {duration} [s] must be finite and ≥ {2 * _INTERVAL}")
    time = np.append(trajectory.time[trajectory.time < duration], duration)
    columns = {c: np.interp(time, trajectory.time, v) for c, v in trajectory.columns.items()}
    return dataclasses.replace(trajectory, time=time, columns=columns)


def _reach(trajectory: Trajectory, finger: Finger) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of every column."""
    if not trajectory.by_tension:
        ranges = [(joint.low, joint.high) for joint in finger.joints.values()]
        return dict(zip(ANGLES, ranges, strict=True))
    most = finger.pretension + finger.motor_torque * finger.gear / finger.spool_radius
    return dict.fromkeys(trajectory.columns, (0.0, most))
