"""Tasks on the finger: observations, actions and rewards."""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from typing import Any

import numpy as np
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray

from tendon_mj.builders.finger_parameters import JOINTS, TENDONS, Finger
from tendon_mj.environment.physics import FingerPhysics
from tendon_mj.environment.ranges import Ranges
from tendon_mj.errors import InvalidValueError

Array = NDArray[np.float64]
_LEAD = 0.1  # that an agent is told of the trajectory ahead [s]


class FingerTask(control.Task):  # type: ignore[misc]  # dm_control is not typed
    """A task whose episodes each have a friction, pretension and bend of their own.

    Actions are the angles of the two spools between −1 and 1 of their ranges. Without an
    estimate of friction no action sequence suits every episode: that is the point.

    Args:
        finger: whose other numbers it keeps.
        ranges: to draw from.
        seed: of the draws; the same seed gives the same episodes.
    """

    def __init__(self, finger: Finger, ranges: Ranges, seed: int | None) -> None:
        self.finger, self.ranges = dataclasses.replace(finger, bend=ranges.bend[0]), ranges
        self.random = np.random.RandomState(seed)
        self.drawn: dict[str, float] = {}

    def initialize_episode(self, physics: FingerPhysics) -> None:
        """Draw the episode's numbers and begin it with the finger straight and at rest."""
        self.drawn = self.ranges.draw(self.random)
        numbers: dict[str, Any] = dict(self.drawn)
        drawn = dataclasses.replace(self.finger, **numbers)
        low, high = self.ranges.bend
        if low < high:  # otherwise the physics was made with it
            physics.rebuild(dataclasses.replace(self.finger, bend=drawn.bend))
        physics.start(drawn)
        physics.command(np.zeros(len(TENDONS)))

    def action_spec(self, physics: FingerPhysics) -> specs.BoundedArray:
        """Two numbers between −1 and 1."""
        return specs.BoundedArray((len(TENDONS),), np.float64, -1.0, 1.0, name="spools")

    def before_step(self, action: Array, physics: FingerPhysics) -> None:
        """Turn the action into angles of the spools.

        Raises:
            InvalidValueError: the action is not as many numbers as there are tendons.
        """
        try:
            shares = np.asarray(action, float)
        except (TypeError, ValueError, OverflowError):
            shares = np.array(np.nan)
        if shares.shape != (len(TENDONS),) or not np.isfinite(shares).all():
            raise InvalidValueError(
                f"action = {action!r} must be {len(TENDONS)} finite numbers between -1 and 1, of "
                f"{' and '.join(TENDONS)}: shape {(len(TENDONS),)}"
            )
        low, high = physics.command_range()
        physics.command(low + 0.5 * (shares + 1.0) * (high - low))

    def after_step(self, physics: FingerPhysics) -> None:
        """Do nothing: all is set before a step."""

    def get_termination(self, physics: FingerPhysics) -> None:
        """Episodes end by time alone."""
        return

    def get_observation(self, physics: FingerPhysics) -> OrderedDict[str, Array]:
        """Readings of an encoder and a tension sensor on each motor, and the goal.

        `motor_angles` [rad] and `input_tensions` [N] of flexor and extensor, then what the task
        adds. Neither friction nor the tension at the finger is in it.
        """
        seen = OrderedDict[str, Array]()
        seen["motor_angles"] = np.array([physics.sensor(f"{t}_motor_angle") for t in TENDONS])
        seen["input_tensions"] = np.array([physics.sensor(f"{t}_input_tension") for t in TENDONS])
        return seen


class HoldForce(FingerTask):
    """Press the tip on the object with a force that the episode draws, and hold it.

    Reward exp(−((F − F*)/scale)²) per step, from 0 to 1.

    Args:
        force: (low, high) of F* [N].
        scale: by how much off the reward falls to 1/e [N].
        finger, ranges, seed: see `FingerTask`.
    """

    def __init__(
        self,
        finger: Finger,
        ranges: Ranges,
        seed: int | None,
        *,
        force: tuple[float, float] = (0.5, 2.0),
        scale: float = 0.2,
    ) -> None:
        super().__init__(finger, ranges, seed)
        self._forces, self._scale = force, scale
        self.target = force[0]

    def initialize_episode(self, physics: FingerPhysics) -> None:
        """Draw the force besides."""
        super().initialize_episode(physics)
        self.target = float(self.random.uniform(*self._forces))

    def get_observation(self, physics: FingerPhysics) -> OrderedDict[str, Array]:
        """`FingerTask`'s, with `tip_force` and `target_force` [N]."""
        seen = super().get_observation(physics)
        seen["tip_force"] = np.array([physics.sensor("tip_force")])
        seen["target_force"] = np.array([self.target])
        return seen

    def get_reward(self, physics: FingerPhysics) -> float:
        """Reward for a force near its target [–]."""
        off = (physics.sensor("tip_force") - self.target) / self._scale
        return float(np.exp(-(off**2)))


class FollowTrajectory(FingerTask):
    """Follow a smooth joint trajectory that the episode draws; the object is out of the way.

    Every joint goes along a sum of two sines between straight and ``share`` of its range, all in
    proportion, as two tendons can move three joints. Reward exp(−|q − q*|²/scale²) per step.

    Args:
        share: of the joints' ranges that is used [-].
        scale: by how much off the reward falls to 1/e [rad].
        finger, ranges, seed: see `FingerTask`.
    """

    def __init__(
        self,
        finger: Finger,
        ranges: Ranges,
        seed: int | None,
        *,
        share: float = 0.7,
        scale: float = 0.2,
    ) -> None:
        super().__init__(finger, ranges, seed)
        self._scale = scale
        self._pose = share * np.array([joint.high for joint in finger.joints.values()])
        self._waves = np.zeros((2, 2))

    def initialize_episode(self, physics: FingerPhysics) -> None:
        """Draw the trajectory besides."""
        super().initialize_episode(physics)
        frequency = self.random.uniform([0.2, 0.4], [0.4, 0.8])
        self._waves = np.stack([frequency, self.random.uniform(0.2, 0.5, 2)])
        physics.move_object_away()

    def target(self, time: float) -> Array:
        """q* at a time [rad]; straight at the start."""
        frequency, size = self._waves
        share = float(size @ (0.5 - 0.5 * np.cos(2.0 * np.pi * frequency * time)))
        return share * self._pose

    def get_observation(self, physics: FingerPhysics) -> OrderedDict[str, Array]:
        """`FingerTask`'s, with `joint_angles`, `target_angles` and `next_angles` [rad]."""
        seen = super().get_observation(physics)
        now = float(physics.time())
        seen["joint_angles"] = joint_angles(physics)
        seen["target_angles"] = self.target(now)
        seen["next_angles"] = self.target(now + _LEAD)
        return seen

    def get_reward(self, physics: FingerPhysics) -> float:
        """Reward for joints near their targets [–]."""
        off = (joint_angles(physics) - self.target(float(physics.time()))) / self._scale
        return float(np.exp(-(off @ off)))


def joint_angles(physics: Any) -> Array:
    """(3,) angles of MCP, PIP, DIP [rad]."""
    return np.array([physics.sensor(f"{joint}_angle") for joint in JOINTS])
