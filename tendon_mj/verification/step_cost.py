"""Cost of a step with sheaths over one of the same model with MuJoCo's own tendons."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.builders.bench import Bench, build_bench
from tendon_mj.builders.finger import build_finger
from tendon_mj.builders.finger_parameters import Finger
from tendon_mj.finger.control import prepare_finger
from tendon_mj.finger.trajectories import Trajectory
from tendon_mj.replay.rollout import Array, full_state, rollout_sensors
from tendon_mj.verification.mujoco_tendon import (
    mujoco_tendon_bench,
    mujoco_tendon_finger,
    without_tension_sensors,
)
from tendon_mj.verification.timing import time_in_turns

_BENCH_STEPS = 8000
_TRAVEL = 1e-3  # of the reel [m]


@dataclass(frozen=True)
class StepCost:
    """Wall time of a step, median over several rounds.

    Attributes:
        step: with sheaths [s].
        reference_step: of the same model with MuJoCo's own tendons [s].
    """

    step: float
    reference_step: float

    @property
    def ratio(self) -> float:
        """Cost of a step over that of the reference [-]."""
        return self.step / self.reference_step


@dataclass(frozen=True)
class TimedRun:
    """A model, the data that it starts from, and its (steps, nu) controls."""

    model: mujoco.MjModel
    data: mujoco.MjData
    controls: Array


def step_cost(run: TimedRun, reference: TimedRun, *, rounds: int = 7) -> StepCost:
    """Time two runs in turns, and divide by their steps."""
    runs = (run, reference)
    starts = [full_state(r.model, r.data)[None] for r in runs]

    def roll(k: int) -> None:
        rollout_sensors(runs[k].model, [runs[k].data], starts[k], runs[k].controls[None])

    spent = time_in_turns([lambda: roll(0), lambda: roll(1)], rounds)
    return StepCost(*(time / len(r.controls) for time, r in zip(spent, runs, strict=True)))


def bench_step_cost(bench: Bench, *, rounds: int = 7) -> StepCost:
    """Step cost of the bench while its reel moves all the time: the tendon slides and turns back.

    Args:
        bench: its parameters.
        rounds: of which the median counts.
    """
    wave = _TRAVEL * np.sin(np.linspace(0.0, 4.0 * np.pi, _BENCH_STEPS))
    runs = []
    for spec in (without_tension_sensors(build_bench(bench)), mujoco_tendon_bench(bench)):
        model = spec.compile()
        controls = np.tile(wave[:, None], (1, model.nu))
        runs.append(TimedRun(model, mujoco.MjData(model), controls))
    return step_cost(*runs, rounds=rounds)


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
