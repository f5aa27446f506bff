"""Recordings of the tool: columns, wrist pose and load, and strokes."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import read_table
from tendon_mj.typing import FloatArray

MID_STROKE = 0.26  # within this of the middle of the range the output slides both ways [rad]
ENCODER_NOISE = 1e-3  # a reversal is seen when the input has come back by twice this [rad]
COLUMNS = ("time_s", "input_rad", "input_torque_Nm", "output_rad", "output_torque_Nm")
_NAMES = (
    re.compile(r"tool_L4_(?P<rate>[^_]+)_load(?P<load>\d+)"),
    re.compile(r"pitch(?P<pitch>[1-5])_yaw(?P<yaw>\d+)_load(?P<load>\d+)"),
    re.compile(r"roll(?P<roll>[1-5])_yaw(?P<yaw>\d+)_load(?P<load>\d+)"),
)
_MIDDLE = 3  # N of the straight wrist
_PITCH, _ROLL = math.radians(30.0), math.radians(45.0)  # of one step of N: −60…60°, −90…90°


@dataclass(frozen=True)
class Strokes:
    """Strokes of one recording; everything is of the input side and independent of rate.

    Attributes:
        direction: −1 closing (input angle falls), +1 opening; 0 before anything has moved.
        travel: of the input since its last reversal [rad].
        excursion: input angle from the middle of its range [rad].
    """

    direction: FloatArray
    travel: FloatArray
    excursion: FloatArray

    @cached_property
    def middle(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Samples in mid-stroke, closing and opening."""
        near = np.abs(self.excursion) < MID_STROKE
        closing, opening = (np.flatnonzero(near & (self.direction == s)) for s in (-1.0, 1.0))
        return closing, opening


def find_strokes(angle: FloatArray) -> Strokes:
    """Strokes of a series of input angles [rad].

    The motion before the recording is taken to be that of the recording itself, which covers
    whole periods, so that the first stroke has a reversal before it. The middle of the range is
    that of the percentiles 0.5 and 99.5, as one recording holds a disturbance that leaves it.
    """
    direction, travel = _follow(np.concatenate([angle, angle]), ENCODER_NOISE)
    low, high = np.percentile(angle, [0.5, 99.5])
    n = len(angle)
    return Strokes(direction[n:], travel[n:], angle - 0.5 * (low + high))


@njit(cache=True)
def _follow(angle: FloatArray, noise: float) -> tuple[FloatArray, FloatArray]:
    """Direction and travel of the play operator of half-width ``noise`` on ``angle``."""
    direction, travel = np.zeros(angle.size), np.zeros(angle.size)
    now, start, sense = angle[0], angle[0], 0.0
    for i in range(angle.size):
        moved = min(max(now, angle[i] - noise), angle[i] + noise)
        if (moved - now) * sense < 0.0 or (sense == 0.0 and moved != now):
            sense, start = np.sign(moved - now), now
        now = moved
        direction[i], travel[i] = sense, abs(now - start)
    return direction, travel


@dataclass(frozen=True)
class ToolRecording:
    """One recording.

    Attributes:
        name: of the file, without its ending.
        pose: wrist pose as the file names it, ``straight`` where it names none.
        pitch, roll: of the wrist [rad].
        load_share: brake's share of full load [-].
        rate: of the sine as the file names it, empty if it names none.
        time: [s].
        input_angle, input_torque: of the driving side [rad], [N m].
        output_angle: of the driven side; runs against the input [rad].
        load: torque with which the output is braked, −1 × its torque cell's reading [N m].
    """

    name: str
    pose: str
    pitch: float
    roll: float
    load_share: float
    rate: str
    time: FloatArray
    input_angle: FloatArray
    input_torque: FloatArray
    output_angle: FloatArray
    load: FloatArray
    strokes: Strokes = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "strokes", find_strokes(self.input_angle))

    @property
    def group(self) -> str:
        """``straight``, ``pitch`` or ``roll``."""
        return self.pose.rstrip("12345")


def read_recording(path: Path) -> ToolRecording:
    """Read one file; pose, load and rate are taken from its name.

    Raises:
        RecordingError: a name or a header that is not of this rig, or an invalid table.
    """
    result = next((m for m in (n.fullmatch(path.stem) for n in _NAMES) if m), None)
    if result is None:
        raise RecordingError(
            f"{path}: the name is none of tool_L4_RATE_loadPERCENT, pitchN_yawN_loadPERCENT, "
            "rollN_yawN_loadPERCENT"
        )
    given = result.groupdict()
    table = read_table(path)
    if tuple(table) != COLUMNS:
        raise RecordingError(f"{path}, row 1: columns are {tuple(table)}, not {COLUMNS}")
    time, input_angle, input_torque, output_angle, output_torque = table.values()
    pitch, roll = int(given.get("pitch") or _MIDDLE), int(given.get("roll") or _MIDDLE)
    return ToolRecording(
        name=path.stem,
        pose=path.stem.split("_")[0].replace("tool", "straight"),
        pitch=(pitch - _MIDDLE) * _PITCH,
        roll=(roll - _MIDDLE) * _ROLL,
        load_share=int(given["load"]) / 100.0,
        rate=given.get("rate") or "",
        time=time,
        input_angle=input_angle,
        input_torque=input_torque,
        output_angle=output_angle,
        load=-output_torque,
    )


def read_folder(folder: Path) -> list[ToolRecording]:
    """Read every CSV file of a folder, in the order of their names.

    Raises:
        RecordingError: the folder holds no CSV file.
    """
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise RecordingError(
            f"{folder} holds no CSV file; experiments/cable_tool/README.md names the data's source"
        )
    return [read_recording(path) for path in paths]
