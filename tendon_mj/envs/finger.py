"""Environments on the finger for dm_control: its physics, and tasks in it."""

from __future__ import annotations

import mujoco
import numpy as np
from dm_control.mujoco import Physics, wrapper
from dm_control.rl import control
from dm_env import specs

from tendon_mj.envs import tasks
from tendon_mj.envs.scene import build_scene
from tendon_mj.models import TENDONS, Finger


class FingerPhysics(tasks.SimulatedFinger, Physics):  # type: ignore[misc]  # dm_control is not typed
    """The finger between dm_control's `MjModel` and `MjData`.

    All state of the sheaths is in `plugin_state`, which dm_control's resets, copies and pickles
    carry along.
    """

    @classmethod
    def of(cls, finger: Finger) -> FingerPhysics:
        """Physics of a finger with these numbers."""
        physics: FingerPhysics = cls.from_model(wrapper.MjModel(build_scene(finger)))
        return physics

    @property
    def native(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data."""
        return self.model.ptr, self.data.ptr

    def rebuild(self, finger: Finger) -> None:
        """Replace the model by that of a finger with other numbers; the state is reset."""
        self._reload_from_model(wrapper.MjModel(build_scene(finger)))


class _ControlTask(control.Task):  # type: ignore[misc]  # dm_control is not typed
    """The part of a task that dm_control alone requires."""

    def action_spec(self, physics: FingerPhysics) -> specs.BoundedArray:
        """Two numbers between −1 and 1."""
        return specs.BoundedArray((len(TENDONS),), np.float64, -1.0, 1.0, name="spools")

    def get_termination(self, physics: FingerPhysics) -> None:
        """Episodes end by time alone."""


class _HoldForce(tasks.HoldForce, _ControlTask):
    """`HoldForce` for dm_control."""


class _FollowTrajectory(tasks.FollowTrajectory, _ControlTask):
    """`FollowTrajectory` for dm_control."""


def hold_force(
    *,
    seed: int | None = None,
    finger: Finger | None = None,
    ranges: tasks.Ranges | None = None,
    time_limit: float = 4.0,
) -> control.Environment:
    """Hold a force of the tip on the object: `HoldForce` as a `dm_env.Environment`.

    Args:
        seed: of all that is drawn.
        finger: its numbers, those that the ranges do not draw.
        ranges: to draw from.
        time_limit: of an episode [s].
    """
    return _environment(_HoldForce, seed, finger, ranges, time_limit)


def follow_trajectory(
    *,
    seed: int | None = None,
    finger: Finger | None = None,
    ranges: tasks.Ranges | None = None,
    time_limit: float = 6.0,
) -> control.Environment:
    """Follow a joint trajectory: `FollowTrajectory` as a `dm_env.Environment`; see `hold_force`."""
    return _environment(_FollowTrajectory, seed, finger, ranges, time_limit)


def _environment(
    kind: type[tasks.FingerTask],
    seed: int | None,
    finger: Finger | None,
    ranges: tasks.Ranges | None,
    time_limit: float,
) -> control.Environment:
    random = np.random.RandomState(seed)
    task = kind(finger or Finger(), ranges or tasks.Ranges(), random)
    return control.Environment(
        FingerPhysics.of(task.finger),
        task,
        time_limit=time_limit,
        control_timestep=tasks.CONTROL_TIMESTEP,
    )
