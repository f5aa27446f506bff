"""The rig starts with the tensions that were read, whatever its numbers are."""

import numpy as np
import pytest

from experiments.measured_joint.recording import REELS, TENSIONS
from experiments.measured_joint.wound_in import WoundIn
from tests.experiments.measured_joint.synthetic import PLANTED, blank


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"sheath_1.friction": 0.0, "sheath_2.friction": 0.6},
        {"sheath_1.axial_stiffness": 200.0, "sheath_2.axial_stiffness": 200.0},
        {"sheath_1.sheath_compliance": 1e-3},
        {"sheath_1.creep": 0.5, "sheath_1.creep_time": 1.0},
        {"input_tension_1.offset": 1.0, "input_tension_2.scale": 0.9},
    ],
)
def test_the_first_sample_reads_what_was_recorded(changed):
    recordings = [blank(b, 8) for b in (0, 240)]
    (answers,) = WoundIn(recordings)([{**PLANTED, **changed}])
    for recording, series in zip(recordings, answers, strict=True):
        for column in TENSIONS:
            assert series[column][0] == pytest.approx(recording.columns[column][0], abs=0.05)


def test_friction_holds_tension_back_so_that_less_tendon_is_wound_in():
    simulator = WoundIn([blank(180, 8)])
    wound = simulator._wind_in(
        [{**PLANTED, **{f"sheath_{k}.friction": mu for k in (1, 2)}} for mu in (0.0, 0.2, 0.4)]
    )
    assert np.all(np.diff(wound[:, 0], axis=0) < 0.0)


def test_without_friction_the_tendon_is_a_spring():
    stiffness = PLANTED["sheath_1.axial_stiffness"]
    plain = {**PLANTED, "sheath_1.friction": 0.0, "sheath_2.friction": 0.0}
    (wound,) = WoundIn([blank(120, 8)])._wind_in([plain])
    # L = 1 m, pretension 0.2 N: what was S long carries 5 N
    unstretched = 1.0 / (1.0 + 0.2 / stiffness)
    assert wound[0] == pytest.approx(unstretched - 1.0 / (1.0 + 5.0 / stiffness), rel=1e-3)


def test_the_same_in_longer_steps():
    simulator = WoundIn([blank(120)])
    fine, coarse = (s([PLANTED])[0][0] for s in (simulator, simulator.in_steps(2.0)))
    assert np.abs(fine["joint_rad"] - coarse["joint_rad"]).max() < np.radians(0.5)
    assert len(REELS) == len(TENSIONS)
