"""Environments on the finger for dm_control: tasks with their physics."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
from dm_control.rl import control
from dm_env import specs

from tendon_mj.envs.physics import FingerPhysics
from tendon_mj.envs.ranges import Ranges
from tendon_mj.envs.tasks import CONTROL_TIMESTEP, FingerTask, FollowTrajectory, HoldForce
from tendon_mj.models import TENDONS, Finger
from tendon_mj.typing import FloatArray


class ControlTask(control.Task):  # type: ignore[misc]  # dm_control is not typed
    """A task of the finger in the form that dm_control asks for.

    Args:
        task: what is observed, done and rewarded.
    """

    def __init__(self, task: FingerTask) -> None:
        self.task = task

    @property
    def drawn(self) -> dict[str, float]:
        """The numbers that the episode drew, by name."""
        return self.task.drawn

    def initialize_episode(self, physics: FingerPhysics) -> None:
        """See `FingerTask`."""
        self.task.initialize_episode(physics)

    def action_spec(self, physics: FingerPhysics) -> specs.BoundedArray:
        """Two numbers between −1 and 1."""
        return specs.BoundedArray((len(TENDONS),), np.float64, -1.0, 1.0, name="spools")

    def before_step(self, action: FloatArray, physics: FingerPhysics) -> None:
        """See `FingerTask`."""
        self.task.before_step(action, physics)

    def get_observation(self, physics: FingerPhysics) -> OrderedDict[str, FloatArray]:
        """See the task."""
        return self.task.get_observation(physics)

    def get_reward(self, physics: FingerPhysics) -> float:
        """See the task."""
        return self.task.get_reward(physics)

    def get_termination(self, physics: FingerPhysics) -> None:
        """Episodes end by time alone."""
        return


def hold_force(
    *,
    seed: int | None = None,
    finger: Finger | None = None,
    ranges: Ranges | None = None,
    time_limit: float = 4.0,
) -> control.Environment:
    """Hold a force of the tip on the object: `HoldForce` as a `dm_env.Environment`.

    Args:
        seed: of all that is drawn.
        finger: its numbers, those that the ranges do not draw.
        ranges: to draw from.
        time_limit: of an episode [s].
    """
    random = np.random.RandomState(seed)
    return _environment(HoldForce(finger or Finger(), ranges or Ranges(), random), time_limit)


def follow_trajectory(
    *,
    seed: int | None = None,
    finger: Finger | None = None,
    ranges: Ranges | None = None,
    time_limit: float = 6.0,
) -> control.Environment:
    """Follow a joint trajectory: `FollowTrajectory` as a `dm_env.Environment`.

    Args:
        seed, finger, ranges, time_limit: see `hold_force`.
    """
    random = np.random.RandomState(seed)
    return _environment(
        FollowTrajectory(finger or Finger(), ranges or Ranges(), random), time_limit
    )


def _environment(task: FingerTask, time_limit: float) -> control.Environment:
    return control.Environment(
        FingerPhysics.of(task.finger),
        ControlTask(task),
        time_limit=time_limit,
        control_timestep=CONTROL_TIMESTEP,
    )
