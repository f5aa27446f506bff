"""The rig with one capstan: its simulation obeys the capstan law, and the plugin's models agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.one_capstan import (
    BEND,
    FRICTION,
    NOISE_ANGLE,
    NOISE_TENSION,
    PLAY,
    PRETENSION,
    PULLEY,
    RATE,
    SPRING,
    build,
    record,
    simulate,
)
from tendon_mj import replay_recording

TIME = np.arange(0.0, 2.0, 1.0 / RATE)
MOTOR = 50.0 * np.sin(4.0 * TIME)  # [deg]
TRUTH = {
    f"{cable}_sheath.{name}": value
    for cable in ("agonist", "antagonist")
    for name, value in (("backlash", PLAY), ("friction", FRICTION), ("pretension", PRETENSION))
}


@pytest.fixture(scope="module")
def readings():
    return simulate(TIME, MOTOR)


def test_the_motor_crosses_half_the_play_before_anything_moves(readings):
    ahead = 0.008 * np.radians(MOTOR) < 0.5 * PLAY
    before = int(np.argmin(ahead))
    np.testing.assert_allclose(readings[:before, 0], PRETENSION, rtol=1e-9)
    assert readings[before + 1, 0] > PRETENSION + 0.1


def test_at_the_end_of_a_slow_stroke_both_cables_have_slid_and_carry_the_spring():
    time = np.arange(0.0, 4.0, 1.0 / RATE)
    agonist, antagonist, wrist = simulate(time, 10.0 * time)[-1]
    at_joint = agonist * np.exp(-FRICTION * BEND), antagonist * np.exp(FRICTION * BEND)
    spring = SPRING * np.radians(wrist) / PULLEY
    assert at_joint[0] - at_joint[1] == pytest.approx(spring, abs=0.02 * PRETENSION)


@pytest.mark.parametrize("way", ["reel", "prescribed"])
def test_the_plugin_s_model_at_the_truth_is_nearer_than_the_noise(readings, way):
    shown = replay_recording(
        replace(record("loops", TIME, MOTOR, readings, way, "wrist"), settle=0.5),
        build(way).compile(),
        parameters=TRUTH,
    )
    noise = {"agonist_N": NOISE_TENSION, "antagonist_N": NOISE_TENSION}
    noise["wrist_rad"] = np.radians(NOISE_ANGLE)
    for k, (column, level) in enumerate(noise.items()):
        truth = np.radians(readings[:, k]) if column == "wrist_rad" else readings[:, k]
        error = float(np.sqrt(np.mean((shown.columns[column] - truth) ** 2)))
        assert error < 0.4 * level
