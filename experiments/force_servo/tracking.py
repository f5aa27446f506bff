"""Tracking a sine of output tension: strategies against the open-loop inverse without friction."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.linear_theory import with_damping
from experiments.force_servo.servo_bench import Servo, ServoResponse, run_servo
from tendon_mj.lab.bench_comparison import run_bench
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

MEAN, AMPLITUDE, FREQUENCY = 40.0, 15.0, 0.25  # of the reference [N], [N], [Hz]
GAIN = 140.0  # G_t of the tracking servo: 20 times that of Fig. 7, ω = 28 rad/s [-]
_LEAD, _PERIODS, _SKIPPED = 2.0, 3, 1.0 / 3.0  # ramp to the mean [s], sine, share not rated
WRONG = 0.2  # relative error of μ


@dataclass(frozen=True)
class Tracking:
    """Response and error of each strategy.

    Attributes:
        time, reference: [s], T_r [N].
        frictionless: T_out when an ideal reel follows the inverse of a sheath without friction [N].
        responses: by strategy.
        rmse: root mean square error of T_out by strategy, ``frictionless`` among them [N].
    """

    time: FloatArray
    reference: FloatArray
    frictionless: FloatArray
    responses: dict[str, ServoResponse]
    rmse: dict[str, float]

    def reduction(self, strategy: str) -> float:
        """Reduction of the RMSE against the frictionless open-loop inverse [-]."""
        return 1.0 - self.rmse[strategy] / self.rmse["frictionless"]


def strategies(bench: Bench, servo: Servo) -> dict[str, Servo]:
    """Servos that are compared, by name; ``servo`` is the plain one."""
    forward = dataclasses.replace(
        servo,
        backlash_feedforward=1.0,
        rate_feedforward=1.0,
        output_stiffness=bench.output_stiffness,
    )
    observed = dataclasses.replace(forward, feedback="observer")
    more, less = (1.0 + WRONG) * bench.friction, (1.0 - WRONG) * bench.friction
    return {
        "plain": servo,
        "backlash": dataclasses.replace(forward, rate_feedforward=None),
        "feedforward": forward,
        "feedforward_friction_high": dataclasses.replace(forward, observer_friction=more),
        "feedforward_friction_low": dataclasses.replace(forward, observer_friction=less),
        "observer": dataclasses.replace(servo, feedback="observer"),
        "observer_feedforward": observed,
        "observer_feedforward_friction_high": dataclasses.replace(observed, observer_friction=more),
        "observer_feedforward_friction_low": dataclasses.replace(observed, observer_friction=less),
    }


def track(bench: Bench, servo: Servo) -> Tracking:
    """Simulate the tracking of one sine with every strategy.

    The inverse without friction, ξ_in = (T_r − T_0)(1/k_e + 1/k_s + L/EA), is given a reel that
    follows it exactly, so that friction is its only error.
    """
    fast = with_damping(bench, dataclasses.replace(servo, tension_gain=GAIN), 1.0)
    lead = round(_LEAD / bench.timestep)
    count = round(_PERIODS / FREQUENCY / bench.timestep)
    phase = 2.0 * np.pi * FREQUENCY * bench.timestep * np.arange(count)
    ramp = np.linspace(bench.pretension, MEAN, lead)
    reference: FloatArray = np.concatenate([ramp, MEAN + AMPLITUDE * np.sin(phase)])
    rated = slice(lead + round(_SKIPPED * count), None)
    compliance = 1.0 / bench.output_stiffness + bench.length / bench.axial_stiffness
    open_loop = run_bench(bench, (reference - bench.pretension) * compliance).output_tension
    responses = {
        name: run_servo(bench, variant, reference)
        for name, variant in strategies(bench, fast).items()
    }
    outputs = {"frictionless": open_loop}
    outputs |= {name: response.output_tension for name, response in responses.items()}
    rmse = {
        name: float(np.sqrt(np.mean((output - reference)[rated] ** 2)))
        for name, output in outputs.items()
    }
    time: FloatArray = bench.timestep * np.arange(len(reference), dtype=np.float64)
    return Tracking(time, reference, open_loop, responses, rmse)
