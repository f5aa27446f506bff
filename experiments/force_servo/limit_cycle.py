"""The limit cycle of a lightly damped servo against the equivalent backlash.

Every case has the same ω and ζ for pulling, so that only the sheath differs.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.bench import Response, Servo, run_servo
from experiments.force_servo.describing_function import balance
from experiments.force_servo.linear import damped, transmission
from tendon_mj import theory
from tendon_mj.builders.bench import Bench
from tendon_mj.progress import Progress, silent
from tendon_mj.replay.rollout import Array

DAMPING = 0.2  # ζ while pulling: light enough for a cycle, which ζ ≥ 0.35 does not have [-]
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
class Cycle:
    """One limit cycle.

    Attributes:
        varied: which parameter differs from the middle case.
        bench: its numbers.
        backlash: ξ_B of the closed form, pulling [m].
        amplitude: half of what ξ_in travels to and fro [m].
        predicted_amplitude: by the describing function; 0 where it has no cycle [m].
        response: the last part of the run.
    """

    varied: str
    bench: Bench
    backlash: float
    amplitude: float
    predicted_amplitude: float
    response: Response


@dataclass(frozen=True)
class Cycles:
    """Limit cycles, and the line through them.

    Attributes:
        cycles: every case.
        factor, intercept: amplitude = factor ξ_B + intercept, least squares [-], [m].
        r_squared: of that line.
    """

    cycles: tuple[Cycle, ...]
    factor: float
    intercept: float
    r_squared: float

    def columns(self) -> tuple[Array, Array, Array]:
        """ξ_B, amplitude, predicted amplitude [m]."""
        rows = [(c.backlash, c.amplitude, c.predicted_amplitude) for c in self.cycles]
        backlash, amplitude, predicted = np.array(rows).T
        return backlash, amplitude, predicted


def tuned(bench: Bench, servo: Servo, frequency: float, damping: float) -> Servo:
    """The servo with G_t and G_v such that it has this ω [rad/s] and ζ while pulling."""
    stiffness = transmission(bench, 1)
    gain = frequency**2 * servo.inertia / (stiffness * servo.radius**2)
    return damped(bench, dataclasses.replace(servo, tension_gain=gain), damping)


def limit_cycle(bench: Bench, servo: Servo, varied: str, damping: float = DAMPING) -> Cycle:
    """Start the motor off its balance, and see what amplitude it comes to."""
    tuned_servo = tuned(bench, servo, FREQUENCY, damping)
    backlash = float(
        theory.equivalent_backlash(
            bench.exponent, bench.pretension, bench.axial_stiffness, bench.length
        )
    )
    kick = 2.5 * backlash / servo.radius * FREQUENCY
    reference = np.full(round(_TIME / bench.timestep), bench.pretension)
    run = run_servo(bench, tuned_servo, reference, speed=kick)
    last = run.part((1.0 - _KEPT) * _TIME, np.inf)
    return Cycle(
        varied,
        bench,
        backlash,
        float(np.ptp(last.angle)) / 2.0 * servo.radius,
        balance(bench, tuned_servo, backlash),
        last,
    )


def _changed(bench: Bench, name: str, value: float) -> Bench:
    if name == "exponent":
        return dataclasses.replace(bench, friction=value / bench.bend)
    if name == "pretension":
        return dataclasses.replace(bench, pretension=value)
    return dataclasses.replace(bench, axial_stiffness=value)


def limit_cycles(bench: Bench, servo: Servo, progress: Progress = silent) -> Cycles:
    """Vary λ, T_0 and EA, and fit amplitude against ξ_B."""
    middle = dataclasses.replace(bench, friction=1.0 / bench.bend)
    cases = []
    for name, values in VARIED.items():
        for value in values:
            cases.append((name, _changed(middle, name, value)))
    found = []
    for k, (name, case) in enumerate(cases):
        progress("limit cycles", k, len(cases))
        found.append(limit_cycle(case, servo, name))
    progress("limit cycles", len(cases), len(cases))
    backlash = np.array([c.backlash for c in found])
    amplitude = np.array([c.amplitude for c in found])
    factor, intercept = np.polyfit(backlash, amplitude, 1)
    left = amplitude - factor * backlash - intercept
    r_squared = 1.0 - float(np.sum(left**2) / np.sum((amplitude - amplitude.mean()) ** 2))
    return Cycles(tuple(found), float(factor), float(intercept), r_squared)
