"""Bounds of a rig: what they refuse, their file, and motions that stay within them."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.experiment import (
    SHAPES,
    DriveBounds,
    ExperimentBounds,
    check_bounds,
    motion_at,
    read_bounds,
)
from tendon_mj.lab.recordings import Measured
from tests.lab.experiment_design.rig import DRIVE, TENSION, bounds, record
from tests.lab.recorded import recorded
from tests.refusals import refusing

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


def test_bounds_of_a_column_are_in_the_unit_of_its_name(tmp_path) -> None:
    path = tmp_path / "bounds.toml"
    text = FILE.replace(
        "reel_m = { low = -1e-3, high = 1.3e-3, rate = 0.012",
        "reel_mm = { low = -1, high = 1.5, rate = 12",
    )
    text = text.replace(
        "tension_N = { low = 1, high = 100", "tension_kN = { low = 0.25, high = 0.5"
    )
    text = text.replace(
        'angle_rad = { sensor = "angle", noise = 0.01', 'angle_mrad = { sensor = "angle", noise = 8'
    )
    path.write_text(text, encoding="utf-8")
    read = read_bounds(path)
    assert read.drive == {"reel_m": DriveBounds(-1e-3, 1.5e-3, 0.012, 2.0)}
    assert read.limits == {"tension_N": (250.0, 500.0)}
    assert read.measure == {"angle_rad": Measured("angle", 0.008)}


@pytest.mark.parametrize(
    ("line", "instead", "place", "fault"),
    [
        ("rate = 0.012", "rat = 0.012", "[drive] 'reel_m'", "did you mean 'rate'"),
        (", rate = 0.012", "", "[drive] 'reel_m'", "'rate' is missing"),
        ("rate = 0.012", "rate = 'fast'", "[drive] 'reel_m', rate", "'fast'"),
        ("rate = 0.012", "rate = 0", "[drive] 'reel_m'", "rate = 0.0"),
        ("low = -1e-3", "low = 2e-3", "[drive] 'reel_m'", "low < high must hold"),
        ("dwell = 2", "dwell = -2", "[drive] 'reel_m'", "dwell = -2.0 [s]"),
        ('"sheath.pretension"', "sheath.pretension", "[states] 'sheath'", "is quoted"),
        ("high = 40", "high = inf", "[states] 'sheath.pretension'", "high = inf"),
        ('sensor = "angle", ', "", "[measure] 'angle_rad'", "'sensor' is missing"),
        ("noise = 0.01", "noise = 0", "[measure] 'angle_rad'", "noise = 0.0"),
        ("[states]", "[state]", "bounds.toml", "did you mean 'states'"),
        ("duration = 8.0", "duration = '8'", "bounds.toml, duration", "'8'"),
        ("duration = 8.0", "duration = ", "bounds.toml", "not TOML: Invalid value"),
        ("sheath", "ga\u00eene", "bounds.toml, row 6, column 1", "not UTF-8"),
    ],
)
def test_a_broken_file_is_refused_with_the_place(line, instead, place, fault, tmp_path) -> None:
    path = tmp_path / "bounds.toml"
    path.write_text(FILE.replace(line, instead), encoding="latin-1")
    with refusing(TendonError, str(path), place, fault):
        read_bounds(path)


def test_bounds_need_a_drive_and_the_noise_of_a_further_sensor() -> None:
    with refusing(InvalidValueError, "nothing would move"):
        ExperimentBounds(drive={})
    drive = {"reel_m": DriveBounds(-1e-3, 1e-3, 0.01)}
    with refusing(InvalidValueError, "'angle_rad': its noise must be stated"):
        ExperimentBounds(drive=drive, measure={"angle_rad": Measured("angle")})
    again = bounds(measure={TENSION: Measured("output_tension", 0.1)})
    with refusing(InvalidValueError, "the recordings have this column already"):
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
    there = recorded(
        time,
        {DRIVE: ("reel", 1e-3 * np.sin(time))},
        {TENSION: ("output_tension", 0.1)},
        name="there",
    )
    check_bounds([there], bounds())
    with pytest.raises(InvalidValueError, match=said):
        check_bounds([there], bounds(**within))


INTERVAL = 0.004
RANDOM = np.random.default_rng(0)
POINTS = [*RANDOM.random((40, 5)), np.zeros(5), np.ones(5)]
BOUNDS = [
    (DriveBounds(-1e-3, 1.3e-3, 12e-3, 1.0), 0.0, 8.0),
    (DriveBounds(100.0, 101.0, 50.0), 100.3, 3.0),
    (DriveBounds(-60.0, 60.0, 4.0, 20.0), -60.0, 10.0),  # too slow to cross its range in time
    (DriveBounds(-1.0, 1.0, 1e-3), 0.0, 2.0),  # by far
    (DriveBounds(-8e-4, 8e-4, 1e-6, 1.0), 0.0, 4.0),
]


@pytest.mark.parametrize("shape", range(len(SHAPES)))
@pytest.mark.parametrize(("bounds", "start", "duration"), BOUNDS)
def test_a_motion_keeps_to_its_range_and_its_rate_and_reverses(
    shape: int, bounds: DriveBounds, start: float, duration: float
) -> None:
    time = np.arange(round(duration / INTERVAL) + 1) * INTERVAL
    for point in POINTS:
        first = (shape + 0.5) / len(SHAPES)
        motion = motion_at(np.array([first, *point[1:]]), bounds, start, duration, INTERVAL)
        assert motion.shape == SHAPES[shape]
        series = motion.series(time)
        slack = 1e-9 * (bounds.high - bounds.low)
        assert series[0] == pytest.approx(start)
        assert bounds.low - slack <= series.min()
        assert series.max() <= bounds.high + slack
        assert np.abs(np.diff(series)).max() <= 1.01 * bounds.rate * INTERVAL
        ways = np.sign(np.diff(series))
        assert {-1.0, 1.0} <= set(ways), "it goes both ways"
        assert motion.dwell <= bounds.dwell
        assert "between" in motion.words("m", duration)


def test_a_rest_lasts_as_long_as_it_says() -> None:
    bounds = DriveBounds(-1.0, 1.0, 10.0, 0.5)
    motion = motion_at(np.array([0.1, 1.0, 0.0, 1.0, 1.0]), bounds, 0.0, 10.0, INTERVAL)
    time = np.arange(0.0, 10.0, INTERVAL)
    still = np.diff(motion.series(time)) == 0.0
    turns = np.flatnonzero(np.diff(still.astype(int)) != 0)
    rests = np.diff(turns)[::2] * INTERVAL
    assert motion.dwell == 0.5
    np.testing.assert_allclose(rests[rests > 0.1], 0.5, atol=3 * INTERVAL)


@pytest.mark.parametrize(("shape", "rests"), [("ramps", 6), ("stairs", 12), ("growing", 12)])
def test_the_numbers_of_a_motion_end_where_it_reverses_too_seldom_or_too_fast(
    shape: str, rests: int
) -> None:
    def at(*numbers: float):
        first = (SHAPES.index(shape) + 0.5) / len(SHAPES)
        bounds = DriveBounds(0.0, 1.0, 1e3, 1e3)
        return motion_at(np.array([first, *numbers]), bounds, 0.0, 8.0, INTERVAL)

    slow, fast = at(0.0, 0.0, 0.0, 0.25), at(1.0, 0.0, 1.0, 1.0)
    assert slow.high - slow.low == pytest.approx(0.1), "of the range, at least"
    assert 4.0 * 0.1 / slow.rate == pytest.approx(4.0), "to and fro and to in half of the time"
    assert (fast.high - fast.low) / fast.rate == pytest.approx(4.0 * INTERVAL, rel=0.01)
    assert fast.dwell == pytest.approx(8.0 / rests, rel=0.01)
    assert slow.dwell == 0.0 < at(0.0, 0.0, 0.0, 0.35).dwell
    levels = {"ramps": 2, "stairs": 5, "growing": 8}
    assert len({*fast._levels()}) == levels[shape]
