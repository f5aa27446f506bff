"""A rehearsal is a replay with the effect, and with the noise that the description states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis import rehearse
from tendon_mj.lab.recordings import Measured
from tendon_mj.lab.replay import replay_recording
from tests.lab.replay.rigs import TENSION, bench
from tests.refusals import refusing

NOISE = 0.05
MOTION = replace(bench("plan"), measured={TENSION: Measured("output_tension", NOISE)})


@pytest.mark.parametrize(
    ("effects", "parameters"),
    [
        ({}, {}),
        ({"backlash": 2e-4}, {"sheath.backlash": 2e-4}),
        ({"friction": 0.3}, {"sheath.friction": 0.3}),
        ({"output_tension.offset": 1.5}, {"output_tension.offset": 1.5}),
        (
            {"velocity_weakening": 0.1, "sheath.stribeck_velocity": 1e-3},
            {"sheath.stribeck_friction": 0.1, "sheath.stribeck_velocity": 1e-3},
        ),
    ],
)
def test_readings_are_those_of_the_effect_and_the_noise(effects, parameters):
    (made,), planted = rehearse([MOTION], effects)
    assert planted == parameters
    truth = replay_recording(MOTION, parameters=parameters)
    noise = made.columns[TENSION] - truth.columns[TENSION]
    assert noise.std() == pytest.approx(NOISE, rel=4.0 / np.sqrt(2.0 * noise.size))
    (other,), _ = rehearse([MOTION], effects, seed=1)
    assert not np.array_equal(made.columns[TENSION], other.columns[TENSION])
    driven = next(iter(MOTION.drive))
    assert np.array_equal(made.columns[driven], MOTION.columns[driven])
    assert made.known == MOTION.known


@pytest.mark.parametrize(
    ("effects", "error", "told"),
    [
        (
            {"sensor_bias": 1.0},
            InvalidValueError,
            ("output_tension.offset", "input_tension.offset"),
        ),
        ({"slip": 1e-4}, InvalidValueError, ("'slip'", "reel.slip")),
        ({"joint_stiffnes": 1.0}, UnknownNameError, ("joint_stiffnes", "joint_stiffness")),
    ],
)
def test_an_effect_needs_one_place(effects, error, told):
    columns = {**MOTION.columns, "input_tension_N": np.zeros(MOTION.time.size)}
    measured = {**MOTION.measured, "input_tension_N": Measured("input_tension", NOISE)}
    with refusing(error, *told):
        rehearse([replace(MOTION, columns=columns, measured=measured)], effects)


def test_noise_that_nothing_tells_has_to_be_stated():
    with refusing(RecordingError, TENSION, "noise"):
        rehearse([bench("plan")], {})
