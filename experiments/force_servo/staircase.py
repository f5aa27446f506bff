"""Fig. 7 of the paper: six steps of the reference, up and down again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.force_servo.linear_theory import with_damping
from experiments.force_servo.servo_bench import Servo, ServoResponse, run_servo
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

LEVELS = (0.0, 20.0, 40.0, 60.0, 40.0, 20.0, 0.0)  # above the pretension [N]


@dataclass(frozen=True)
class Staircase:
    """Six steps with the gains of the paper, and with those critical for pulling.

    Attributes:
        bench: λ = 1.5, its output held by the sensor alone.
        paper, critical: servos.
        paper_response, critical_response: theirs.
        time: of one level [s].
    """

    bench: Bench
    paper: Servo
    critical: Servo
    paper_response: ServoResponse
    critical_response: ServoResponse
    time: float

    def overshoots(self, response: ServoResponse) -> FloatArray:
        """Overshoot of each of the six steps over its height [-]."""
        results = []
        for k in range(1, len(LEVELS)):
            height = LEVELS[k] - LEVELS[k - 1]
            tension = response.part(k * self.time, (k + 1) * self.time).output_tension
            goal = self.bench.pretension + LEVELS[k]
            results.append(max(0.0, float(np.max((tension - goal) / height))))
        return np.array(results)


def simulate_staircase(bench: Bench, servo: Servo, time: float = 4.0) -> Staircase:
    """Simulate the six steps; the paper's tensions count from the pretension, as in its (27).

    Args:
        bench: with its output held.
        servo: with the gains of the paper.
        time: of one level [s].
    """
    reference = np.repeat(bench.pretension + np.array(LEVELS), round(time / bench.timestep))
    critical = with_damping(bench, servo, 1.0)
    return Staircase(
        bench,
        servo,
        critical,
        run_servo(bench, servo, reference),
        run_servo(bench, critical, reference),
        time,
    )
