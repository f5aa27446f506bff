"""Recordings of the rig, each with the bend that its file's name states."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tendon_mj import read_recording
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording

DESCRIPTION = Path(__file__).parent / "joint.toml"
COMMAND = "command_rad"
ANGLE, TENSIONS = "joint_rad", ("tension_1_N", "tension_2_N")
COLUMNS = (ANGLE, *TENSIONS)
REELS = ("reel_1", "reel_2")  # that wind the tendons in before the recording
_BEND = "sheath_*.extra_bend"  # in [known]
_NAME = re.compile(r"bend_(\d+)deg")


def read_bend(path: Path) -> Recording:
    """Read one file; the bend is taken from its name.

    Raises:
        RecordingError: another name than bend_NNNdeg, or an invalid recording.
    """
    result = _NAME.fullmatch(path.stem)
    if result is None:
        raise RecordingError(f"{path}: the name is not bend_NNNdeg.csv, NNN the bend in degrees")
    return describe(read_recording(path, DESCRIPTION), math.radians(int(result[1])))


def read_folder(folder: Path) -> list[Recording]:
    """Read every CSV file of a folder, in the order of the bend.

    Raises:
        RecordingError: the folder holds no CSV file, or one that is not of this rig.
    """
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise RecordingError(
            f"{folder} holds no CSV file; experiments/measured_joint/README.md names the data's"
            " source"
        )
    return sorted(map(read_bend, paths), key=bend)


def describe(recording: Recording, angle: float) -> Recording:
    """The recording with its bend [rad] as a known parameter, and reels that stand still."""
    still = {f"{reel}_m": np.zeros_like(recording.time) for reel in REELS}
    return replace(
        recording,
        known={**recording.known, _BEND: angle},
        columns={**recording.columns, **still},
        drive={**recording.drive, **{f"{reel}_m": reel for reel in REELS}},
    )


def bound_zeros(recordings: Sequence[Recording], given: Sequence[Recording]) -> list[Recording]:
    """Recordings with no load cell's zero above its lowest reading in the given ones.

    A tendon cannot push.
    """
    lowest = {c: min(float(r.columns[c].min()) for r in given) for c in TENSIONS}

    def bounded(recording: Recording) -> Recording:
        zeros = {f"{recording.measured[c].sensor}.offset": low for c, low in lowest.items()}
        told = recording.uncertain
        ranges = {n: replace(told[n], high=high) for n, high in zeros.items() if n in told}
        return replace(recording, uncertain={**told, **ranges})

    return [bounded(recording) for recording in recordings]


def bend(recording: Recording) -> float:
    """Bend of the sheath [rad]."""
    return recording.known[_BEND]


def degrees(recording: Recording) -> int:
    """Bend of the sheath in whole degrees, as the file's name has it."""
    return round(math.degrees(bend(recording)))


def noise(recording: Recording, column: str) -> float:
    """Standard deviation that is stated for a measured column [its unit]."""
    stated = recording.measured[column].noise
    if stated is None:
        raise RecordingError(f"{DESCRIPTION}, [measured] {column!r}: no noise is stated")
    return stated
