"""Recordings of the tool: columns, wrist pose and load, and how a folder of them is read."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

from experiments.cable_tool.strokes import Strokes, find_strokes
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import read_table
from tendon_mj.typing import FloatArray

COLUMNS = ("time_s", "input_rad", "input_torque_Nm", "output_rad", "output_torque_Nm")
_NAMES = (
    re.compile(r"tool_L4_(?P<rate>[^_]+)_load(?P<load>\d+)"),
    re.compile(r"pitch(?P<pitch>[1-5])_yaw(?P<yaw>\d+)_load(?P<load>\d+)"),
    re.compile(r"roll(?P<roll>[1-5])_yaw(?P<yaw>\d+)_load(?P<load>\d+)"),
)
_MIDDLE = 3  # N of the straight wrist
_PITCH, _ROLL = math.radians(30.0), math.radians(45.0)  # of one step of N: −60…60°, −90…90°


@dataclass(frozen=True)
class ToolRecording:
    """One recording.

    Attributes:
        name: of the file, without its ending.
        pose: wrist pose as the file names it, ``straight`` where it names none.
        pitch, roll: of the wrist [rad].
        load_share: brake's share of full load [-].
        rate: of the sine as the file names it, empty where it names none.
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
        RecordingError: a name or a header that is not of this rig, or what no table may hold.
    """
    found = next((m for m in (n.fullmatch(path.stem) for n in _NAMES) if m), None)
    if found is None:
        raise RecordingError(
            f"{path}: the name is none of tool_L4_RATE_loadPERCENT, pitchN_yawN_loadPERCENT, "
            "rollN_yawN_loadPERCENT"
        )
    given = found.groupdict()
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
