"""Laws of a schedule: how long a move between two rests takes, and how many steps are simulated."""

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.replay import Schedule
from tendon_mj.models import load_model
from tests.lab.replay.rigs import joint_recording
from tests.refusals import refusing


@pytest.mark.parametrize(("settling", "move"), [(2.0, 1.0), (20.0, 5.0), (100.0, 10.0)])
def test_a_move_takes_a_quarter_of_the_settling_time_within_1_to_10_seconds(settling, move):
    rests = joint_recording(np.arange(5.0), settling_time=settling)
    clock = Schedule(rests, load_model("joint"), None).clock
    assert np.ptp(clock.time) == pytest.approx(4 * (move + settling))


def test_20_million_steps_are_simulated_and_more_are_not():
    model, made = load_model("joint"), joint_recording()
    Schedule(made, model, 1.8e7 * model.opt.timestep)
    with refusing(RecordingError, "settle"):
        Schedule(made, model, 2.2e7 * model.opt.timestep)
