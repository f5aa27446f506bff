"""Steps of the reference: overshoot and rise time in each direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.force_servo.linear_theory import mode, overshoot, speed_after_backlash
from experiments.force_servo.servo_bench import Servo, ServoResponse, run_servo
from tendon_mj.models import Bench

LOW, MIDDLE, HIGH = 40.0, 60.0, 80.0  # tensions between which the steps go [N]
_REST = 12.0  # duration of every part of a run, times ω of the slower mode [-]
_RAMP = 5.0  # duration of a slow approach over that of the other parts [-]


@dataclass(frozen=True)
class StepResponse:
    """Response to a step of the reference, simulated and by the linear theory.

    Attributes:
        direction: +1 pulling, −1 loosening.
        reversed: whether the motor came from the other direction and has the backlash to cross.
        overshoot, predicted_overshoot: over the step [-].
        rise: time from 10 % to 90 % [s].
        delay: time to 10 % [s].
        response: from the step on.
    """

    direction: int
    reversed: bool
    overshoot: float
    predicted_overshoot: float
    rise: float
    delay: float
    response: ServoResponse


def step_response(bench: Bench, servo: Servo, direction: int, *, reverse: bool) -> StepResponse:
    """Simulate one step of 20 N to ``MIDDLE``.

    Args:
        bench, servo: parameters.
        direction: +1 pulling, −1 loosening.
        reverse: whether the start was approached from the other direction. If not, all of the
            tendon already slides in the direction of the step.
    """
    slow = min(mode(bench, servo, way).frequency for way in (1, -1))
    rest = round(_REST / slow / bench.timestep)
    start = LOW if direction > 0 else HIGH
    below, above = start - 15.0, start + 15.0
    turn = above if (direction < 0) != reverse else below
    ramp = np.linspace(turn, start, round(_RAMP * rest))
    lead = np.concatenate([np.linspace(bench.pretension, turn, rest), np.full(rest, turn), ramp])
    run = run_servo(bench, servo, np.concatenate([lead, np.full(rest, MIDDLE)]))
    response = run.part(len(lead) * bench.timestep, np.inf)
    first = response.output_tension[0]
    share = (response.output_tension - first) / (MIDDLE - first)
    begun, risen = int(np.argmax(share >= 0.1)), int(np.argmax(share >= 0.9))
    ahead, speed = mode(bench, servo, direction), 0.0
    if reverse:
        speed = speed_after_backlash(bench, servo, direction, start, abs(MIDDLE - start))
    return StepResponse(
        direction,
        reverse,
        max(0.0, float(share.max()) - 1.0),
        overshoot(ahead.damping, speed) if ahead.damping <= 1.0 else 0.0,
        (risen - begun) * bench.timestep,
        begun * bench.timestep,
        response,
    )
