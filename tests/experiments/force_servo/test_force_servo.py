"""The force servo: linear theory, steps, limit cycle, tracking, and the command."""

import dataclasses
import json

import numpy as np
import pytest

from experiments.force_servo.__main__ import force_servo
from experiments.force_servo.describing_function import predict_amplitude
from experiments.force_servo.limit_cycle import FREQUENCY, limit_cycle, tuned
from experiments.force_servo.linear_theory import (
    mode,
    overshoot,
    rise_time,
    step_error,
    with_damping,
    with_scheduled_gains,
)
from experiments.force_servo.servo_bench import Servo, run_servo
from experiments.force_servo.staircase import LEVELS
from experiments.force_servo.step_response import step_response
from experiments.force_servo.study import BENCH, output_held
from experiments.force_servo.tracking import strategies

STIFF = output_held(BENCH)


def test_damping_and_frequency_are_those_of_the_paper():
    servo = Servo()
    pull, loose = mode(BENCH, servo, 1), mode(BENCH, servo, -1)
    assert pull.slope == pytest.approx(pull.frequency / (2.0 * pull.damping))
    ratio = np.sqrt(pull.stiffness / loose.stiffness)
    assert loose.damping == pytest.approx(pull.damping * ratio)
    assert mode(BENCH, with_damping(BENCH, servo, 1.0), 1).damping == pytest.approx(1.0)
    assert mode(STIFF, servo, 1).damping > 1.0 > mode(STIFF, servo, -1).damping
    assert STIFF.pretension + min(LEVELS) > 0.0  # never slack
    both = with_scheduled_gains(STIFF, with_damping(STIFF, servo, 1.0))
    assert [mode(STIFF, both, way).damping for way in (1, -1)] == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("zeta", [0.2, 0.6, 0.9])
def test_overshoot_from_rest_is_the_textbook_s(zeta):
    assert overshoot(zeta) == pytest.approx(np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)), rel=1e-4)
    assert overshoot(zeta, speed=0.5) > overshoot(zeta)
    assert rise_time(zeta) < rise_time(1.0)
    assert overshoot(1.0) == 0.0
    phase = np.linspace(0.0, 10.0, 101)
    np.testing.assert_allclose(step_error(1.0, phase), np.exp(-phase) * (1.0 + phase), atol=1e-5)


@pytest.mark.parametrize("reverse", [False, True])
def test_pulling_is_damped_and_loosening_overshoots_as_predicted(reverse):
    servo = with_damping(STIFF, Servo(), 1.0)
    pull, loose = (step_response(STIFF, servo, way, reverse=reverse) for way in (1, -1))
    assert pull.overshoot < 0.005
    assert loose.overshoot == pytest.approx(loose.predicted_overshoot, rel=0.2)
    better = step_response(STIFF, with_scheduled_gains(STIFF, servo), -1, reverse=reverse)
    assert better.overshoot < 0.1 * loose.overshoot
    assert better.rise < loose.rise


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


@pytest.mark.long
def test_the_study_meets_its_figures(tmp_path):
    force_servo(tmp_path)
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    steps = result["overshoot"]
    assert steps["pulling"] < 0.005
    assert steps["loosening"] == pytest.approx(steps["loosening_predicted"], rel=0.2)
    assert steps["scheduled_difference_cut"] > 0.9
    assert steps["scheduled_rise_ratio_loosening"] <= 1.0
    assert all(abs(e) < 0.02 for e in result["phase_plane"]["slope_error"].values())
    assert result["limit_cycle"]["r_squared"] > 0.98
    assert abs(result["limit_cycle"]["intercept_over_mean_amplitude"]) < 0.05
    assert result["tracking"]["rmse_reduction"] > 0.88
    for picture in ("fig6_phase_plane", "fig7_steps", "limit_cycle", "strategies"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000
