"""Numbers that were planted come back; a model that lacks the effect says so by its error."""

import dataclasses

import numpy as np
import pytest

from experiments.cable_tool.candidates import CANDIDATES, CHOSEN
from experiments.cable_tool.cross_validation import cross_validate, root_mean_square
from experiments.cable_tool.fit import fit_tool
from experiments.cable_tool.load_share import load_share
from experiments.cable_tool.tool import rate_ratios
from tendon_mj.errors import InvalidValueError
from tests.experiments.cable_tool.synthetic import TOOL, made_up, suite
from tests.refusals import refusing

PLANTED = {
    "friction_exponent": 0.02,
    "wrist_friction": 0.02,
    "closing_offset": 0.002,
    "load_difference": 0.002,
    "stiffness": 0.002,
    "angle_ratio": 0.005,
    "compliance": 0.05,
}


@pytest.fixture(scope="module")
def recordings():
    return suite()


@pytest.fixture(scope="module")
def fitted(recordings):
    return fit_tool(recordings)


@pytest.mark.parametrize(("name", "within"), PLANTED.items())
def test_planted_numbers_come_back(fitted, name, within):
    assert getattr(fitted, name) == pytest.approx(getattr(TOOL, name), abs=within)


def test_the_opening_offset_of_each_recording_is_told_by_its_input_side(recordings, fitted):
    for recording in recordings:
        planted = -0.055 if recording.roll else -0.045 - 0.004 * recording.pitch / (np.pi / 6)
        assert fitted.opening(recording) == pytest.approx(planted, abs=0.002)


def test_the_measured_output_has_no_part_in_a_prediction(recordings, fitted):
    for recording in recordings:
        blind = dataclasses.replace(
            recording, load=np.full_like(recording.load, np.nan), output_angle=recording.time * 0.0
        )
        np.testing.assert_array_equal(fitted.load(blind), fitted.load(recording))
        np.testing.assert_array_equal(fitted.angle(blind), fitted.angle(recording))


def test_a_load_and_a_pose_that_were_left_out_are_predicted(recordings):
    chosen = next(c for c in CANDIDATES if c.name == CHOSEN)
    for left_out in ("load", "pose"):
        errors = cross_validate(chosen, recordings, left_out)
        assert {one.name for one in errors} == {r.name for r in recordings}
        assert max(one.torque for one in errors) < 2.5e-3
        assert max(one.angle for one in errors if one.angle is not None) < np.radians(0.25)


def test_constant_friction_alone_does_not_explain_sheath_friction(recordings):
    constant = next(c for c in CANDIDATES if "λ = 0" in c.name).fit(recordings)
    errors = [root_mean_square(constant.load(r) - r.load) for r in recordings]
    assert np.mean(errors) > 5e-3


def test_without_sheath_friction_none_is_found():
    plain = TOOL.replaced({"friction_exponent": 0.0, "wrist_friction": 0.0})
    recordings = suite(plain)
    assert fit_tool(recordings).friction_exponent == pytest.approx(0.0, abs=0.02)
    assert load_share(recordings, "straight").exponent == pytest.approx(0.0, abs=0.01)


def test_the_load_share_of_a_pose_is_what_was_planted(recordings):
    share = load_share(recordings, "straight")
    assert share.exponent == pytest.approx(TOOL.friction_exponent, abs=0.01)
    assert share.radius_ratio == pytest.approx(1.0, abs=0.01)
    assert share.constant_friction == pytest.approx(0.038, abs=0.001)
    bent = load_share(recordings, "pitch5")
    assert bent.exponent == pytest.approx(0.42 + 0.05 * np.pi / 3, abs=0.01)


def test_friction_that_does_not_depend_on_rate_has_no_rate_ratio():
    slow = made_up(0.06, seconds_per_period=12.0)
    (pair,) = rate_ratios([slow, made_up(0.06)])
    assert pair.speeds[1] == pytest.approx(3.0 * pair.speeds[0], rel=0.05)
    assert abs(pair.change) < 0.01


def test_one_load_cannot_be_left_out():
    with refusing(InvalidValueError, "takes two"):
        cross_validate(CANDIDATES[0], [made_up(0.06)], "load")
