"""Laws of the transmission: play between two lines, and sliding onto one with travel."""

import dataclasses

import numpy as np
import pytest

from experiments.cable_tool.recording import find_strokes
from experiments.cable_tool.transmission import predict_load
from tendon_mj import theory
from tests.experiments.cable_tool.synthetic import made_up

NEVER = 1e6  # a take-up so long that the cable never comes to slide [rad]


def test_without_constants_it_is_the_play_operator_of_the_theory():
    recording = made_up(0.06)
    tension = 0.08 + 0.03 * np.sin(recording.time)
    recording = dataclasses.replace(recording, input_torque=tension)
    load = predict_load(recording, 0.3, 0.0, 0.0, 0.0, NEVER)
    expected = theory.output_tension(tension, 0.3, load[0])
    np.testing.assert_allclose(load, expected, rtol=1e-12)


@pytest.mark.parametrize("take_up", [0.05, 0.3, NEVER])
def test_the_load_stays_between_the_lines(take_up):
    recording = made_up(0.06)
    load = predict_load(recording, 0.4, 0.03, -0.05, 0.01, take_up)
    drive = recording.input_torque + 0.01 * recording.strokes.excursion
    assert np.all(load >= (drive - 0.03) * np.exp(-0.4) - 1e-12)
    assert np.all(load <= (drive + 0.05) * np.exp(0.4) + 1e-12)


def test_far_from_a_reversal_it_is_on_the_line_of_the_direction():
    recording = made_up(0.06)
    strokes = recording.strokes
    load = predict_load(recording, 0.4, 0.03, -0.05, 0.0, 0.1)
    far = (strokes.travel > 0.4) & (strokes.direction < 0.0) & (strokes.excursion > -0.48)
    line = (recording.input_torque - 0.03) * np.exp(-0.4)
    np.testing.assert_allclose(load[far], line[far], atol=1e-6)


def test_the_prediction_does_not_depend_on_the_rate():
    slow, fast = made_up(0.06, seconds_per_period=12.0), made_up(0.06)
    assert len(slow.time) == len(fast.time)
    arguments = (0.4, 0.03, -0.05, 0.01, 0.2)
    np.testing.assert_allclose(predict_load(slow, *arguments), predict_load(fast, *arguments))


def test_strokes_are_found_through_the_noise_of_an_encoder():
    phase = np.linspace(0.0, 4.0 * np.pi, 2000)
    angle = 0.5 * np.cos(phase) + 4e-4 * np.sign(np.sin(1e3 * phase))
    strokes = find_strokes(angle)
    assert np.count_nonzero(np.diff(strokes.direction)) in (3, 4)
    assert strokes.travel.max() == pytest.approx(1.0, abs=0.01)
    assert np.all(strokes.direction[50:450] == -1.0)
