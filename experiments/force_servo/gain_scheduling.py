"""Gains scheduled on the direction, against one set of gains that is critical for pulling."""

from __future__ import annotations

from dataclasses import dataclass

from experiments.force_servo.linear_theory import with_damping, with_scheduled_gains
from experiments.force_servo.servo_bench import Servo
from experiments.force_servo.step_response import StepResponse, step_response
from tendon_mj.models import Bench


@dataclass(frozen=True)
class GainScheduling:
    """Steps of a servo critical for pulling, without and with scheduled gains.

    Attributes:
        bench: of all steps.
        plain, scheduled: servos.
        plain_steps, scheduled_steps: pulling and loosening, the tendon already sliding that way,
            then both after a reversal.
    """

    bench: Bench
    plain: Servo
    scheduled: Servo
    plain_steps: tuple[StepResponse, ...]
    scheduled_steps: tuple[StepResponse, ...]

    def difference_cut(self, reverse: bool) -> float:
        """Share of the difference of overshoot between directions that the schedule removes [-]."""
        spread = [
            abs(pull.overshoot - loose.overshoot)
            for steps in (self.plain_steps, self.scheduled_steps)
            for pull, loose in [[s for s in steps if s.reversed == reverse]]
        ]
        return 1.0 - spread[1] / spread[0]


def compare_gains(bench: Bench, servo: Servo) -> GainScheduling:
    """Simulate steps in both directions, each with and without a reversal before."""
    plain = with_damping(bench, servo, 1.0)
    scheduled = with_scheduled_gains(bench, plain)

    def steps(variant: Servo) -> tuple[StepResponse, ...]:
        cases = [(reverse, direction) for reverse in (False, True) for direction in (1, -1)]
        return tuple(step_response(bench, variant, way, reverse=reverse) for reverse, way in cases)

    return GainScheduling(bench, plain, scheduled, steps(plain), steps(scheduled))
