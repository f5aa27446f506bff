"""Everything that `tendon-mj servo` measures."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.bench import Servo
from experiments.force_servo.limit_cycle import Cycles, limit_cycles
from experiments.force_servo.linear import damped, mode, scheduled
from experiments.force_servo.phase_plane import PhasePlane, phase_plane
from experiments.force_servo.steps import HELD, Staircase, Step, staircase, step
from experiments.force_servo.tracking import Tracking, track
from tendon_mj.builders.bench import Bench
from tendon_mj.progress import Progress, silent

# The bench at λ = 1.5 with carriages so light, and steps so short, that the servo does not feel
# them: with 1 kg the environment's damper alone would add 9 % to ζ.
LIGHT = Bench(friction=1.5 / np.pi, mass=0.01, timestep=1e-4)


@dataclass(frozen=True)
class Steps:
    """The servo critical for pulling, with and without its gains scheduled on direction.

    Attributes:
        bench: where.
        plain, scheduled: the servos.
        plain_steps, scheduled_steps: pulling and loosening from the branch, then after a reversal.
    """

    bench: Bench
    plain: Servo
    scheduled: Servo
    plain_steps: tuple[Step, ...]
    scheduled_steps: tuple[Step, ...]

    def difference_cut(self, reverse: bool) -> float:
        """Share of the difference of overshoot between the directions that the schedule removes."""
        spread = [
            abs(pull.overshoot - loose.overshoot)
            for steps in (self.plain_steps, self.scheduled_steps)
            for pull, loose in [[s for s in steps if s.reversed == reverse]]
        ]
        return 1.0 - spread[1] / spread[0]


def compare_steps(bench: Bench, servo: Servo) -> Steps:
    """Steps in both directions, from the branch and after a reversal."""
    plain = damped(bench, servo, 1.0)
    better = scheduled(bench, plain)

    def steps(variant: Servo) -> tuple[Step, ...]:
        ways = [(reverse, way) for reverse in (False, True) for way in (1, -1)]
        return tuple(step(bench, variant, way, reverse=reverse) for reverse, way in ways)

    return Steps(bench, plain, better, steps(plain), steps(better))


@dataclass(frozen=True)
class Study:
    """What the command shows.

    Attributes:
        steps, held_steps: on the bench, and with its output held by the sensor alone.
        staircase: Fig. 7.
        plane: Fig. 6.
        cycles: limit cycles.
        tracking: of a sine.
    """

    steps: Steps
    held_steps: Steps
    staircase: Staircase
    plane: PhasePlane
    cycles: Cycles
    tracking: Tracking

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        pulling, loosening = self.plane.lines
        _, amplitude, predicted = self.cycles.columns()
        return {
            "overshoot": _overshoots(self.steps),
            "overshoot_held_output": _overshoots(self.held_steps),
            "phase_plane": {
                "slope_error": {"pulling": pulling.error, "loosening": loosening.error},
                "slope": {"pulling": pulling.slope, "loosening": loosening.slope},
            },
            "fig7": _staircase(self.staircase),
            "limit_cycle": {
                "r_squared": self.cycles.r_squared,
                "factor": self.cycles.factor,
                "intercept_m": self.cycles.intercept,
                "intercept_over_mean_amplitude": self.cycles.intercept / float(amplitude.mean()),
                "describing_function_mean_ratio": float(np.mean(predicted / amplitude)),
                "describing_function_max_error": float(np.max(np.abs(predicted / amplitude - 1.0))),
            },
            "tracking": {
                "rmse_reduction": self.tracking.reduction("feedforward"),
                "rmse_N": self.tracking.rmse,
                "reduction": {n: self.tracking.reduction(n) for n in self.tracking.responses},
            },
        }


def _overshoots(steps: Steps) -> dict[str, object]:
    pull, loose, pull_back, loose_back = steps.plain_steps
    found: dict[str, object] = {
        "pulling": pull.overshoot,
        "loosening": loose.overshoot,
        "loosening_predicted": loose.predicted_overshoot,
        "pulling_after_reversal": pull_back.overshoot,
        "loosening_after_reversal": loose_back.overshoot,
        "loosening_after_reversal_predicted": loose_back.predicted_overshoot,
        "scheduled_difference_cut": steps.difference_cut(False),
        "scheduled_difference_cut_after_reversal": steps.difference_cut(True),
    }
    for name, plain, better in zip(
        ("pulling", "loosening", "pulling_after_reversal", "loosening_after_reversal"),
        steps.plain_steps,
        steps.scheduled_steps,
        strict=True,
    ):
        found[f"scheduled_{name}"] = better.overshoot
        found[f"scheduled_rise_ratio_{name}"] = better.rise / plain.rise
    return found


def _staircase(found: Staircase) -> dict[str, object]:
    modes = {way: mode(found.bench, found.paper, way).damping for way in (1, -1)}
    return {
        "damping": {"pulling": modes[1], "loosening": modes[-1]},
        "overshoot": found.overshoots(found.paper_response).tolist(),
        "overshoot_critical": found.overshoots(found.critical_response).tolist(),
        "critical_velocity_gain": found.critical.velocity_gain,
        "motor_inertia_kg_m2": found.paper.inertia,
        "radius_m": found.paper.radius,
    }


def study(bench: Bench = LIGHT, servo: Servo | None = None, progress: Progress = silent) -> Study:
    """Run every experiment of the servo."""
    servo = servo or Servo()
    held = dataclasses.replace(bench, environment_stiffness=HELD)
    # the slow cycles stand heavier carriages, and so longer steps
    cycling = dataclasses.replace(bench, mass=0.05, timestep=3e-4)
    parts = ("steps", "steps, output held", "Fig. 7", "Fig. 6", "tracking")

    def tell(k: int) -> None:
        progress("servo", k, len(parts))

    tell(0)
    steps = compare_steps(bench, servo)
    tell(1)
    held_steps = compare_steps(held, servo)
    tell(2)
    stairs = staircase(held, servo)
    tell(3)
    plane = phase_plane(bench, servo)
    tell(4)
    tracking = track(bench, servo)
    tell(5)
    cycles = limit_cycles(cycling, servo, progress)
    return Study(steps, held_steps, stairs, plane, cycles, tracking)
