"""Environments on the finger: dm_control tasks with their physics."""

from __future__ import annotations

from dm_control.rl import control

from tendon_mj.builders.finger_parameters import Finger
from tendon_mj.environment.physics import FingerPhysics
from tendon_mj.environment.ranges import Ranges
from tendon_mj.environment.tasks import FingerTask, FollowTrajectory, HoldForce

_CONTROL_TIMESTEP = 0.01  # between two actions [s]


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
    return _environment(HoldForce(finger or Finger(), ranges or Ranges(), seed), time_limit)


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
    return _environment(FollowTrajectory(finger or Finger(), ranges or Ranges(), seed), time_limit)


def _environment(task: FingerTask, time_limit: float) -> control.Environment:
    return control.Environment(
        FingerPhysics.of(task.finger),
        task,
        time_limit=time_limit,
        control_timestep=_CONTROL_TIMESTEP,
    )
