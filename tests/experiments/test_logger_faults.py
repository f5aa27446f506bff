"""Faults of loggers are named at their place; sound recordings, and slips of a cable, are not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.logger_faults.__main__ import check_clean, check_faulty, faulty
from experiments.logger_faults.faults import FAULTS
from experiments.logger_faults.rigs import CLEAN, MOTIONS, RIGS, record
from tendon_mj import Recording, diagnose
from tendon_mj.lab.data_check import check_recording, timing_warnings
from tests.lab.recorded import recorded

SEED = 401


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("rig", ["reel", "muscle"])
def test_a_fault_is_named_with_its_column_and_row(fault: str, rig: str, tmp_path: Path) -> None:
    case = check_faulty(fault, rig, SEED, tmp_path)
    assert case.named, [warning.sentence for warning in case.warnings]


@pytest.mark.parametrize("rig", CLEAN)
@pytest.mark.parametrize("motion", [*MOTIONS, "points"])
def test_a_sound_recording_is_warned_of_nothing(rig: str, motion: str, tmp_path: Path) -> None:
    """Among them rigs that strike a stop, or stick and slip, and a cable let off for one point."""
    assert check_clean(rig, motion, SEED, tmp_path).warnings == ()


@pytest.mark.parametrize(
    ("fault", "verdict"),
    [
        ("tare", "unknown"),
        ("drive reset", "unknown"),
        ("coarse", "nothing missing"),
        ("coarse unstated", "nothing missing"),
        ("end reached", "nothing missing"),
    ],
)
def test_a_diagnosis_names_no_effect_in_the_place_of_a_fault(
    fault: str, verdict: str, tmp_path: Path
) -> None:
    """A fit sees through some faults; else the fault is the reason why nothing is named."""
    made, _ = faulty(fault, "reel", SEED, tmp_path)
    diagnosis = diagnose([made.recording])
    assert diagnosis.verdict == verdict
    assert not diagnosis.findings
    assert not diagnosis.closest
    (warning,) = [w for w in diagnosis.checks if made.named_by(w)]
    assert warning.blocks == (verdict == "unknown")
    assert (warning.sentence in diagnosis.sentence) == warning.blocks
    assert any(warning.sentence in said for said in diagnosis.warnings)
    assert warning.result() in diagnosis.result()["checks"]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    folder = tmp_path_factory.mktemp("rig")
    return record(RIGS["reel"], np.random.default_rng(8), "sines", folder, "sound")


@pytest.mark.parametrize("slip", [-0.05, 0.08])
def test_a_slip_of_the_cable_is_no_fault(sound: Recording, slip: float) -> None:
    """What the rig saw is what the model makes of a drive that steps; no column alone does."""
    after = np.arange(sound.time.size) > 0.5 * sound.time.size
    drive = sound.columns["spool_rad"]
    moved = replace(sound, columns={**sound.columns, "spool_rad": drive + slip * after})
    shown = check_recording(moved).simulated
    assert shown is not None
    random = np.random.default_rng(9)
    noise = {c: m.noise or 0.01 for c, m in sound.measured.items()}
    read = {c: shown.columns[c] + random.normal(0.0, noise[c], after.size) for c in noise}
    slipped = replace(sound, columns={**sound.columns, **read})
    assert check_recording(slipped).warnings == ()


def test_uneven_times_that_are_right_are_no_fault(sound: Recording) -> None:
    """Samples that were taken when they say so are smooth over time; late stamps are not."""
    random = np.random.default_rng(4)
    even = sound.time
    uneven = even + random.uniform(0.0, 0.6, even.size) * (even[1] - even[0])
    right = {c: np.interp(uneven, even, series) for c, series in sound.columns.items()}
    assert timing_warnings(replace(sound, time=uneven, columns=right)) == []
    (warning,) = timing_warnings(replace(sound, time=uneven))
    assert warning.identifier == "uneven_times"


@pytest.mark.parametrize("turns", [False, True])
def test_a_gap_blocks_where_the_drive_turned_in_it(turns: bool) -> None:
    time = np.concatenate([np.arange(0.0, 3.0, 0.01), np.arange(3.5, 6.0, 0.01)])
    course = np.abs(time - 3.2) if turns else time
    bare = recorded(time, {"reel_m": ("reel", 1e-3 * course)}, {}, name="gap")
    (warning,) = timing_warnings(bare)
    assert (warning.identifier, warning.blocks) == ("gap", turns)
