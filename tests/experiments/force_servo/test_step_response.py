"""Steps overshoot as the linear theory predicts."""

import numpy as np
import pytest

from experiments.force_servo.linear_theory import mode, with_damping, with_scheduled_gains
from experiments.force_servo.servo_bench import Servo
from experiments.force_servo.staircase import LEVELS
from experiments.force_servo.step_response import step_response
from experiments.force_servo.study import BENCH, output_held

STIFF = output_held(BENCH)


@pytest.mark.parametrize("reverse", [False, True])
def test_pulling_is_damped_and_loosening_overshoots_as_predicted(reverse):
    servo = with_damping(STIFF, Servo(), 1.0)
    pull, loose = (step_response(STIFF, servo, way, reverse=reverse) for way in (1, -1))
    assert pull.overshoot < 0.005
    assert loose.overshoot == pytest.approx(loose.predicted_overshoot, rel=0.2)
    better = step_response(STIFF, with_scheduled_gains(STIFF, servo), -1, reverse=reverse)
    assert better.overshoot < 0.1 * loose.overshoot
    assert better.rise < loose.rise


def test_the_paper_s_gains_are_overdamped_pulling_and_overshoot_loosening():
    servo = Servo()
    assert mode(STIFF, servo, 1).damping > 1.0 > mode(STIFF, servo, -1).damping
    levels = STIFF.pretension + np.array(LEVELS)
    assert levels.min() > 0.0  # never slack
