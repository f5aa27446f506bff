"""Bounds of a rig: what they refuse, and their file."""

from __future__ import annotations

import os
import sys

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, RecordingError, TendonError
from tendon_mj.lab.experiment_design import DriveBounds, ExperimentBounds, check_bounds, read_bounds
from tendon_mj.lab.recordings import Measured, Recording
from tests.lab.experiment_design.rig import DRIVE, TENSION, bounds, record

FILE = """
duration = 8.0
[drive]
reel_m = { low = -1e-3, high = 1.3e-3, rate = 0.012, dwell = 2 }
[states]
"sheath.pretension" = { low = 10, high = 40 }
[limits]
tension_N = { low = 1, high = 100 }
[measure]
angle_rad = { sensor = "angle", noise = 0.01 }
"""


def test_a_file_holds_what_python_says(tmp_path) -> None:
    path = tmp_path / "bounds.toml"
    path.write_text(FILE, encoding="utf-8")
    assert read_bounds(path) == ExperimentBounds(
        drive={"reel_m": DriveBounds(-1e-3, 1.3e-3, 0.012, 2.0)},
        states={"sheath.pretension": (10.0, 40.0)},
        limits={"tension_N": (1.0, 100.0)},
        measure={"angle_rad": Measured("angle", 0.01)},
        duration=8.0,
    )


@pytest.mark.parametrize(
    ("line", "instead", "said"),
    [
        ("rate = 0.012", "rat = 0.012", r"unknown key 'rat'; did you mean 'rate'"),
        (", rate = 0.012", "", r"\[drive\] 'reel_m': 'rate' is missing"),
        ("rate = 0.012", "rate = 'fast'", "must be a number, got 'fast'"),
        ("rate = 0.012", "rate = 0", "rate = 0.0 must be > 0"),
        ("low = -1e-3", "low = 2e-3", "low < high must hold"),
        ("dwell = 2", "dwell = -2", r"dwell = -2.0 \[s\] must be ≥ 0"),
        ('"sheath.pretension"', "sheath.pretension", "a name that has a dot in quotes"),
        ("high = 40", "high = inf", "low < high must hold"),
        ("duration = 8.0", "duration = 1" + 400 * "0", "duration: must be less than 1e.100"),
        ("duration = 8.0", "duration = " + 5000 * "[", "nested too deeply"),
        ("low = -1e-3", "low = 0x" + 4000 * "f", "line 4: an integer has 1000 digits or more"),
        ("duration = 8.0", 101 * "a." + "a = 8.0", "bounds.toml, line 2: a key has more than 100"),
        ("high = 40", "high = 1e308", "neither beyond 1e.100"),
        ('sensor = "angle", ', "", r"\[measure\] 'angle_rad': write { sensor"),
        ("noise = 0.01", "noise = 0", r"\[measure\] 'angle_rad': noise must be > 0"),
        ("[states]", "[state]", "unknown key 'state'; did you mean 'states'"),
        ("duration = 8.0", "duration = '8'", "duration: must be a number"),
        ("duration = 8.0", "duration = ", "bounds.toml: not TOML: Invalid value"),
    ],
)
def test_a_broken_file_is_refused_with_the_place(line, instead, said, tmp_path) -> None:
    path = tmp_path / "bounds.toml"
    path.write_text(FILE.replace(line, instead), encoding="utf-8")
    with pytest.raises(TendonError, match=said):
        read_bounds(path)


def test_a_file_that_is_not_there_is_refused(tmp_path) -> None:
    with pytest.raises(TendonError, match=r"none\.toml"):
        read_bounds(tmp_path / "none.toml")


def test_a_file_that_is_not_utf8_is_refused_with_the_place(tmp_path) -> None:
    path = tmp_path / "bounds.toml"
    path.write_text(FILE.replace("sheath", "gaîne"), encoding="latin-1")
    with pytest.raises(RecordingError, match=r"bounds\.toml, row 6, column 1: .* is not UTF-8"):
        read_bounds(path)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither")
def test_pipes_and_devices_are_refused_and_not_opened(tmp_path) -> None:
    pipe, zeros = tmp_path / "pipe.toml", tmp_path / "zeros.toml"
    os.mkfifo(pipe)
    zeros.symlink_to("/dev/zero")
    for path in (pipe, zeros):
        with pytest.raises(RecordingError, match=rf"{path.name}: a device or pipe"):
            read_bounds(path)


def test_nothing_that_moves_is_no_experiment() -> None:
    with pytest.raises(InvalidValueError, match="nothing would move"):
        ExperimentBounds(drive={})


def test_a_further_sensor_needs_its_noise_and_a_column_of_its_own() -> None:
    drive = {"reel_m": DriveBounds(-1e-3, 1e-3, 0.01)}
    with pytest.raises(InvalidValueError, match="'angle_rad': its noise must be stated"):
        ExperimentBounds(drive=drive, measure={"angle_rad": Measured("angle")})
    again = bounds(measure={TENSION: Measured("output_tension", 0.1)})
    with pytest.raises(InvalidValueError, match="the recordings have this column already"):
        again.check(record("a", {}, {}), {})


@pytest.mark.parametrize(
    ("within", "said"),
    [
        ({"measure": {"angle_rad": Measured("angel", 0.01)}}, "'angel'"),
        ({"measure": {"angle": Measured("output_tension", 0.01)}}, "angle"),
        ({"states": {"sheath.axial_stiffness": (-10.0, 3.0)}}, "sheath.axial_stiffness"),
        ({"duration": 1e-6}, "bounds"),
    ],
)
def test_bounds_without_any_recording_of_the_model_are_refused_at_once(within, said) -> None:
    time = np.arange(0.0, 1.0, 0.01)
    there = Recording(
        name="there",
        model="bench",
        source="made",
        time=time,
        columns={DRIVE: 1e-3 * np.sin(time), TENSION: np.zeros(time.size)},
        drive={DRIVE: "reel"},
        measured={TENSION: Measured("output_tension", 0.1)},
    )
    check_bounds([there], bounds())
    with pytest.raises(InvalidValueError, match=said):
        check_bounds([there], bounds(**within))
