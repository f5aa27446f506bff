"""Feed-forward reduces the tracking error."""

import dataclasses

import numpy as np

from experiments.force_servo.linear_theory import with_damping
from experiments.force_servo.servo_bench import Servo, run_servo
from experiments.force_servo.study import BENCH
from experiments.force_servo.tracking import strategies

QUICK = dataclasses.replace(BENCH, mass=0.05, timestep=3e-4, guides=8)


def test_feedforward_tracks_what_friction_would_spoil():
    servo = with_damping(QUICK, Servo(tension_gain=140.0), 1.0)
    time = QUICK.timestep * np.arange(round(8.0 / QUICK.timestep))
    sine = 40.0 + 15.0 * np.sin(0.5 * np.pi * (time - 2.0))
    reference = np.where(time < 2.0, 20.0 + 10.0 * time, sine)
    errors = {}
    for name, variant in strategies(QUICK, servo).items():
        late = run_servo(QUICK, variant, reference).part(4.0, np.inf)
        errors[name] = np.sqrt(np.mean((late.output_tension - late.reference) ** 2))
    assert errors["backlash"] < 0.75 * errors["plain"]
    assert errors["feedforward"] < 0.1 * errors["plain"]
    assert errors["observer_feedforward"] < 0.1 * errors["plain"]
    assert errors["feedforward_friction_low"] < errors["plain"]
    assert errors["feedforward_friction_high"] < errors["plain"]
