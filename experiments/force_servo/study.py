"""Study of the force servo as a whole: computes everything, draws nothing."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.gain_scheduling import GainScheduling, compare_gains
from experiments.force_servo.limit_cycle import LimitCycles, limit_cycles
from experiments.force_servo.phase_plane import PhasePlane, simulate_phase_plane
from experiments.force_servo.servo_bench import Servo
from experiments.force_servo.staircase import Staircase, simulate_staircase
from experiments.force_servo.tracking import Tracking, track
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.models import Bench

# The bench at λ = 1.5 with carriages so light, and steps so short, that their inertia and dampers
# do not matter to the servo: with 1 kg the environment's damper alone would add 9 % to ζ.
BENCH = Bench(friction=1.5 / np.pi, mass=0.01, timestep=1e-4)
HELD_STIFFNESS = 1e6  # k_e of an output that is held, so that only the sensor's spring gives [N/m]


@dataclass(frozen=True)
class Study:
    """Findings of the study.

    Attributes:
        gains, gains_output_held: steps with and without scheduled gains, on the bench and with its
            output held by the sensor alone.
        staircase: Fig. 7.
        phase_plane: Fig. 6.
        limit_cycles: of a lightly damped servo.
        tracking: of a sine.
    """

    gains: GainScheduling
    gains_output_held: GainScheduling
    staircase: Staircase
    phase_plane: PhasePlane
    limit_cycles: LimitCycles
    tracking: Tracking


def output_held(bench: Bench) -> Bench:
    """Bench whose output is held by the sensor alone."""
    return dataclasses.replace(bench, environment_stiffness=HELD_STIFFNESS)


def run_study(
    bench: Bench = BENCH, servo: Servo | None = None, progress: Progress = silent
) -> Study:
    """Run every part of the study; about 40 s on two cores.

    Args:
        bench: parameters.
        servo: with the gains of the paper; None takes those.
        progress: called with the stage, the number done and the total.
    """
    servo = servo or Servo()
    parts = 5
    progress("servo", 0, parts)
    gains = compare_gains(bench, servo)
    progress("servo", 1, parts)
    gains_output_held = compare_gains(output_held(bench), servo)
    progress("servo", 2, parts)
    staircase = simulate_staircase(output_held(bench), servo)
    progress("servo", 3, parts)
    phase_plane = simulate_phase_plane(bench, servo)
    progress("servo", 4, parts)
    tracking = track(bench, servo)
    progress("servo", 5, parts)
    # the slow cycles allow heavier carriages, and so longer steps
    slow_bench = dataclasses.replace(bench, mass=0.05, timestep=3e-4)
    cycles = limit_cycles(slow_bench, servo, progress)
    return Study(gains, gains_output_held, staircase, phase_plane, cycles, tracking)
