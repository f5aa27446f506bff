"""Limit cycle of a lightly damped servo against the equivalent backlash.

Every case has the same ω and ζ for pulling, so that only the sheath differs.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.describing_function import predict_amplitude
from experiments.force_servo.linear_theory import transmission_stiffness, with_damping
from experiments.force_servo.servo_bench import Servo, ServoResponse, run_servo
from tendon_mj import theory
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

DAMPING = 0.2  # ζ while pulling [-]: there is a cycle; with ζ ≥ 0.35 there is none
FREQUENCY = 6.0  # ω while pulling [rad/s]
_TIME = 25.0  # of a run; the amplitude is that of its last part [s]
_KEPT = 0.4
# name -> values, one varied at a time about λ = 1, T_0 = 20 N, EA = 20 kN
VARIED: dict[str, tuple[float, ...]] = {
    "exponent": (0.5, 0.75, 1.0, 1.25, 1.5),
    "pretension": (10.0, 15.0, 30.0, 40.0),
    "axial_stiffness": (10e3, 14e3, 28e3, 40e3),
}


@dataclass(frozen=True)
class LimitCycle:
    """Limit cycle on one bench.

    Attributes:
        varied: parameter that differs from the middle case.
        bench: its parameters.
        backlash: ξ_B of the closed form, pulling [m].
        amplitude: half the range of ξ_in [m].
        predicted_amplitude: by the describing function; 0 if that has no cycle [m].
        response: the last part of the run.
    """

    varied: str
    bench: Bench
    backlash: float
    amplitude: float
    predicted_amplitude: float
    response: ServoResponse


@dataclass(frozen=True)
class LimitCycles:
    """Limit cycles of several benches, and the straight line through them.

    Attributes:
        cycles: every case.
        factor, intercept: amplitude = factor ξ_B + intercept, least squares [-], [m].
        r_squared: of that line.
    """

    cycles: tuple[LimitCycle, ...]
    factor: float
    intercept: float
    r_squared: float

    def columns(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Columns of ξ_B, amplitude and predicted amplitude, each (cycles,) [m]."""
        rows = [(c.backlash, c.amplitude, c.predicted_amplitude) for c in self.cycles]
        backlash, amplitude, predicted = np.array(rows).T
        return backlash, amplitude, predicted


def tuned(bench: Bench, servo: Servo, frequency: float, damping: float) -> Servo:
    """Servo with the G_t and G_v for which it has this ω [rad/s] and ζ [-] while pulling."""
    stiffness = transmission_stiffness(bench, 1)
    gain = frequency**2 * servo.inertia / (stiffness * servo.radius**2)
    return with_damping(bench, dataclasses.replace(servo, tension_gain=gain), damping)


def limit_cycle(bench: Bench, servo: Servo, varied: str, damping: float = DAMPING) -> LimitCycle:
    """Simulate the motor from an initial speed until its amplitude no longer changes."""
    tuned_servo = tuned(bench, servo, FREQUENCY, damping)
    backlash = float(
        theory.equivalent_backlash(
            bench.exponent, bench.pretension, bench.axial_stiffness, bench.length
        )
    )
    initial_speed = 2.5 * backlash / servo.radius * FREQUENCY
    reference = np.full(round(_TIME / bench.timestep), bench.pretension)
    run = run_servo(bench, tuned_servo, reference, speed=initial_speed)
    last = run.part((1.0 - _KEPT) * _TIME, np.inf)
    return LimitCycle(
        varied,
        bench,
        backlash,
        float(np.ptp(last.angle)) / 2.0 * servo.radius,
        predict_amplitude(bench, tuned_servo, backlash),
        last,
    )


def _changed(bench: Bench, name: str, value: float) -> Bench:
    if name == "exponent":
        return dataclasses.replace(bench, friction=value / bench.bend)
    if name == "pretension":
        return dataclasses.replace(bench, pretension=value)
    return dataclasses.replace(bench, axial_stiffness=value)


def limit_cycles(bench: Bench, servo: Servo, progress: Progress = silent) -> LimitCycles:
    """Vary λ, T_0 and EA, and fit amplitude against ξ_B."""
    middle = dataclasses.replace(bench, friction=1.0 / bench.bend)
    cases = []
    for name, values in VARIED.items():
        for value in values:
            cases.append((name, _changed(middle, name, value)))
    results = []
    for k, (name, case) in enumerate(cases):
        progress("limit cycles", k, len(cases))
        results.append(limit_cycle(case, servo, name))
    progress("limit cycles", len(cases), len(cases))
    backlash = np.array([c.backlash for c in results])
    amplitude = np.array([c.amplitude for c in results])
    factor, intercept = np.polyfit(backlash, amplitude, 1)
    residual = amplitude - factor * backlash - intercept
    r_squared = 1.0 - float(np.sum(residual**2) / np.sum((amplitude - amplitude.mean()) ** 2))
    return LimitCycles(tuple(results), float(factor), float(intercept), r_squared)
