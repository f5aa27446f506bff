"""Cost of a step with sheaths over one of the same model with MuJoCo's own tendons."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.lab.finger import Trajectory, prepare_finger
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.lab.verification.mujoco_tendon import (
    mujoco_tendon_bench,
    mujoco_tendon_finger,
    without_tension_sensors,
)
from tendon_mj.lab.verification.timing import Spread, processor_time, times_in_turns
from tendon_mj.models import Bench, Finger, build_bench, build_finger
from tendon_mj.typing import FloatArray

_BENCH_STEPS = 8000
_TRAVEL = 1e-3  # of the reel [m]


@dataclass(frozen=True)
class StepCost:
    """Processor time of a step, in rounds that each time both models.

    Attributes:
        steps: (rounds,) with sheaths [s].
        reference_steps: (rounds,) of the same model without [s].
    """

    steps: FloatArray
    reference_steps: FloatArray

    @property
    def step(self) -> float:
        """Median with sheaths [s]."""
        return float(np.median(self.steps))

    @property
    def reference_step(self) -> float:
        """Median without sheaths [s]."""
        return float(np.median(self.reference_steps))

    @property
    def ratios(self) -> Spread:
        """Cost of a step over that of the reference, of each round [-]."""
        return Spread.of(self.steps / self.reference_steps)

    @property
    def ratio(self) -> float:
        """Median of the ratios [-]."""
        return self.ratios.median

    @property
    def added(self) -> Spread:
        """Cost that the sheaths add to a step, of each round [s]."""
        return Spread.of(self.steps - self.reference_steps)

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "ratio": self.ratio,
            "quartiles": self.ratios.result()["quartiles"],
            "step_s": self.step,
            "reference_step_s": self.reference_step,
            "added_s": self.added.result(),
            "rounds": len(self.steps),
        }


@dataclass(frozen=True)
class TimedRun:
    """A model, the data that it starts from, and its (steps, nu) controls."""

    model: mujoco.MjModel
    data: mujoco.MjData
    controls: FloatArray


def run_along(spec: mujoco.MjSpec, wave: FloatArray) -> TimedRun:
    """A run in which every actuator of a model follows ``wave``, (steps,)."""
    model = spec.compile()
    return TimedRun(model, mujoco.MjData(model), np.tile(wave[:, None], (1, model.nu)))


def step_times(runs: Sequence[TimedRun], rounds: int) -> FloatArray:
    """(rounds, runs) processor time of a step [s]; every round makes each run once."""
    starts = [full_state(run.model, run.data)[None] for run in runs]

    def roll(k: int) -> None:
        rollout_sensors(runs[k].model, [runs[k].data], starts[k], runs[k].controls[None])

    tasks = [functools.partial(roll, k) for k in range(len(runs))]
    spent = times_in_turns(tasks, rounds, processor_time)
    return spent / [len(run.controls) for run in runs]


def step_cost(run: TimedRun, reference: TimedRun, *, rounds: int = 7) -> StepCost:
    """Time two runs in turns, and divide by their steps."""
    spent = step_times((run, reference), rounds)
    return StepCost(spent[:, 0], spent[:, 1])


def bench_step_cost(bench: Bench, *, rounds: int = 7) -> StepCost:
    """Step cost of the bench while its reel moves all the time: the tendon slides and turns back.

    Args:
        bench: its parameters.
        rounds: of which the median counts.
    """
    wave = _TRAVEL * np.sin(np.linspace(0.0, 4.0 * np.pi, _BENCH_STEPS))
    specs = (without_tension_sensors(build_bench(bench)), mujoco_tendon_bench(bench))
    return step_cost(*(run_along(spec, wave) for spec in specs), rounds=rounds)


def finger_step_cost(
    trajectory: Trajectory,
    finger: Finger | None = None,
    *,
    friction: float | None = None,
    rounds: int = 7,
) -> StepCost:
    """Step cost of the finger along a trajectory.

    Args:
        trajectory: to follow.
        finger: its parameters; default: those of the package's model.
        friction: μ of every sheath in place of the finger's [-].
        rounds: of which the median counts.
    """
    finger = finger or Finger()
    model = without_tension_sensors(build_finger(finger)).compile()
    reference = mujoco_tendon_finger(finger).compile()
    adjusted, controls = prepare_finger(trajectory, model, finger, friction=friction)
    free, same_controls = prepare_finger(trajectory, reference, finger)
    return step_cost(
        TimedRun(adjusted.model, adjusted.data, controls),
        TimedRun(free.model, free.data, same_controls),
        rounds=rounds,
    )
