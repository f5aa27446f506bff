"""Recordings carry the bend that their file's name states; splits keep what is predicted apart."""

import math
from dataclasses import replace

import numpy as np
import pytest

from experiments.measured_joint.recording import (
    COLUMNS,
    REELS,
    bend,
    bound_zeros,
    degrees,
    read_folder,
)
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT, make_splits
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Uncertain
from tests.experiments.measured_joint.synthetic import UNCERTAIN, blank
from tests.refusals import refusing

HEADER = "time_s,command_rad,joint_rad,tension_1_N,tension_2_N\n"


def test_a_folder_is_read_in_the_order_of_the_bend(tmp_path):
    for angle in (120, 0, 60):
        path = tmp_path / f"bend_{angle:03d}deg.csv"
        path.write_text(HEADER + "0.0,0.0,0.0,5.0,5.0\n0.1,0.1,0.0,5.1,4.9\n", "utf-8")
    found = read_folder(tmp_path)
    assert [degrees(r) for r in found] == [0, 60, 120]
    assert bend(found[2]) == pytest.approx(2.0 * math.pi / 3.0)
    for recording in found:
        assert set(recording.measured) == set(COLUMNS)
        assert set(REELS) < set(recording.drive.values())
        assert all(not np.any(recording.columns[f"{reel}_m"]) for reel in REELS)


def test_other_names_are_refused(tmp_path):
    (tmp_path / "straight.csv").write_text(HEADER, "utf-8")
    with refusing(RecordingError, "bend_NNNdeg"):
        read_folder(tmp_path)


def test_nothing_that_is_predicted_is_given():
    splits = make_splits([blank(b, 4) for b in (0, 60, 120, 180, 240)])
    for parts in splits.values():
        for split in parts:
            assert not {r.name for r in split.train} & {r.name for r in split.held_out}
    (between,), (beyond,) = splits[BETWEEN], splits[BEYOND]
    assert [degrees(r) for r in between.held_out] == [60, 180]
    assert [degrees(r) for r in beyond.held_out] == [180, 240]
    assert sorted(degrees(s.held_out[0]) for s in splits[LEFT_OUT]) == [0, 60, 120, 180, 240]


@pytest.mark.parametrize("bends", [(0, 60, 240), (0, 120, 240)])
def test_missing_bends_are_told(bends):
    with refusing(RecordingError, "of other bends are needed"):
        make_splits([blank(b, 4) for b in bends])


def test_no_zero_of_a_load_cell_is_above_its_lowest_reading():
    zero = {"input_tension_1.offset": Uncertain(0.0, -2.0, 2.0)}
    given, unseen = (replace(blank(b, 4), uncertain={**UNCERTAIN, **zero}) for b in (0, 60))
    given = replace(given, columns={**given.columns, "tension_1_N": np.array([5.0, 0.7, 6, 5])})
    for bounded in bound_zeros([given, unseen], [given]):
        assert bounded.uncertain["input_tension_1.offset"] == Uncertain(0.0, -2.0, 0.7)
        assert bounded.uncertain.keys() == given.uncertain.keys()
