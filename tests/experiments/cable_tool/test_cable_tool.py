"""The cable tool: recordings, transmission, fit, and the command."""

import dataclasses
import json
import os
from pathlib import Path

import numpy as np
import pytest

import experiments.cable_tool.__main__ as program
from experiments.cable_tool.__main__ import cable_tool
from experiments.cable_tool.candidates import CANDIDATES, CHOSEN
from experiments.cable_tool.cross_validation import cross_validate, root_mean_square
from experiments.cable_tool.fit import fit_tool
from experiments.cable_tool.load_share import load_share
from experiments.cable_tool.recording import read_folder
from experiments.cable_tool.report import TORQUE_ASKED
from experiments.cable_tool.tool import rate_ratios
from experiments.cable_tool.transmission import predict_load
from tendon_mj import theory
from tendon_mj.errors import InvalidValueError
from tests.experiments.cable_tool.synthetic import TOOL, made_up, suite
from tests.refusals import refusing

NEVER = 1e6  # a take-up so long that the cable never comes to slide [rad]


def test_without_constants_it_is_the_play_operator_of_the_theory():
    recording = made_up(0.06)
    tension = 0.08 + 0.03 * np.sin(recording.time)
    recording = dataclasses.replace(recording, input_torque=tension)
    load = predict_load(recording, 0.3, 0.0, 0.0, 0.0, NEVER)
    expected = theory.output_tension(tension, 0.3, load[0])
    np.testing.assert_allclose(load, expected, rtol=1e-12)


@pytest.mark.parametrize("take_up", [0.05, 0.1, 0.3, NEVER])
def test_the_load_stays_between_the_lines_of_the_directions_at_any_rate(take_up):
    """And far from a reversal on the line of its own."""
    recording, slow = made_up(0.06), made_up(0.06, seconds_per_period=12.0)
    strokes = recording.strokes
    load, slowly = (predict_load(r, 0.4, 0.03, -0.05, 0.01, take_up) for r in (recording, slow))
    np.testing.assert_allclose(slowly, load)
    drive = recording.input_torque + 0.01 * strokes.excursion
    line = (drive - 0.03) * np.exp(-0.4)
    assert np.all(load >= line - 1e-12)
    assert np.all(load <= (drive + 0.05) * np.exp(0.4) + 1e-12)
    far = (strokes.travel > 0.4) & (strokes.direction < 0.0) & (strokes.excursion > -0.48)
    if take_up <= 0.1:
        np.testing.assert_allclose(load[far], line[far], atol=1e-6)


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


def test_planted_numbers_come_back(recordings, fitted):
    for name, within in PLANTED.items():
        assert getattr(fitted, name) == pytest.approx(getattr(TOOL, name), abs=within), name
    share = load_share(recordings, "straight")
    assert share.exponent == pytest.approx(TOOL.friction_exponent, abs=0.01)
    assert share.radius_ratio == pytest.approx(1.0, abs=0.01)
    assert share.constant_friction == pytest.approx(0.038, abs=0.001)
    bent = load_share(recordings, "pitch5")
    assert bent.exponent == pytest.approx(0.42 + 0.05 * np.pi / 3, abs=0.01)
    slow = made_up(0.06, seconds_per_period=12.0)
    (pair,) = rate_ratios([slow, made_up(0.06)])  # of friction that does not depend on the rate
    assert pair.speeds[1] == pytest.approx(3.0 * pair.speeds[0], rel=0.05)
    assert abs(pair.change) < 0.01


def test_the_measured_output_has_no_part_in_a_prediction(recordings, fitted):
    for recording in recordings:
        planted = -0.055 if recording.roll else -0.045 - 0.004 * recording.pitch / (np.pi / 6)
        assert fitted.opening(recording) == pytest.approx(planted, abs=0.002)
        blind = dataclasses.replace(
            recording, load=np.full_like(recording.load, np.nan), output_angle=recording.time * 0.0
        )
        np.testing.assert_array_equal(fitted.load(blind), fitted.load(recording))
        np.testing.assert_array_equal(fitted.angle(blind), fitted.angle(recording))


def test_a_load_and_a_pose_that_were_left_out_are_predicted(recordings):
    chosen = next(c for c in CANDIDATES if c.name == CHOSEN)
    with refusing(InvalidValueError, "takes two"):
        cross_validate(chosen, [made_up(0.06)], "load")
    for left_out in ("load", "pose"):
        errors = cross_validate(chosen, recordings, left_out)
        assert {one.name for one in errors} == {r.name for r in recordings}
        assert max(one.torque for one in errors) < 2.5e-3
        assert max(one.angle for one in errors if one.angle is not None) < np.radians(0.25)


def test_constant_friction_alone_explains_no_sheath_friction_and_none_is_found_in_it(recordings):
    constant = next(c for c in CANDIDATES if "λ = 0" in c.name).fit(recordings)
    errors = [root_mean_square(constant.load(r) - r.load) for r in recordings]
    assert np.mean(errors) > 5e-3
    plain = TOOL.replaced({"friction_exponent": 0.0, "wrist_friction": 0.0})
    recordings = suite(plain)
    assert fit_tool(recordings).friction_exponent == pytest.approx(0.0, abs=0.02)
    assert load_share(recordings, "straight").exponent == pytest.approx(0.0, abs=0.01)


@pytest.mark.long
def test_everything_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(program, "read_folder", lambda folder: suite())
    cable_tool(tmp_path, tmp_path / "out", resamples=2)
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    assert len(result["numbers"]) == 8
    assert set(result["held_out"]) == {candidate.name for candidate in CANDIDATES}
    assert result["held_out"][CHOSEN]["pose"]["groups"]["pitch"]["torque"]["mean"] < 3e-3
    assert len(result["held_out"][CHOSEN]["load"]["recordings"]) == len(suite())
    assert {share["pose"] for share in result["load_share"]} == {r.pose for r in suite()}
    page = (tmp_path / "out" / "table.md").read_text("utf-8")
    assert "published neural network" in page
    assert "nan" not in page
    for name in ("sheath_friction", "prediction", "held_out", "residual"):
        assert (tmp_path / "out" / f"{name}.png").stat().st_size > 10_000


@pytest.mark.long
def test_loads_and_poses_left_out_of_the_measured_data_meet_what_was_asked():
    folder = Path(os.environ.get("TENDON_MJ_DATA", "")) / "cable_tool"
    if "TENDON_MJ_DATA" not in os.environ or not folder.is_dir():
        pytest.skip("TENDON_MJ_DATA names no folder with cable_tool (see docs/data.md)")
    recordings = read_folder(folder)
    chosen = next(c for c in CANDIDATES if c.name == CHOSEN)
    for left_out, groups in (("load", ("straight",)), ("pose", ("pitch", "roll"))):
        errors = cross_validate(chosen, recordings, left_out)
        for group in groups:
            mine = [one.torque for one in errors if one.group == group]
            assert np.mean(mine) < TORQUE_ASKED, group
