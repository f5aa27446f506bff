"""Laws of the linear theory."""

import numpy as np
import pytest

from experiments.force_servo.linear_theory import (
    mode,
    overshoot,
    rise_time,
    speed_after_backlash,
    step_error,
    with_damping,
    with_scheduled_gains,
)
from experiments.force_servo.servo_bench import Servo
from experiments.force_servo.study import BENCH, output_held

STIFF = output_held(BENCH)


def test_damping_and_frequency_are_those_of_the_paper():
    servo = Servo()
    pull, loose = mode(BENCH, servo, 1), mode(BENCH, servo, -1)
    assert pull.slope == pytest.approx(pull.frequency / (2.0 * pull.damping))
    ratio = np.sqrt(pull.stiffness / loose.stiffness)
    assert loose.damping == pytest.approx(pull.damping * ratio)
    assert mode(BENCH, with_damping(BENCH, servo, 1.0), 1).damping == pytest.approx(1.0)


@pytest.mark.parametrize("zeta", [0.2, 0.6, 0.9])
def test_overshoot_from_rest_is_the_textbook_s(zeta):
    assert overshoot(zeta) == pytest.approx(np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)), rel=1e-4)
    assert overshoot(zeta, speed=0.5) > overshoot(zeta)
    assert rise_time(zeta) < rise_time(1.0)


def test_a_critical_response_never_overshoots_from_rest():
    assert overshoot(1.0) == 0.0
    phase = np.linspace(0.0, 10.0, 101)
    np.testing.assert_allclose(step_error(1.0, phase), np.exp(-phase) * (1.0 + phase), atol=1e-5)


def test_out_of_the_backlash_the_motor_comes_with_speed_but_no_more_than_it_can():
    servo = with_damping(STIFF, Servo(), 1.0)
    limit = 0.5 / mode(STIFF, servo, -1).damping
    assert 0.0 < speed_after_backlash(STIFF, servo, -1, 60.0, 20.0) < limit
    assert speed_after_backlash(STIFF, servo, -1, 90.0, 20.0) > speed_after_backlash(
        STIFF, servo, -1, 30.0, 20.0
    )


def test_scheduled_gains_are_critical_both_ways():
    servo = with_scheduled_gains(STIFF, with_damping(STIFF, Servo(), 1.0))
    assert mode(STIFF, servo, 1).damping == pytest.approx(1.0)
    assert mode(STIFF, servo, -1).damping == pytest.approx(1.0)
