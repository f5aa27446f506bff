"""Laws of the limit cycle."""

import dataclasses

import pytest

from experiments.force_servo.describing_function import predict_amplitude
from experiments.force_servo.limit_cycle import FREQUENCY, limit_cycle, tuned
from experiments.force_servo.servo_bench import Servo
from experiments.force_servo.study import BENCH

QUICK = dataclasses.replace(BENCH, mass=0.05, timestep=3e-4, guides=8)


def test_a_limit_cycle_is_proportional_to_the_backlash_and_dies_with_damping():
    bench = dataclasses.replace(QUICK, friction=1.0 / QUICK.bend)
    small, large = (
        limit_cycle(dataclasses.replace(bench, pretension=tension), Servo(), "pretension")
        for tension in (15.0, 30.0)
    )
    assert large.backlash == pytest.approx(2.0 * small.backlash)
    assert large.amplitude == pytest.approx(2.0 * small.amplitude, rel=0.01)
    assert small.predicted_amplitude == pytest.approx(small.amplitude, rel=0.12)
    calm = limit_cycle(bench, Servo(), "", damping=1.0)
    assert calm.amplitude < 0.02 * calm.backlash
    assert predict_amplitude(bench, tuned(bench, Servo(), FREQUENCY, 1.0), calm.backlash) == 0.0
